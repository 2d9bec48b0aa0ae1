"""Doing tasks on an engine, with progress; what fails is recorded, and the rest is done all the same."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from swimlab.sweep.engine import Engine, Task, failure_path, record_failure

Show = Callable[[str, int], AbstractContextManager[Callable[[str], None]]]
"""Shows progress: a word and a number of steps in, what is called after each step out."""


def perform(tasks: Sequence[Task], out: Path, engine: Engine, *, what: str, show: Show) -> dict[Path, str]:
    """Do tasks; the failures by the file that tells of each."""
    failures: dict[Path, str] = {}
    if not tasks:
        return failures
    with show(what, len(tasks)) as advance:
        for task, error in engine(tasks):
            if error is None:
                failure_path(out, task).unlink(missing_ok=True)
            else:
                failures[record_failure(out, task, error)] = f"{task.label}: {error}"
            advance(task.label)
    return failures
