"""`swimlab schema`."""

import json
from typing import Literal

from sequences import schema
from swimlab.footage.shot import shot_schema
from swimlab.gate.rules import gate_schema
from swimlab.render.catalogue import technique_settings
from swimlab.sweep.file import sweep_schema

Kind = Literal["sequence", "shot", "gate", "sweep"]


def schema_command(kind: Kind = "sequence", /) -> int:
    """Print the JSON schema of sequence files, with every technique's settings, or of shot, gate or sweep files.

    Parameters
    ----------
    kind:
        The kind of file.
    """
    made = {
        "sequence": lambda: schema(technique_settings()),
        "shot": shot_schema,
        "gate": gate_schema,
        "sweep": sweep_schema,
    }
    print(json.dumps(made[kind](), indent=2))
    return 0
