"""The score table in the terminal."""

from collections.abc import Sequence
from typing import Any

from rich import box
from rich.table import Column, Table

from swimlab.cli.terminal import print_whole
from swimlab.runs.columns import COLUMNS, MARKS, marked, roots
from swimlab.scoring.resolution import LEGEND, MARK, unresolved


def print_scores(all_scores: Sequence[dict[str, Any]]) -> None:
    """Print a table a sequence on stdout: techniques by rows, only the scores there are, `-` for an absent one."""

    for scores in all_scores:
        entries = scores["sequences"]
        shown = {h: c for h, c in COLUMNS.items() if any(c[0] in entry["scores"] for entry in entries)}
        close = {name: unresolved(entries, name) for name, _ in shown.values()}
        title = f"{entries[0]['sequence']}, {scores['provenance']['domain']}: rms radiance; {MARKS}"
        table = Table(Column("technique", no_wrap=True), title=title, box=box.SIMPLE_HEAD, title_justify="left")
        table.caption_justify = "left"
        for heading in shown:
            table.add_column(marked(heading), justify="right")
        for entry in entries:
            unsure = (name for name, _ in shown.values() if entry["technique"] in close[name])
            table.add_row(entry["technique"], *_cells(entry["scores"], shown, set(unsure)))
        table.caption = "\n".join([roots(list(shown)), LEGEND if any(close.values()) else ""]).strip() or None
        print_whole(table)


def _cells(scores: dict[str, float], shown: dict[str, tuple[str, Any]], marked: set[str]) -> list[str]:
    return [
        f"{MARK if name in marked else ''}{show(scores[name]):.4f}" if name in scores else "-"
        for name, show in shown.values()
    ]
