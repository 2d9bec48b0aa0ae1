"""Where the tasks of a sweep are done: in this process, or on dask.distributed."""

import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from metrics.machine import cores
from swimlab.runs.files import write_json
from swimlab.runs.record import RunError


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


RETRIES = 1
"""How often a task that raised is tried again. A killed worker's tasks are done by others without counting here."""
PATIENCE = "10s"
"""How long a scheduler may take to answer."""


ANY_PORT = "127.0.0.1:0"
"""A free port of this machine alone: two clusters on one machine do not meet at the usual one."""


@contextmanager
def dask_engine(scheduler: str | None, *, threads: int | None) -> Iterator[Engine]:
    """An engine on the scheduler of an address, or on this machine with a process for every `threads` cores.

    Raises RunError where dask.distributed is not installed or the scheduler does not answer.
    """
    try:
        import distributed  # an extra
    except ImportError as error:
        raise RunError(f"--engine dask: needs dask.distributed ({error}); pip install 'swimlab[cluster]'") from error
    dask: Any = distributed

    def connect(address: Any) -> Any:
        try:
            return dask.Client(address, timeout=PATIENCE)
        except (OSError, ValueError) as error:
            raise RunError(f"--scheduler {address}: does not answer ({error}); write it as tcp://HOST:8786") from error

    def engine_of(client: Any) -> Engine:
        def engine(tasks: Sequence[Task]) -> Iterator[tuple[Task, BaseException | None]]:
            futures = {
                client.submit(task.function, *task.arguments, key=_key(task), pure=False, retries=RETRIES): task
                for task in tasks
            }
            for future in dask.as_completed(futures):
                yield futures[future], _error(future)
                future.release()

        return engine

    if scheduler is not None:
        with connect(scheduler) as client:
            yield engine_of(client)
        return
    processes = max(1, cores() // (threads or 1))
    with (
        # No limit of memory: pictures are the file cache's, and a worker that is killed at 95 % helps nobody.
        dask.LocalCluster(
            n_workers=processes, threads_per_worker=1, memory_limit=0, dashboard_address=ANY_PORT
        ) as cluster,
        connect(cluster) as client,
    ):
        yield engine_of(client)


def _key(task: Task) -> str:
    """The scheduler's name for a task: its key, made the output folder's own, as other sweeps may share a cluster."""
    return f"{task.function.__name__}-{task.key}-{sha256(repr(task.arguments[1:]).encode()).hexdigest()[:8]}"


def _error(future: Any) -> BaseException | None:
    if future.status == "finished":
        return None
    error: BaseException | None = future.exception()
    return None if error is None else error.with_traceback(future.traceback())
