"""A sweep's results in the terminal, one table."""

import json
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Column, Table

from swimlab.cli.terminal import print_whole
from swimlab.runs.columns import COLUMNS, roots
from swimlab.scoring.resolution import LEGEND, MARK, unresolved
from swimlab.sweep.grid import short
from swimlab.sweep.rows import ERRORS, Row, rows_of
from swimlab.sweep.work import Work

SHOWN = (*ERRORS, "budget.flicker", "visible.flicker")
"""Scores that have a column, those that there are."""


def print_sweep(work: Work, scores: Sequence[dict[str, Any]], out: Path) -> None:
    """Print the rows on stdout; what a technique does not depend on is left out of its row."""
    rows = rows_of(work, scores, out)
    there = {score for row in rows for score in row.entry["scores"]} & set(SHOWN)
    headings = [heading for heading, (score, _) in COLUMNS.items() if score in there]
    several = len(work.sweep.sequences) > 1
    title = f"{work.sweep.name}, {work.sweep.domain}: lower is better"
    table = Table(title=title, caption=roots(headings), box=box.SIMPLE_HEAD, title_justify="left")
    names = [short(key) for key in work.sweep.grid]
    keys = names if len(set(names)) == len(names) else list(work.sweep.grid)
    for key in (["sequence"] if several else []) + keys + ["technique"]:
        table.columns.append(Column(key, no_wrap=True))
    for heading in (*headings, "ms a frame"):
        table.add_column(heading, justify="right")
    for _, group in groupby(rows, lambda row: row.shared):
        alike = list(group)
        close = {heading: _close(alike, COLUMNS[heading][0]) for heading in headings}
        if any(close.values()):
            table.caption = f"{roots(headings)}\n{LEGEND}".replace("technique", "row")
        for place, row in enumerate(alike):
            cells = [_shown(row.varied[key]) if key in row.varied else "" for key in work.sweep.grid]
            cells += [row.entry["technique"], *(_cell(row, heading, place in close[heading]) for heading in headings)]
            cells.append("-" if row.ms is None else f"{row.ms:.3g}")
            table.add_row(*([row.source] if several else []), *cells, end_section=place == len(alike) - 1)
    print_whole(table)


def _close(rows: Sequence[Row], score: str) -> set[int]:
    """Places of the rows that a score does not tell from the next better one."""
    found = unresolved([row.entry | {"technique": str(place)} for place, row in enumerate(rows)], score)
    return set(map(int, found))


def _cell(row: Row, heading: str, close: bool) -> str:
    score, show = COLUMNS[heading]
    if score not in row.entry["scores"]:
        return "-"
    return f"{MARK if close else ''}{show(row.entry['scores'][score]):.4f}"


def _shown(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, default=str)
