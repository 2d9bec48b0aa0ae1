"""Runs of which a spread is made: each is named once."""

from collections.abc import Sequence
from pathlib import Path

from swimlab.gate.rules import GateError
from swimlab.runs.entries import Entry, read_entries
from swimlab.runs.scores import scores_path


def read_own(runs: Sequence[Path]) -> list[Entry]:
    """The entries of runs, in their order. Runs of a renderer that gives the same bits each time have the same values.

    Raises GateError where one file of scores is named twice. RunError where scores cannot be read.
    """
    files: dict[Path, Path] = {}
    entries = []
    for run in runs:
        file = scores_path(run).resolve()
        if file in files:
            raise GateError(f"{run}: is the same as {files[file]}; name each run once")
        files[file] = run
        entries += read_entries(run)
    return entries
