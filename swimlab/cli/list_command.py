"""`swimlab list`."""

import json
from typing import Annotated, Literal

from cyclopts import Parameter

Kind = Literal["techniques", "sequences", "brdfs", "metrics"]


def list_command(kind: Kind, /, *, json_output: Annotated[bool, Parameter(name="--json", negative="")] = False) -> int:
    """List what there is to choose from.

    Parameters
    ----------
    kind:
        What to list.
    json_output:
        Print it as JSON instead of a table.
    """
    from rich.console import Console
    from rich.table import Table

    columns, rows = _rows(kind)
    if json_output:
        print(json.dumps([dict(zip(columns, row, strict=True)) for row in rows], indent=1))
        return 0
    table = Table(*columns, box=None, pad_edge=False)
    for row in rows:
        table.add_row(*row)
    Console().print(table)
    return 0


def _rows(kind: Kind) -> tuple[list[str], list[tuple[str, ...]]]:
    if kind == "sequences":
        from sequences import library, load

        found = [(name, load(name)) for name in library()]
        return ["sequence", "motion", "frames", "size", "file"], [
            (name, s.motion.kind, str(s.frames), "{}x{}".format(*s.size), str(library()[name])) for name, s in found
        ]
    if kind == "metrics":
        from metrics import METRICS

        return ["metric", "unit", "better", "what it says"], [
            (name, metric.unit, metric.better, metric.description) for name, metric in METRICS.items()
        ]
    from swimlab.catalogue import brdfs, techniques

    entries = techniques() if kind == "techniques" else brdfs()
    return [kind.removesuffix("s"), "what it is", "source"], [
        (name, entry.summary, entry.source) for name, entry in entries.items()
    ]
