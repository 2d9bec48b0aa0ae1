"""`swimlab schema`."""

import json
from typing import Literal

from sequences import schema
from swimlab.footage.shot import shot_schema
from swimlab.render.catalogue import technique_settings


def schema_command(kind: Literal["sequence", "shot"] = "sequence", /) -> int:
    """Print the JSON schema of sequence files, with every technique's settings, or of shot files.

    Parameters
    ----------
    kind:
        The kind of file.
    """

    print(json.dumps(schema(technique_settings()) if kind == "sequence" else shot_schema(), indent=2))
    return 0
