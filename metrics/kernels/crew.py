"""Threads that help the calling one with strips of rows.

They work and sleep in native code, so that they are woken and waited for without the interpreter lock, and have no
Python of their own to go through with cold caches. They sleep on locks of Python's C API (`PyThread_acquire_lock`, of
its stable interface), which there are on every system.
"""

import ctypes
from collections.abc import Callable, Sequence
from threading import Lock, Thread
from typing import Any
from weakref import finalize

import warp as wp

from metrics.kernels.host import Dim, HostLaunch, host_launch
from metrics.kernels.strips import Helper, Strips, dismiss, lead, serve

_C: Any = ctypes.pythonapi
_C.PyThread_allocate_lock.restype = ctypes.c_void_p
_C.PyThread_acquire_lock.argtypes = [ctypes.c_void_p, ctypes.c_int]
_C.PyThread_free_lock.argtypes = [ctypes.c_void_p]
_C.PyThread_free_lock.restype = None
ACQUIRE, RELEASE = (
    ctypes.cast(each, ctypes.c_void_p).value for each in (_C.PyThread_acquire_lock, _C.PyThread_release_lock)
)


class Together:
    """A launch over strips, of which the calling thread takes some and helpers take others."""

    __slots__ = ("_held", "_launches", "_led", "_strips")

    def __init__(self, launches: Sequence[HostLaunch], led: HostLaunch, strips: Strips, held: Sequence[Any]) -> None:
        """launches: with the arguments of each thread. led: what starts it. held: what else it needs in memory."""
        self._launches, self._led, self._strips, self._held = launches, led, strips, held

    @property
    def kernel(self) -> wp.Kernel:
        """The kernel that runs on the strips."""
        return self._launches[0].kernel

    def launch(self) -> None:
        """Run it, and wait."""
        self._strips.taken = 0
        self._led.launch()

    def only(self, rows: range, dim: Callable[[int], Dim]) -> None:
        """Have it take these rows. dim: of so many."""
        strips = self._strips
        if strips.begin == rows.start and strips.end == rows.stop:
            return
        strips.begin, strips.end = rows.start, rows.stop
        before_last = (len(rows) - 1) // strips.height
        strips.last = ctypes.addressof(self._launches[0].of.bounds(dim(len(rows) - before_last * strips.height)))
        self._led.arguments._2 = min(before_last, len(self._launches) - 1)  # the helpers that are asked for

    def let_go(self) -> None:
        """Hold no inputs but a helper's own (see HostLaunch)."""
        self._launches[0].let_go()

    def renew(self, inputs: Sequence[Any]) -> None:
        """Give one that has let go other inputs, but for each thread's own (see HostLaunch)."""
        mine, *others = self._launches
        mine.renew(inputs)
        for other in others:
            other.take_over(mine, len(inputs))


class Crew:
    """Some helpers at most. Each starts when it is needed, and they end when this is closed or goes."""

    def __init__(self, count: int) -> None:
        self._helpers, self._started, self._starting = (Helper * count)(), 0, Lock()
        self._ends, self._locks = list[HostLaunch](), list[int]()
        self.close = finalize(self, _end, self._ends, self._helpers)
        for each in (self.close, finalize(self._helpers, _free, self._locks)):
            each.atexit = False  # helpers that are left then sleep on until the process has ended

    def together(
        self, launch: HostLaunch, rows: int, height: int, dim: Callable[[int], Dim], others: Sequence[Sequence[Any]]
    ) -> Together:
        """A launch over strips (see Strips).

        dim: of so many rows. others: what a helper has in the place of the last inputs, for as many helpers as may be
        asked for. Raises RuntimeError once this is closed.
        """
        self._start(len(others))
        launches = [launch, *map(launch.with_last, others)]
        strips = Strips(function=launch.of.address, height=height)
        strips.each = ctypes.addressof(launch.of.bounds(dim(height)))
        arguments = (ctypes.c_void_p * len(launches))(*[ctypes.addressof(each.arguments) for each in launches])
        places = [ctypes.addressof(strips), ctypes.addressof(arguments), len(others), ctypes.addressof(self._helpers)]
        led = host_launch(lead, 1, [*places, len(self._helpers), ACQUIRE, RELEASE])
        together = Together(launches, led, strips, (arguments, self._helpers))
        together.only(range(rows), dim)
        return together

    def _start(self, count: int) -> None:
        """Have so many helpers, or as many as there may be."""
        if self._is_closed():
            raise RuntimeError("closed: its threads have ended")
        if self._started < min(count, len(self._helpers)):
            # Made before the lock is taken, as it loads the kernels: who waits for the lock may hold what that needs.
            self._ends[:] = [host_launch(dismiss, 1, [ctypes.addressof(self._helpers), len(self._helpers), RELEASE])]
            serving = [host_launch(serve, 1, [ctypes.addressof(each), ACQUIRE, RELEASE]) for each in self._helpers]
            try:
                with self._starting:
                    for k in range(self._started, min(count, len(self._helpers))):
                        self._start_one(self._helpers[k], serving[k])
            finally:
                if self._is_closed():  # meanwhile
                    _end(self._ends, self._helpers)

    def _start_one(self, helper: Helper, serving: HostLaunch) -> None:
        """Whenever this is cut short, all goes on: who leads does not wait for a helper that has no thread."""
        if not helper.serves:
            helper.wake, helper.done = (_held_lock(self._locks) for _ in range(2))
            helper.idle = 1
            helper.serves = 1
        self._started += 1
        try:
            Thread(target=_serve, args=(serving, self._helpers), name="swimlab", daemon=True).start()
        except RuntimeError:
            self._started -= 1
            raise

    def _is_closed(self) -> bool:
        return not self.close.alive


def _held_lock(known: list[int]) -> int:
    lock: int | None = _C.PyThread_allocate_lock()
    if lock is None:
        raise MemoryError("no lock for another thread")
    known.append(lock)
    _C.PyThread_acquire_lock(lock, 1)
    return lock


def _serve(serving: HostLaunch, _helpers: Any) -> None:
    """A thread's work. _helpers: held until it ends."""
    serving.launch()


def _end(ends: Sequence[HostLaunch], _helpers: Any) -> None:
    for each in ends:
        each.launch()


def _free(locks: Sequence[int]) -> None:
    for lock in locks:
        _C.PyThread_free_lock(lock)
