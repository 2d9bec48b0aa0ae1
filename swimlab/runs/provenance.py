"""Where an output comes from: versions, machine, command and date."""

import time
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

SWIMLAB = version("swimlab")
"""The version of swimlab that is installed."""


def provenance(command: str) -> dict[str, Any]:
    """Versions, machine, command and date, which every output carries."""
    from metrics import machine  # metrics is heavy, and the version alone needs none of it

    return {
        "swimlab": SWIMLAB,
        "warp": version("warp-lang"),
        "numpy": version("numpy"),
        "python": machine.python(),
        "machine": f"{machine.system()}, {machine.cores()} cores",
        "command": command,
        "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }


def moment() -> str:
    """The time, UTC, to the microsecond: no two renderings into a folder begin at one."""
    return datetime.now(UTC).isoformat()
