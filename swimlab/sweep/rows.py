"""A sweep's distinct results as rows of one table: what one picks a setting by."""

import json
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from swimlab.runs.differences import concerns
from swimlab.runs.record import REFERENCE, Record
from swimlab.sweep.grid import points
from swimlab.sweep.work import Work

ERRORS = ("budget.mse", "scale.rmse")
"""Scores that rows are in the order of: of a clip, and of frames of several sizes."""


class Row(NamedTuple):
    """A distinct result. shared: settings that the reference depends on, sequence first. varied: settings of the
    technique.

    entry: that of scores.json. ms: of a frame, where known.
    """

    shared: str
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
    for (source, values), name in zip(points(work.sweep), work.names, strict=True):
        shared = json.dumps([source, _concerning(values, REFERENCE)], default=str)
        times = Record.read(out / "runs" / name).times if name in measured else {}
        for entry in measured.get(name, []):
            technique = entry["technique"]
            varied = _concerning(values, technique) | _concerning(values, REFERENCE)
            row = Row(shared, source, varied, entry, times.get(technique, {}).get("ms_per_frame"))
            found.setdefault((shared, technique, json.dumps(varied, default=str)), row)
    order = {shared: place for place, shared in enumerate(dict.fromkeys(row.shared for row in found.values()))}
    return sorted(found.values(), key=lambda row: (order[row.shared], _error(row)))


def _concerning(values: dict[str, Any], technique: str) -> dict[str, Any]:
    return {key: value for key, value in values.items() if concerns(key, technique)}


def _error(row: Row) -> float:
    there = (row.entry["scores"][score] for score in ERRORS if score in row.entry["scores"])
    return float(next(there, inf))
