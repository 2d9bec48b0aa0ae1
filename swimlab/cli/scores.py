"""The score table in the terminal."""

from collections.abc import Sequence
from math import sqrt
from typing import Any

COLUMNS = {
    "rms error": ("budget.mse", sqrt),
    "bias": ("budget.bias", sqrt),
    "detail": ("budget.detail", sqrt),
    "flicker": ("budget.flicker", sqrt),
    "floor": ("budget.floor", sqrt),
    "residual": ("residual.flicker", sqrt),
    "on plane": ("plane.on", float),
    "order 1": ("plane.order1", float),
    "order 2": ("plane.order2", float),
    "scale rmse": ("scale.rmse", float),
    "mean drift %": ("scale.mean_drift", float),
    "highlight": ("scale.highlight", float),
}
"""Heading -> the score behind it and how it is shown; squared radiance is shown as its root, as radiance."""


def print_scores(all_scores: Sequence[dict[str, Any]]) -> None:
    """Print a table a sequence on stdout: techniques by rows, only the scores that there are, `-` for an absent one."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    console = Console(width=max(Console().width, 110))
    for scores in all_scores:
        entries = scores["sequences"]
        shown = {h: c for h, c in COLUMNS.items() if any(c[0] in entry["scores"] for entry in entries)}
        title = f"{entries[0]['sequence']}, {scores['provenance']['domain']}: rms radiance, lower is better"
        table = Table("technique", title=title, box=box.SIMPLE_HEAD, title_justify="left")
        for heading in shown:
            table.add_column(heading, justify="right")
        for entry in entries:
            cells = (_cell(entry["scores"].get(name), show) for name, show in shown.values())
            table.add_row(entry["technique"], *cells)
        console.print(table)


def _cell(value: float | None, show: Any) -> str:
    return "-" if value is None else f"{show(value):.4f}"
