"""Threads that help the calling one with work in Python; with kernels it is a crew that helps (`metrics.kernels.crew`).

The standard library's pool takes several times as long: it has futures, which wake whoever waits for any of several.
"""

from collections import deque
from collections.abc import Callable
from queue import SimpleQueue
from threading import Lock, Thread
from weakref import finalize


class Task:
    """Work that a thread does once, unless it is called off before one has begun."""

    def __init__(self, work: Callable[[], None]) -> None:
        self._work: Callable[[], None] | None = work
        self._error: BaseException | None = None
        self._begun, self._unfinished = Lock(), Lock()
        self._unfinished.acquire()

    def run(self) -> None:
        """Do it, if it is not called off."""
        work = self._work
        if work is not None and self._begun.acquire(blocking=False):
            try:
                work()
            except BaseException as error:
                self._error = error
            self._work = None
        # Also of what is called off: Ctrl-C may have cut that short, and who calls it off again waits here.
        self._unfinished.release()

    def end(self) -> BaseException | None:
        """Call it off, or wait until it is done; the error that it ended with."""
        if self._begun.acquire(blocking=False):
            self._work = None  # and what it holds: the task may lie in the queue for some time yet
            return None
        with self._unfinished:
            return self._error


class Workers:
    """Some threads at most. Each starts when it is needed, and they end when this is closed or goes."""

    def __init__(self, count: int) -> None:
        self._count, self._started, self._starting = count, 0, Lock()
        self._tasks = SimpleQueue[Task | None]()
        self._idle: deque[None] = deque()
        self.close = finalize(self, _dismiss, self._tasks, count)

    def start(self, work: Callable[[], None]) -> Task:
        """Have some thread do it as soon as one is free. Raises RuntimeError once this is closed."""
        if not self.close.alive:
            raise RuntimeError("closed: its threads have ended")
        task = Task(work)
        self._tasks.put(task)
        try:
            self._idle.pop()
        except IndexError:
            self._add()
        return task

    def _add(self) -> None:
        """Start another thread, if there are not enough."""
        with self._starting:
            if self._started < self._count:
                Thread(target=_serve, args=(self._tasks, self._idle), name="swimlab", daemon=True).start()
                self._started += 1


def _serve(tasks: "SimpleQueue[Task | None]", idle: deque[None]) -> None:
    while (task := tasks.get()) is not None:
        task.run()
        del task  # what it holds is not to wait for the next one
        idle.append(None)


def _dismiss(tasks: "SimpleQueue[Task | None]", count: int) -> None:
    for _ in range(count):
        tasks.put(None)
