"""Arrays that the host and a device both work on."""

from functools import cached_property
from typing import Any

import warp as wp
from numpy.typing import NDArray


class Shared:
    """An array that the host and a device both have: one memory where the device is the CPU.

    host: as NumPy has it. on_host: the same memory, as kernels that are launched on the host take it, in less time than
    they take NumPy's. device: as others take it.
    """

    def __init__(self, shape: tuple[int, ...], dtype: Any, on: Any) -> None:
        """dtype: of a number. on: Warp's device. It is not set."""
        array: Any = wp.empty(shape, dtype=dtype, device="cpu")
        self.on_host, self._on = array, on
        self.host: NDArray[Any] = array.numpy()

    @cached_property
    def device(self) -> Any:
        return self.on_host if self._on.is_cpu else wp.array(self.host, dtype=self.on_host.dtype, device=self._on)

    def send(self) -> None:
        """What the host wrote goes to the device."""
        if not self._on.is_cpu:
            self.device.assign(self.host)

    def fetch(self) -> None:
        """What kernels wrote comes to the host."""
        if not self._on.is_cpu:
            self.host[...] = self.device.numpy()

    def fill(self, value: float) -> None:
        """All of it gets one value, on both sides."""
        self.host.fill(value)
        self.send()
