"""The option --engine: where work is done."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from swimlab.runs.record import RunError
from swimlab.sweep.engine import Engine, dask_engine, local

Name = Literal["local", "dask"]


def check_engine(engine: Name, scheduler: str | None) -> None:
    """Raise RunError for a scheduler without dask."""
    if scheduler is not None and engine != "dask":
        raise RunError(f"--scheduler {scheduler}: is for --engine dask; add that")


@contextmanager
def open_engine(engine: Name, scheduler: str | None, threads: int | None) -> Iterator[Engine]:
    """The engine of a name. threads: of a task. Raises RunError as `dask_engine` does."""
    if engine == "local":
        yield local
        return
    with dask_engine(scheduler, threads=threads) as opened:
        yield opened


def threads_of_task(engine: Name, scheduler: str | None, threads: int | None) -> int | None:
    """Threads of a task: the processes of a cluster on this machine share its cores."""
    return threads or 1 if engine == "dask" and scheduler is None else threads
