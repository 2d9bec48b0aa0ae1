"""Runs as rows of tables: what queries are asked of."""

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from metrics import METRICS
from swimlab.runs.entries import Entry, number, read_entries
from swimlab.runs.record import Record, RunError

Row = tuple[Any, ...]

COLUMNS = {
    "scores": {
        "run": "VARCHAR",
        "sequence": "VARCHAR",
        "technique": "VARCHAR",
        "metric": "VARCHAR",
        "value": "DOUBLE",
        "error": "DOUBLE",
        "unit": "VARCHAR",
        "better": "VARCHAR",
    },
    "frames": {
        "run": "VARCHAR",
        "sequence": "VARCHAR",
        "technique": "VARCHAR",
        "frame": "INTEGER",
        "metric": "VARCHAR",
        "value": "DOUBLE",
    },
    "runs": {
        "run": "VARCHAR",
        "sequence": "VARCHAR",
        "hash": "VARCHAR",
        "domain": "VARCHAR",
        "motion": "VARCHAR",
        "width": "INTEGER",
        "height": "INTEGER",
        "fps": "DOUBLE",
        "frames": "INTEGER",
        "samples": "INTEGER",
        "half": "BOOLEAN",
        "swimlab": "VARCHAR",
        "warp": "VARCHAR",
        "numpy": "VARCHAR",
        "python": "VARCHAR",
        "machine": "VARCHAR",
        "command": "VARCHAR",
        "date": "TIMESTAMP",
        "settings": "JSON",
    },
    "times": {
        "run": "VARCHAR",
        "sequence": "VARCHAR",
        "technique": "VARCHAR",
        "ms_per_frame": "DOUBLE",
        "shaded_per_frame": "DOUBLE",
        "frames": "INTEGER",
    },
}
"""Tables -> columns -> types. `frames` has a row for each value of a frame; `settings` is the sequence file in full."""


def find_runs(words: Iterable[Path]) -> list[Path]:
    """Run folders at or anywhere below the folders named, and files of scores named; each once, sorted within each.

    Raises RunError where there is none.
    """
    found: dict[Path, None] = {}
    for word in words:
        below = [word] if word.is_file() else list(_below(word))
        if not below:
            raise RunError(f"{word}: holds no run.json, nor does a folder in it; make a run with 'swimlab study'")
        found.update(dict.fromkeys(below))
    return list(found)


def rows_of(run: Path) -> dict[str, list[Row]]:
    """A run's rows of every table, columns in the order of COLUMNS.

    A run that was not measured has no scores and frames; a file of scores, no times. Raises RunError where the
    folder's files are damaged.
    """
    name = str(run)
    if run.is_file():
        entries = read_entries(run)
        sequences = {entry.sequence: entry for entry in entries}
        return {**_measured(name, entries), "runs": [_file(name, entry) for entry in sequences.values()], "times": []}
    record = Record.read(run)
    entries = read_entries(run) if (run / "scores.json").is_file() else []
    sequence = record.sequence["name"]
    times = [
        (name, sequence, technique, time.get("ms_per_frame"), time.get("shaded_per_frame"), time.get("frames"))
        for technique, time in record.times.items()
    ]
    return {**_measured(name, entries), "runs": [_run(name, record, entries)], "times": times}


def _below(folder: Path) -> Iterator[Path]:
    """Run folders, without a look into the pictures that they hold."""
    for path, folders, files in os.walk(folder):
        folders.sort()
        if "run.json" in files:
            folders.clear()
            yield Path(path)


def _measured(run: str, entries: Sequence[Entry]) -> dict[str, list[Row]]:
    scores: list[Row] = []
    frames: list[Row] = []
    for entry in entries:
        for metric in entry.scores:
            about = METRICS.get(metric)
            values = number(entry.scores, metric), number(entry.errors, metric)
            words = (about.unit, about.better) if about else (None, None)
            scores.append((run, *entry.key, metric, *values, *words))
        for row in entry.frames:
            frames += [(run, *entry.key, row["frame"], key, value) for key, value in row.items() if key != "frame"]
    return {"scores": scores, "frames": frames}


def _run(name: str, record: Record, entries: Sequence[Entry]) -> Row:
    sequence, settings, about = record.sequence, record.settings, record.provenance
    return (
        name,
        sequence["name"],
        record.hash,
        entries[0].settings.domain if entries else None,
        sequence["motion"]["kind"],
        *sequence["size"],
        sequence["fps"],
        len(record.frames),
        settings.get("samples"),
        settings.get("half"),
        *_provenance(about),
        json.dumps(sequence),
    )


def _file(name: str, entry: Entry) -> Row:
    """What a file of scores says about a run."""
    settings = entry.provenance.get("settings", {})
    return (
        name,
        entry.sequence,
        entry.settings.hash,
        entry.settings.domain,
        None,
        *settings.get("size", (None, None)),
        settings.get("fps"),
        len(entry.frames) or None,
        None,
        None,
        *_provenance(entry.provenance),
        json.dumps(settings),
    )


def _provenance(about: dict[str, Any]) -> Row:
    return tuple(about.get(key) for key in ("swimlab", "warp", "numpy", "python", "machine", "command", "date"))
