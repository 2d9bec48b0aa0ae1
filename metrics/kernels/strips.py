"""Strips of rows that threads take one after another in native code: between two of them nobody waits for Python.

A kernel's first argument is the first row of its strip.
"""

import ctypes
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.host import Dim, HostLaunch, on_cpu
from metrics.kernels.making import made_once

TAKE = """
    const wp::int64* each = strips.data;
    for (;;) {
        const int k = __atomic_fetch_add(taken.data, 1, __ATOMIC_RELAXED);
        if (k >= strips.shape[0]) return;
        *(int*)arguments = (int)each[2*k];
        ((void (*)(void*, void*))function)((void*)each[2*k + 1], (void*)arguments);
    }
"""


@wp.func_native(TAKE)
def take(
    function: wp.uint64,
    arguments: wp.uint64,
    strips: wp.array2d(dtype=wp.int64),
    taken: wp.array(dtype=wp.int32),
):
    """Call a kernel's function on strips, as long as some are left."""


@wp.kernel(enable_backward=False)
def take_strips(
    function: wp.uint64,
    arguments: wp.uint64,
    strips: wp.array2d(dtype=wp.int64),
    taken: wp.array(dtype=wp.int32),
):
    """Run another kernel on strips.

    function, arguments: where they are in memory. strips: of each its first row, and where its bounds are. taken: how
    many were taken, by all threads.
    """
    take(function, arguments, strips, taken)


class Strips:
    """The strips of a launch of the first one, which some threads take."""

    def __init__(self, first: HostLaunch, rows: int, height: int, last: Dim) -> None:
        """rows: of all strips. height: of each but the last. last: dim of the last one."""
        _load()
        self._first = first
        first_rows = np.arange(0, rows, height, dtype=np.int64)
        bounds = np.full_like(first_rows, ctypes.addressof(first.bounds))
        bounds[-1] = ctypes.addressof(first.of.bounds(last))
        self._table = np.stack([first_rows, bounds], axis=1)
        self._taken = np.zeros(1, np.int32)

    def __bool__(self) -> bool:
        """Whether some are left."""
        return bool(self._taken[0] < len(self._table))

    def drop(self) -> None:
        """Have no more taken, since something went wrong."""
        self._taken[0] = len(self._table)

    def taking(self, own: Sequence[Any]) -> "Taking":
        """What a thread starts. own: its arrays in the place of the last inputs."""
        return Taking(self._first.with_last(own), self._table, self._taken)


class Taking(NamedTuple):
    """A thread's launch, on strips as long as some are left."""

    launched: HostLaunch
    strips: NDArray[np.int64]
    taken: NDArray[np.int32]

    @property
    def kernel(self) -> wp.Kernel:
        """The kernel that runs on the strips."""
        return self.launched.kernel

    def launch(self) -> None:
        """Run it in the calling thread."""
        function = ctypes.cast(self.launched.of.function, ctypes.c_void_p).value
        on_cpu(take_strips, 1, [function, ctypes.addressof(self.launched.arguments), self.strips, self.taken])


@made_once
def _load() -> None:
    """Load the kernel in the thread that starts others: it may hold what they would wait for."""
    on_cpu(take_strips, 1, [0, 0, np.zeros((0, 2), np.int64), np.zeros(1, np.int32)])
