"""What commands that read scores alone say of the frames that these are of."""

import sys
from collections.abc import Iterable
from pathlib import Path

from swimlab.footage.sources import changes
from swimlab.runs.entries import read_entries, warnings_of
from swimlab.runs.record import Record
from swimlab.runs.scores import run_folders


def warn_of_sources(runs: Iterable[Path]) -> None:
    """Warn on standard error of brought frames that are gone, or have changed since they were measured."""
    for folder in (folder for run in runs if _holds_runs(run) for folder in run_folders(run)):
        for text in changes(Record.read(folder).inputs):
            print(f"swimlab: warning: {folder}: {text}", file=sys.stderr)


def warn_of_measuring(runs: Iterable[Path]) -> None:
    """Warn on standard error of what may make the scores of runs wrong, as it was found when they were measured."""
    for text in dict.fromkeys(text for run in runs for text in warnings_of(read_entries(run))):
        print(f"swimlab: warning: {text}", file=sys.stderr)


def _holds_runs(folder: Path) -> bool:
    """Whether it is a run folder, or one of a study; else it has scores alone."""
    return any(folder.glob("run.json")) or any(folder.glob("*/run.json"))
