"""Where an output comes from: versions, machine, command and date."""

import os
import platform
import time
from importlib.metadata import version
from typing import Any

SWIMLAB = version("swimlab")
"""The version of swimlab that is installed."""


def provenance(command: str) -> dict[str, Any]:
    """Versions, machine, command and date, which every output carries."""
    return {
        "swimlab": SWIMLAB,
        "warp": version("warp-lang"),
        "numpy": version("numpy"),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}, {len(os.sched_getaffinity(0))} cores",
        "command": command,
        "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
