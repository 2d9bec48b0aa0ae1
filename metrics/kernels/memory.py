"""Memory of the CPU that arrays give back, kept for the next ones: to get it anew costs far more than to fill it."""

from collections import defaultdict
from math import prod
from typing import Any

import warp as wp

LEAST = 1 << 16
"""Bytes of an array for which it is worth while."""
MOST = 1 << 26
"""Bytes that are kept while no array has them."""


class Memory:
    """Uninitialised arrays of the CPU; of each size, memory that was given back is used again."""

    def __init__(self) -> None:
        self._waiting: dict[int, list[Any]] = defaultdict(list)

    def array(self, shape: int | tuple[int, ...], dtype: Any) -> Any:
        """An array that lives as long as something refers to it, also a NumPy array made of it."""
        size = prod(shape if isinstance(shape, tuple) else (shape,)) * wp.types.type_size_in_bytes(dtype)
        if size < LEAST:
            return wp.empty(shape, dtype=dtype, device="cpu")
        waiting = self._waiting[size]
        try:
            block = waiting.pop()
        except IndexError:
            block = wp.empty(size, dtype=wp.uint8, device="cpu")

        def give_back(_pointer: int, _size: int) -> None:
            if sum(each * len(blocks) for each, blocks in list(self._waiting.items())) + size <= MOST:
                waiting.append(block)

        return wp.array(ptr=block.ptr, dtype=dtype, shape=shape, capacity=size, device="cpu", deleter=give_back)
