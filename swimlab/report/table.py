"""The score table of a sequence: rms values in words, best and worst marked, and why a score is missing."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from metrics import METRICS
from swimlab.report.charts import number
from swimlab.runs.columns import COLUMNS, NEITHER, marked
from swimlab.runs.record import REFERENCE
from swimlab.scoring.resolution import MARK, unresolved

Entry = Mapping[str, Any]
Scores = Mapping[str, float]


class Column(NamedTuple):
    """A column of the score table; its value is made from the score it needs and all of the technique."""

    heading: str
    title: str
    score: str
    value: Callable[[float, Scores], float]
    text: Callable[[float], str]
    ranked: bool


class Cell(NamedTuple):
    """A cell: text, CSS class ("", "best" or "worst"), and hover text."""

    text: str
    mark: str
    hint: str


class Table(NamedTuple):
    """Headings (text, hint), rows (technique, cells), and (heading, reason) of columns that have no value."""

    headings: list[tuple[str, str]]
    rows: list[tuple[str, list[Cell]]]
    missing: list[tuple[str, str]]


def _share(value: float, scores: Scores) -> float:
    return value / scores["budget.mse"] if scores.get("budget.mse") else 0.0


def _aligned(value: float) -> str:
    """Three significant digits, needless zeros kept so that a column can be read down."""
    return number(value) if value != 0 and not 1e-3 <= abs(value) < 1e3 else f"{value:#.3g}".rstrip(".")


def _percent(value: float) -> str:
    return f"{100 * value:.1f} %"


def _shown(heading: str) -> Column:
    """A column that the terminal has too."""
    score, show = COLUMNS[heading]
    ranked = score in METRICS and METRICS[score].better == "lower"
    text = _percent if score.startswith("plane.") else _aligned
    return Column(
        heading,
        marked(heading),
        score,
        lambda value, _: float(show(max(value, 0) if show is math.sqrt else value)),
        text,
        ranked,
    )


TIME = "ms_per_frame"
ERROR, *OTHERS = map(_shown, COLUMNS)
SHARE = f"share of flicker\N{NO-BREAK SPACE}{NEITHER}"
TABLE = (
    ERROR,
    Column("ms a frame", "ms a frame", TIME, lambda value, _: value, _aligned, True),
    *OTHERS,
    Column("share of flicker", SHARE, "budget.flicker", _share, _percent, False),
)


def score_table(entries: Sequence[Entry], milliseconds: Mapping[str, float]) -> Table:
    """The table of one sequence's entries; columns without any value move to `missing` with their reason."""
    headings, columns, missing = [], [], []
    for column in TABLE:
        values = [_value(column, entry, milliseconds) for entry in entries]
        reasons = [entry.get("absent", {}).get(column.score) for entry in entries]
        if any(value is not None for value in values):
            headings.append((column.title, _hint(column)))
            columns.append(_cells(column, entries, values, reasons))
        elif any(reasons):
            missing.append((column.heading, next(reason for reason in reasons if reason)))
    rows = [(entry["technique"], [cells[row] for cells in columns]) for row, entry in enumerate(entries)]
    return Table(headings, rows, missing)


def _hint(column: Column) -> str:
    if column.score == TIME:
        return "rendering time"
    root = column.heading in COLUMNS and COLUMNS[column.heading][1] is math.sqrt
    about = f": {METRICS[column.score].description}" if column.score in METRICS else ""
    return f"{'root of ' if root else ''}{column.score}{about}"


def _value(column: Column, entry: Entry, milliseconds: Mapping[str, float]) -> float | None:
    if column.score == TIME:
        return milliseconds.get(entry["technique"])
    score = entry["scores"].get(column.score)
    return None if score is None else column.value(score, entry["scores"])


def _cells(
    column: Column, entries: Sequence[Entry], values: Sequence[float | None], reasons: Sequence[str | None]
) -> list[Cell]:
    far = [
        abs(value) if column.ranked and value is not None and entry["technique"] != REFERENCE else None
        for entry, value in zip(entries, values, strict=True)
    ]
    known = [d for d in far if d is not None]
    close = unresolved(entries, column.score) if column.ranked else set()
    cells = []
    for entry, value, distance, reason in zip(entries, values, far, reasons, strict=True):
        mark = ""
        if distance is not None and min(known) < max(known):
            mark = "best" if distance == min(known) else "worst" if distance == max(known) else ""
        if value is None:
            cells.append(Cell("—", "", reason or "not measured"))
        else:
            sign = MARK if entry["technique"] in close else ""
            cells.append(Cell(sign + column.text(value), mark, _about(column, entry, value, mark, sign)))
    return cells


def _about(column: Column, entry: Entry, value: float, mark: str, sign: str) -> str:
    error = entry.get("errors", {}).get(column.score)
    parts = [f"{value:.6g}"]
    if error is not None:
        parts.append(f"{column.score} {entry['scores'][column.score]:.4g} ± {error:.2g} (standard error)")
    if mark:
        parts.append(f"{mark} of this column")
    if sign:
        parts.append("not resolved from the next better one")
    return ", ".join(parts)


def headline(entries: Sequence[Entry]) -> str:
    """The answer in a sentence or two: which technique errs least and most, and how much of that flickers."""
    tests = [entry for entry in entries if entry["technique"] != REFERENCE]
    by_error = sorted((e for e in tests if "budget.mse" in e["scores"]), key=lambda e: float(e["scores"]["budget.mse"]))
    by_scale = sorted((e for e in tests if "scale.rmse" in e["scores"]), key=lambda e: float(e["scores"]["scale.rmse"]))
    if len(by_error) > 1:
        best, worst = by_error[0], by_error[-1]
        ratio = _rms(worst) / _rms(best) if _rms(best) else math.inf
        lines = [
            f"{best['technique']} is nearest to the reference: rms error {number(_rms(best))}.",
            f"{worst['technique']} is farthest: {number(_rms(worst))}"
            + (f", {ratio:.1f} times as much." if ratio < 1e6 else "."),
        ]
        shown = [e for e in by_error if "budget.flicker" in e["scores"]]
        if len(shown) > 1:
            flicker = max(shown, key=lambda e: float(e["scores"]["budget.flicker"]))
            calm = min(shown, key=lambda e: float(e["scores"]["budget.flicker"]))
            lines.append(
                f"{flicker['technique']} flickers most ({number(_rms(flicker, 'budget.flicker'))} rms), "
                f"{calm['technique']} least ({number(_rms(calm, 'budget.flicker'))})."
            )
        return " ".join(lines)
    if len(by_scale) > 1:
        best, worst = by_scale[0], by_scale[-1]
        return (
            f"{best['technique']} depends least on the picture's size "
            f"(scale error {number(best['scores']['scale.rmse'])}), "
            f"{worst['technique']} most ({number(worst['scores']['scale.rmse'])})."
        )
    return ""


def _rms(entry: Entry, score: str = "budget.mse") -> float:
    return math.sqrt(max(entry["scores"][score], 0))
