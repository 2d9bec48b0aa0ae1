"""Tasks: what an engine does somewhere, and what becomes of its errors."""

import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swimlab.runs.files import write_json


class Task(NamedTuple):
    """A call whose result is files: it can be done anywhere, twice and again. key: names it, and so its failure."""

    key: str
    label: str
    function: Callable[..., None]
    arguments: tuple[Any, ...]


Engine = Callable[[Sequence[Task]], Iterator[tuple[Task, BaseException | None]]]
"""Does tasks and yields each with its error, or None, as they end."""


def local(tasks: Sequence[Task]) -> Iterator[tuple[Task, BaseException | None]]:
    """The engine of this process: one task after another, as each takes all cores."""
    for task in tasks:
        try:
            task.function(*task.arguments)
        except Exception as error:
            yield task, error
        else:
            yield task, None


def record_failure(out: Path, task: Task, error: BaseException) -> Path:
    """Write OUT/failures/KEY.json: what the task was, the message and the traceback."""
    path = failure_path(out, task)
    trace = "".join(traceback.format_exception(error))
    write_json(path, {"task": task.label, "error": f"{type(error).__name__}: {error}", "traceback": trace})
    return path


def failure_path(out: Path, task: Task) -> Path:
    """Where a task's failure is recorded."""
    return out / "failures" / f"{task.key}.json"
