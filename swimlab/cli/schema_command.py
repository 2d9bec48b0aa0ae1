"""`swimlab schema`."""

import json

from sequences import schema
from swimlab.render.catalogue import technique_settings


def schema_command() -> int:
    """Print the JSON schema of sequence files, with every technique's settings."""

    print(json.dumps(schema(technique_settings()), indent=2))
    return 0
