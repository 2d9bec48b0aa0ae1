"""The score table in the terminal."""

from collections.abc import Sequence
from math import sqrt
from typing import Any

from swimlab.resolution import LEGEND, MARK, unresolved

COLUMNS = {
    "rms error": ("budget.mse", sqrt),
    "bias": ("budget.bias", sqrt),
    "detail": ("budget.detail", sqrt),
    "flicker": ("budget.flicker", sqrt),
    "floor": ("budget.floor", sqrt),
    "residual": ("residual.flicker", sqrt),
    "of reference": ("residual.flicker.reference", sqrt),
    "visible": ("visible.flicker", float),
    "quantised": ("quantisation.floor", sqrt),
    "on plane": ("plane.on", float),
    "order 1": ("plane.order1", float),
    "order 2": ("plane.order2", float),
    "scale rmse": ("scale.rmse", float),
    "mean drift %": ("scale.mean_drift", float),
    "highlight": ("scale.highlight", float),
    "FLIP": ("flip.mean", float),
    "FLIP (oiio)": ("flip-oiio.mean", float),
    "JOD": ("vdp.jod", float),
}
"""Heading -> the score behind it and how it is shown; squared radiance is shown as its root, as radiance."""


def print_scores(all_scores: Sequence[dict[str, Any]]) -> None:
    """Print a table a sequence on stdout: techniques by rows, only the scores there are, `-` for an absent one."""
    from rich import box
    from rich.console import Console
    from rich.table import Column, Table

    console = Console(width=max(Console().width, 120))
    for scores in all_scores:
        entries = scores["sequences"]
        shown = {h: c for h, c in COLUMNS.items() if any(c[0] in entry["scores"] for entry in entries)}
        close = {name: unresolved(entries, name) for name, _ in shown.values()}
        title = f"{entries[0]['sequence']}, {scores['provenance']['domain']}: rms radiance, lower is better"
        table = Table(Column("technique", no_wrap=True), title=title, box=box.SIMPLE_HEAD, title_justify="left")
        for heading in shown:
            table.add_column(heading, justify="right")
        for entry in entries:
            marked = (name for name, _ in shown.values() if entry["technique"] in close[name])
            table.add_row(entry["technique"], *_cells(entry["scores"], shown, set(marked)))
        if any(close.values()):
            table.caption = LEGEND
        console.print(table)


def _cells(scores: dict[str, float], shown: dict[str, tuple[str, Any]], marked: set[str]) -> list[str]:
    return [
        f"{MARK if name in marked else ''}{show(scores[name]):.4f}" if name in scores else "-"
        for name, show in shown.values()
    ]
