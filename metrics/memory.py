"""Memory of large arrays, used again: the system clears all that it hands out, which takes longer than most work on it.

Most large arrays are asked for just after another of the same size has gone, and they are most of the memory that
measuring takes: that of one is kept.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

LARGE = 2**22
"""Bytes from which on an array's memory is used again; from there on numpy has it in large pages, too."""

_KEPT: list[NDArray[np.uint8]] = []


def unset(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array whose values are not set."""
    kind = np.dtype(dtype)
    size = math.prod(shape) * kind.itemsize
    if size < LARGE:
        return np.empty(shape, kind)
    try:
        memory = _KEPT.pop()
    except IndexError:
        memory = np.empty(0, np.uint8)
    lent = _Lent(memory if len(memory) == size else np.empty(size, np.uint8))
    return np.asarray(lent).view(kind).reshape(shape)


def let_go() -> None:
    """Give back what is kept."""
    _KEPT.clear()


class _Lent:
    """Memory that is kept when the last array on it goes."""

    def __init__(self, memory: NDArray[np.uint8]) -> None:
        self._memory = memory
        self.__array_interface__ = memory.__array_interface__

    def __del__(self) -> None:
        _KEPT[:] = [self._memory]
