"""`swimlab list`."""

import json
from pathlib import Path
from typing import Annotated, Literal, get_args

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from metrics import METRICS
from metrics.bands import BANDS
from metrics.ocio import space_names, view_names
from sequences import library, load
from swimlab.footage.colour import AS_STORED, SRGB
from swimlab.footage.convention import PRESETS, SOURCES, Convention
from swimlab.render.catalogue import brdfs, techniques
from swimlab.runs.record import RunError

Kind = Literal["techniques", "sequences", "brdfs", "metrics", "conventions", "colorspaces", "views"]

IN_JSON = {"sequences": ("file",), "metrics": ("source", "formula")}
"""Columns that the table of a kind has no room for."""


def list_command(
    kind: Kind | None = None, /, *, json_output: Annotated[bool, Parameter(name="--json", negative="")] = False
) -> int:
    """List what there is to choose from.

    Parameters
    ----------
    kind:
        What to list.
    json_output:
        Print it as JSON instead of a table.
    """
    if kind is None:
        raise RunError(f"list: name what to list: {', '.join(get_args(Kind))}")
    rows = _rows(kind)
    if json_output:
        print(json.dumps(rows, indent=1))
        return 0

    shown = [column for column in rows[0] if column not in IN_JSON.get(kind, ())]
    table = Table(*shown, box=None, pad_edge=False)
    for row in _folded(rows) if kind == "metrics" else rows:
        table.add_row(*(row[column] for column in shown))
    Console().print(table)
    return 0


def _rows(kind: Kind) -> list[dict[str, str]]:
    if kind == "sequences":
        return [_sequence(name, path) for name, path in library().items()]
    if kind == "metrics":
        return [
            {
                "metric": name,
                "unit": metric.unit,
                "better": metric.better,
                "what it says": metric.description,
                "source": metric.source,
                "formula": metric.formula,
            }
            for name, metric in METRICS.items()
        ]
    if kind == "conventions":
        return [_convention(name, convention) for name, convention in PRESETS.items()]
    if kind in ("colorspaces", "views"):
        names = [AS_STORED, SRGB, *space_names()] if kind == "colorspaces" else view_names()
        return [{kind.removesuffix("s"): name} for name in names]

    entries = techniques() if kind == "techniques" else brdfs()
    return [
        {kind.removesuffix("s"): name, "what it is": entry.summary, "source": entry.source}
        for name, entry in entries.items()
    ]


def _sequence(name: str, path: Path) -> dict[str, str]:
    """A sequence of the library; what it is says the comment that its file starts with."""

    sequence = load(name)
    return {
        "sequence": name,
        "motion": sequence.motion.kind,
        "frames": str(sequence.frames),
        "size": "{}x{}".format(*sequence.size),
        "what it is": path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# "),
        "file": str(path),
    }


def _convention(name: str, convention: Convention) -> dict[str, str]:
    """What motion vectors mean under a preset; --motion-... options of the same names change single points."""

    return {
        "convention": name,
        "unit": convention.unit,
        "direction": convention.direction,
        "y": convention.y,
        "scale": "{:g},{:g}".format(*convention.scale),
        "offset": "{:g},{:g}".format(*convention.offset),
        "channels": " or ".join(",".join(pair) for pair in convention.channels),
        "source": SOURCES[name],
    }


def _folded(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Metrics without their variants by band, which are named beside what they are of."""

    names = {row["metric"] for row in rows}
    found = []
    for row in rows:
        whole, _, band = row["metric"].rpartition(".")
        if band in BANDS and whole in names:
            continue
        bands = [f".{band}" for band in BANDS if f"{row['metric']}.{band}" in names]
        also = f"; also {', '.join(bands)}" if bands else ""
        found.append(row | {"what it says": row["what it says"] + also})
    return found
