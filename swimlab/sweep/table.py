"""A sweep's scores as one table: what one picks a setting by."""

import json
from collections.abc import Sequence
from itertools import groupby
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from swimlab.columns import COLUMNS, roots
from swimlab.compare.differences import concerns
from swimlab.record import REFERENCE, Record
from swimlab.resolution import LEGEND, MARK, unresolved
from swimlab.sweep.grid import points, short
from swimlab.sweep.run import Work
from swimlab.terminal import print_whole

ERRORS = ("budget.mse", "scale.rmse")
"""Scores that rows are in the order of: of a clip, and of frames of several sizes."""
SHOWN = (*ERRORS, "budget.flicker", "visible.flicker")
"""Scores that have a column, those that there are."""


class Row(NamedTuple):
    """A distinct result. truth: what the reference depends on, sequence first. varied: what the technique depends on.

    entry: that of scores.json. ms: of a frame, where known.
    """

    truth: str
    source: str
    varied: dict[str, Any]
    entry: dict[str, Any]
    ms: float | None


def rows_of(work: Work, scores: Sequence[dict[str, Any]], out: Path) -> list[Row]:
    """A row for each technique under each combination of the values that concern it.

    Rows of the same sequence under the same reference stand together, the least error first.
    """
    measured = {each["sequences"][0]["sequence"]: each["sequences"] for each in scores}
    found: dict[tuple[str, str, str], Row] = {}
    for (source, values), plan in zip(points(work.sweep), work.plans, strict=True):
        name = plan.sequence.name
        truth = json.dumps([source, _concerning(values, REFERENCE)], default=str)
        times = Record.read(out / "runs" / name).times if name in measured else {}
        for entry in measured.get(name, []):
            technique = entry["technique"]
            varied = _concerning(values, technique) | _concerning(values, REFERENCE)
            row = Row(truth, source, varied, entry, times.get(technique, {}).get("ms_per_frame"))
            found.setdefault((truth, technique, json.dumps(varied, default=str)), row)
    order = {truth: place for place, truth in enumerate(dict.fromkeys(row.truth for row in found.values()))}
    return sorted(found.values(), key=lambda row: (order[row.truth], _error(row)))


def print_sweep(work: Work, scores: Sequence[dict[str, Any]], out: Path) -> None:
    """Print the rows on stdout; what a technique does not depend on is left out of its row."""
    from rich import box
    from rich.table import Column, Table

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
    for _, group in groupby(rows, lambda row: row.truth):
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


def _concerning(values: dict[str, Any], technique: str) -> dict[str, Any]:
    return {key: value for key, value in values.items() if concerns(key, technique)}


def _error(row: Row) -> float:
    there = (row.entry["scores"][score] for score in ERRORS if score in row.entry["scores"])
    return float(next(there, inf))


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
