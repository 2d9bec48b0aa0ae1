"""Threads that help the calling one with strips of rows, in native code.

Helpers sleep in native code too, so that they are woken, work and are waited for without the interpreter lock, and have
no Python of their own to go through with cold caches. They sleep on locks of Python's C API (`PyThread_acquire_lock`,
of its stable interface), which there are on every system.
"""

import ctypes
from collections.abc import Sequence
from threading import Lock, Thread
from typing import Any, NamedTuple
from weakref import finalize

import warp as wp

from metrics.kernels.host import Dim, HostLaunch, host_launch

TYPES = """
    struct Strips { void* function; void* each; void* last; int rows; int height; int taken; };
    struct Helper { void* wake; void* done; Strips* strips; void* arguments; Helper* next; int idle; int serves; };
    using Acquire = auto (void*, int) -> int;
    using Release = auto (void*) -> void;
    const auto take = [](Strips* strips, void* arguments) {
        for (;;) {
            const int first = strips->height*__atomic_fetch_add(&strips->taken, 1, __ATOMIC_RELAXED);
            const int left = strips->rows - first;
            if (left <= 0) return;
            *(int*)arguments = first;
            ((void (*)(void*, void*))strips->function)(left < strips->height ? strips->last : strips->each, arguments);
        }
    };
    const auto claim = [](Helper* helper) {
        int idle = 1;
        return __atomic_compare_exchange_n(&helper->idle, &idle, 0, false, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST);
    };
"""

LEAD = """
    void** own = (void**)arguments;
    Helper* mine = nullptr;
    for (Helper* helper = (Helper*)helpers; helper < (Helper*)helpers + count && asked > 0; ++helper) {
        if (!claim(helper)) continue;
        helper->strips = (Strips*)strips;
        helper->arguments = own[asked--];
        helper->next = mine;
        mine = helper;
        ((Release*)release)(helper->wake);
    }
    take((Strips*)strips, own[0]);
    while (mine) {
        Helper* const helper = mine;
        mine = helper->next;
        // Who has not woken by now finds nothing left, and sleeps on.
        if (!((Acquire*)acquire)(helper->wake, 0)) ((Acquire*)acquire)(helper->done, 1);
        __atomic_store_n(&helper->idle, 1, __ATOMIC_SEQ_CST);
        if (!__atomic_load_n(&helper->serves, __ATOMIC_SEQ_CST) && claim(helper)) ((Release*)release)(helper->wake);
    }
"""

SERVE = """
    Helper* const helper = (Helper*)own;
    for (;;) {
        ((Acquire*)acquire)(helper->wake, 1);
        if (!__atomic_load_n(&helper->serves, __ATOMIC_SEQ_CST)) return;
        take(helper->strips, helper->arguments);
        ((Release*)release)(helper->done);
    }
"""

DISMISS = """
    for (Helper* helper = (Helper*)helpers; helper < (Helper*)helpers + count; ++helper) {
        __atomic_store_n(&helper->serves, 0, __ATOMIC_SEQ_CST);
        if (claim(helper)) ((Release*)release)(helper->wake);
    }
"""


@wp.func_native(TYPES + LEAD)
def take_together(
    strips: wp.uint64,
    arguments: wp.uint64,
    asked: wp.int32,
    helpers: wp.uint64,
    count: wp.int32,
    acquire: wp.uint64,
    release: wp.uint64,
):
    """See `lead`."""


@wp.kernel(enable_backward=False)
def lead(
    strips: wp.uint64,
    arguments: wp.uint64,
    asked: wp.int32,
    helpers: wp.uint64,
    count: wp.int32,
    acquire: wp.uint64,
    release: wp.uint64,
):
    """Take strips, as helpers do that are woken for it, and wait for these. All are given by where they are in memory.

    arguments: where those of the calling thread are, and those for each of the helpers that are asked for at most.
    helpers: so many, some of which may be helping others. acquire, release: what acquires and releases a lock.
    """
    take_together(strips, arguments, asked, helpers, count, acquire, release)


@wp.func_native(TYPES + SERVE)
def take_when_woken(own: wp.uint64, acquire: wp.uint64, release: wp.uint64):
    """See `serve`."""


@wp.kernel(enable_backward=False)
def serve(own: wp.uint64, acquire: wp.uint64, release: wp.uint64):
    """Be a helper: take strips whenever it is woken, until it no longer serves."""
    take_when_woken(own, acquire, release)


@wp.func_native(TYPES + DISMISS)
def let_go(helpers: wp.uint64, count: wp.int32, release: wp.uint64):
    """See `dismiss`."""


@wp.kernel(enable_backward=False)
def dismiss(helpers: wp.uint64, count: wp.int32, release: wp.uint64):
    """Have helpers serve no longer: who is idle is woken to see it, others see to it who lead them."""
    let_go(helpers, count, release)


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
    launch. next: another one that helps with it. idle: whether it is there, and nobody leads it. serves: see `dismiss`.
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
        if not self.close.alive:
            raise RuntimeError("closed: its threads have ended")
        if self._started < min(count, len(self._helpers)):
            with self._starting:
                for helper in self._helpers[self._started : count]:
                    self._start_one(helper)

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
