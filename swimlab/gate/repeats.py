"""Runs of which a spread is made: each has to be a measurement of its own."""

from collections.abc import Sequence
from pathlib import Path

from swimlab.gate.rules import GateError
from swimlab.runs.entries import Entry, Key, read_entries
from swimlab.runs.scores import scores_path


def read_own(runs: Sequence[Path]) -> list[Entry]:
    """The entries of runs, in their order.

    Raises GateError where one file of scores is named twice, or two hold the same measured values of a technique on a
    sequence: copies would tell of a spread of 0. RunError where scores cannot be read.
    """
    files: dict[Path, Path] = {}
    found: dict[Key, list[tuple[Path, Entry]]] = {}
    entries = []
    for run in runs:
        file = scores_path(run).resolve()
        if file in files:
            raise GateError(f"{run}: is the same as {files[file]}; name each run once")
        files[file] = run
        for entry in read_entries(run):
            earlier = found.setdefault(entry.key, [])
            for other, known in earlier:
                if _measured(entry) == _measured(known):
                    raise GateError(
                        f"{run}: {entry.technique} on {entry.sequence} has the very values of {other}: that is one "
                        "measurement and tells of no spread; name it once, or runs of frames that were made anew"
                    )
            earlier.append((run, entry))
            entries.append(entry)
    return entries


def _measured(entry: Entry) -> str:
    """The measured values as text, in which NaN equals NaN."""
    return repr((entry.settings, sorted(entry.scores.items()), entry.frames, sorted(entry.replicates.items())))
