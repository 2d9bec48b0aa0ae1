"""Threads that help the calling one with strips of rows.

They work and sleep in native code, so that they are woken and waited for without the interpreter lock, and have no
Python of their own to go through with cold caches. They sleep on locks of Python's C API (`PyThread_acquire_lock`, of
its stable interface), which there are on every system.
"""

import ctypes
from collections.abc import Sequence
from threading import Lock, Thread
from typing import Any, NamedTuple
from weakref import finalize

import warp as wp

from metrics.kernels.host import Dim, HostLaunch, host_launch
from metrics.kernels.strips import dismiss, lead, serve


class Strips(ctypes.Structure):
    """Strips of a launch: `rows` in all, `height` of each but the last.

    function: the kernel's. each, last: bounds of a strip of all its rows and of the last one. taken: how many were.
    """

    _fields_ = (
        ("function", ctypes.c_void_p),
        ("each", ctypes.c_void_p),
        ("last", ctypes.c_void_p),
        ("rows", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("taken", ctypes.c_int32),
    )


class Helper(ctypes.Structure):
    """What a thread that helps and who leads it both know.

    wake, done: locks, which are free only when it is asked for something, and has done it. strips, arguments: of a
    launch, null for it to end. next: another one that helps with it. idle: whether it is there, and nobody leads it.
    serves: whether it is to go on.
    """

    _fields_ = (
        ("wake", ctypes.c_void_p),
        ("done", ctypes.c_void_p),
        ("strips", ctypes.c_void_p),
        ("arguments", ctypes.c_void_p),
        ("next", ctypes.c_void_p),
        ("idle", ctypes.c_int32),
        ("serves", ctypes.c_int32),
    )


_C: Any = ctypes.pythonapi
_C.PyThread_allocate_lock.restype = ctypes.c_void_p
_C.PyThread_acquire_lock.argtypes = [ctypes.c_void_p, ctypes.c_int]
_C.PyThread_free_lock.argtypes = [ctypes.c_void_p]
_C.PyThread_free_lock.restype = None
ACQUIRE, RELEASE = (
    ctypes.cast(each, ctypes.c_void_p).value for each in (_C.PyThread_acquire_lock, _C.PyThread_release_lock)
)


class Together(NamedTuple):
    """A launch over strips, of which the calling thread takes some and helpers take others.

    launches: with the arguments of each thread. led: what starts it. held: what it needs in memory.
    """

    launches: Sequence[HostLaunch]
    led: HostLaunch
    held: Sequence[Any]

    @property
    def kernel(self) -> wp.Kernel:
        """The kernel that runs on the strips."""
        return self.launches[0].kernel

    def launch(self) -> None:
        """Run it once, and wait."""
        self.led.launch()


class Crew:
    """Some helpers at most. Each starts when it is needed, and they end when this is closed or goes."""

    def __init__(self, count: int) -> None:
        self._helpers, self._started, self._starting = (Helper * count)(), 0, Lock()
        self._ends, self._locks = list[HostLaunch](), list[int]()
        self.close = finalize(self, _end, self._ends, self._helpers)
        for each in (self.close, finalize(self._helpers, _free, self._locks)):
            each.atexit = False  # helpers that are left then sleep on until the process has ended

    def together(
        self, launch: HostLaunch, rows: int, height: int, dims: Sequence[Dim], others: Sequence[Sequence[Any]]
    ) -> Together:
        """A launch over strips (see Strips), laid out to be run once.

        dims: of a strip of all its rows and of the last one. others: what a helper has in the place of the last inputs,
        for as many helpers as may be asked for. Raises RuntimeError once this is closed.
        """
        self._start(len(others))
        launches = [launch, *map(launch.with_last, others)]
        each, last = (ctypes.addressof(launch.of.bounds(dim)) for dim in dims)
        strips = Strips(launch.of.address, each, last, rows, height, 0)
        arguments = (ctypes.c_void_p * len(launches))(*[ctypes.addressof(each.arguments) for each in launches])
        places = [ctypes.addressof(strips), ctypes.addressof(arguments), len(others), ctypes.addressof(self._helpers)]
        led = host_launch(lead, 1, [*places, len(self._helpers), ACQUIRE, RELEASE])
        return Together(launches, led, (strips, arguments, self._helpers))

    def _start(self, count: int) -> None:
        """Have so many helpers, or as many as there may be."""
        if self._is_closed():
            raise RuntimeError("closed: its threads have ended")
        if self._started < min(count, len(self._helpers)):
            with self._starting:
                for helper in self._helpers[self._started : count]:
                    self._start_one(helper)
            if self._is_closed():  # meanwhile
                _end(self._ends, self._helpers)

    def _is_closed(self) -> bool:
        return not self.close.alive

    def _start_one(self, helper: Helper) -> None:
        # All is made here, which loads the kernels: whoever starts a thread may hold what it would wait for.
        serving = host_launch(serve, 1, [ctypes.addressof(helper), ACQUIRE, RELEASE])
        self._ends[:] = [host_launch(dismiss, 1, [ctypes.addressof(self._helpers), len(self._helpers), RELEASE])]
        if helper.wake is None:
            helper.wake, helper.done = (_held_lock(self._locks) for _ in range(2))
        helper.serves = 1
        Thread(target=_serve, args=(serving, self._helpers), name="swimlab", daemon=True).start()
        helper.idle = 1
        self._started += 1


def _held_lock(known: list[int]) -> int:
    known.append(_C.PyThread_allocate_lock())
    _C.PyThread_acquire_lock(known[-1], 1)
    return known[-1]


def _serve(serving: HostLaunch, _helpers: Any) -> None:
    """A thread's work. _helpers: held until it ends."""
    serving.launch()


def _end(ends: Sequence[HostLaunch], _helpers: Any) -> None:
    for each in ends:
        each.launch()


def _free(locks: Sequence[int]) -> None:
    for lock in locks:
        _C.PyThread_free_lock(lock)
