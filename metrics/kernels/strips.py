"""Strips of rows that threads take one after another in native code: between two of them nobody waits for Python.

A kernel's first argument is the first row of its strip.
"""

import ctypes
from collections.abc import Sequence
from typing import Any, NamedTuple

import warp as wp

from metrics.kernels.host import Dim, HostLaunch, host_launch

TAKE = """
    for (;;) {
        const int first = height*__atomic_fetch_add((int*)taken, 1, __ATOMIC_RELAXED);
        if (first >= rows) return;
        *(int*)arguments = first;
        ((void (*)(void*, void*))function)((void*)(rows - first < height ? last : each), (void*)arguments);
    }
"""


@wp.func_native(TAKE)
def take(
    function: wp.uint64,
    arguments: wp.uint64,
    each: wp.uint64,
    last: wp.uint64,
    rows: wp.int32,
    height: wp.int32,
    taken: wp.uint64,
):
    """Call a kernel's function on strips, as long as some are left."""


@wp.kernel(enable_backward=False)
def take_strips(
    function: wp.uint64,
    arguments: wp.uint64,
    each: wp.uint64,
    last: wp.uint64,
    rows: wp.int32,
    height: wp.int32,
    taken: wp.uint64,
):
    """Run another kernel on strips of `height` of so many rows.

    function, arguments: where they are in memory. each, last: where bounds are, of whole strips and of one that has
    fewer rows. taken: where it is counted how many were taken, by all threads.
    """
    take(function, arguments, each, last, rows, height, taken)


class Strips:
    """The strips of a launch of the first one, which some threads take.

    Whoever starts the threads makes it, which loads the kernel: it may hold what they would wait for.
    """

    def __init__(self, first: HostLaunch, rows: int, height: int, last: Dim) -> None:
        """rows: of all strips. height: of each but the last. last: dim of the last one."""
        self._first, self._rows, self._height = first, rows, height
        self._taken = ctypes.c_int32(0)
        each, fewer = (ctypes.addressof(bounds) for bounds in (first.bounds, first.of.bounds(last)))
        inputs = [first.of.address, 0, each, fewer, rows, height, ctypes.addressof(self._taken)]
        self._take = host_launch(take_strips, 1, inputs)

    def drop(self) -> None:
        """Have no more taken, since something went wrong."""
        self._taken.value = -(-self._rows // self._height)

    def taking(self, own: Sequence[Any]) -> "Taking":
        """What a thread starts. own: its arrays in the place of the last inputs."""
        launched = self._first.with_last(own)
        return Taking(launched, self._take.with_number(1, ctypes.addressof(launched.arguments)), self._taken)


class Taking(NamedTuple):
    """A thread's launch, on strips as long as some are left.

    launched: the kernel with the thread's arguments. take: what starts it on a strip after the other. taken: how many
    were, by all threads; its memory is held here.
    """

    launched: HostLaunch
    take: HostLaunch
    taken: ctypes.c_int32

    @property
    def kernel(self) -> wp.Kernel:
        """The kernel that runs on the strips."""
        return self.launched.kernel

    def launch(self) -> None:
        """Run it in the calling thread."""
        self.take.launch()
