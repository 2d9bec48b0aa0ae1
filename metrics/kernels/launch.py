"""The launcher: the one place where kernels are started, on all cores.

One launch on the CPU is a serial loop that releases the interpreter lock, so work is cut into strips of rows that a
pool of threads takes one after another. How it is cut never changes a bit of the result.
"""

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Any, NamedTuple, Protocol, Self, TypedDict, TypeVar, Unpack

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.crew import Crew
from metrics.kernels.host import Dim, as_numbers, host_launch
from metrics.kernels.making import MAKING
from metrics.kernels.shared import Shared
from metrics.kernels.spares import Spare, Spares
from metrics.kernels.starting import start_warp
from metrics.kernels.workers import Task, Workers
from metrics.machine import cores
from metrics.memory import LARGE, let_go, unset

Item = TypeVar("Item")

STRIP_ROWS = 32
"""Rows of samples a task: enough tasks to even out cheap and expensive rows, few enough that starting them
costs nothing, and a strip's visibility buffer stays in the cache."""

FEW_ROWS = 4
"""Rows of samples of a strip that threads take in native code, which costs nothing: as long as it takes, one thread may
wait for another."""


bytes_of = cache(wp.types.type_size_in_bytes)
"""Bytes of a value of some type."""


class Strip(NamedTuple):
    """A run of rows of a picture."""

    first: int
    rows: int


class Scratch(NamedTuple):
    """Scratch of a kernel over rows: `rows` of `width` values for each row that is worked on at once, not set."""

    width: int
    dtype: Any
    rows: int = 1


Own = Scratch | Callable[[int], Sequence[Any]]
"""A kernel's last inputs, for a thread alone, or what makes them for the rows that are worked on at once."""


class OnRows(Protocol):
    """What runs a kernel over rows."""

    def __call__(self, some: range = ..., /) -> None:
        """Over those of a range, which is not empty, or over all."""


def no_inputs(_: int) -> Sequence[Any]:
    """No inputs of its own."""
    return ()


class Cut(TypedDict, total=False):
    """How a kernel over rows is cut into strips (see `Launcher.laid_out`)."""

    each: int
    strip: int
    n: int
    own: Own


class Launcher:
    """Runs kernels on `device` with `threads` threads (default: every core)."""

    def __init__(self, *, threads: int | None = None, device: str = "cpu") -> None:
        start_warp()
        if device not in {str(known) for known in wp.get_devices()}:
            known = ", ".join(str(known) for known in wp.get_devices())
            raise ValueError(f"--device {device}: not on this machine; it has {known}")
        self.device = device
        self._on: Any = wp.get_device(device)
        self.threads = threads or cores()
        self._workers, self._crew = Workers(self.threads), Crew(self.threads - 1)
        self._spares = Spares()

    def close(self) -> None:
        """Let the threads go, and the memory that was kept."""
        self._workers.close()
        self._crew.close()
        self._spares.close()
        let_go()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def each(self, items: Iterable[Item], body: Callable[[Item], None]) -> None:
        """Call `body` on every item, several at a time, and wait; the first error is raised."""
        waiting = deque(items)

        def work() -> None:
            while waiting:
                try:
                    item = waiting.popleft()
                except IndexError:  # another thread was quicker
                    return
                body(item)

        tasks: list[Task] = []
        try:
            for _ in range(min(self.threads, len(waiting)) - 1):
                tasks.append(self._workers.start(work))
            work()
            errors = [task.end() for task in tasks]  # a thread that has not begun by now finds nothing left
        except BaseException:
            waiting.clear()
            for task in tasks:
                task.end()
            raise
        for error in errors:
            if error is not None:
                raise error

    def strips(self, rows: int, n: int = 1) -> Sequence[Strip]:
        """Cut a picture with n x n samples a pixel into strips: one on a GPU, where a launch is parallel by itself."""
        height = max(1, STRIP_ROWS // n) if self.device == "cpu" else max(rows, 1)
        return [Strip(first, min(height, rows - first)) for first in range(0, rows, height)]

    def launch(self, kernel: wp.Kernel, dim: Dim, inputs: Sequence[Any]) -> None:
        """Start one kernel in the calling thread."""
        self.start(self.record(kernel, dim, inputs))

    def record(self, kernel: wp.Kernel, dim: Dim, inputs: Sequence[Any]) -> Any:
        """A launch that is ready to be started: it has its `kernel`, and `launch()`."""
        if self.device == "cpu":
            return host_launch(kernel, dim, inputs)
        with MAKING:
            return wp.launch(kernel, dim=dim, inputs=list(inputs), device=self._on, record_cmd=True)

    def start(self, command: Any) -> None:
        """Start a recorded launch in the calling thread."""
        command.launch()

    def over(
        self, rows: int, kernel: wp.Kernel, width: tuple[int, ...], inputs: Sequence[Any], **cut: Unpack[Cut]
    ) -> None:
        """Run a kernel over rows of a picture, as it is laid out."""
        self.laid_out(rows, kernel, width, inputs, **cut)()

    def laid_out(
        self,
        rows: int,
        kernel: wp.Kernel,
        width: tuple[int, ...],
        inputs: Sequence[Any],
        *,
        each: int = 1,
        strip: int = FEW_ROWS,
        n: int = 1,
        own: Own = no_inputs,
    ) -> OnRows:
        """What runs a kernel over rows of a picture, in strips; the kernel's first input is the first row.

        It is called once at most, for all of them or with a range of some: then another launch has its memory.

        The kernel's dim is (rows, *width), or a thread of it takes `each` rows, of which strips are whole multiples.
        The picture has n x n samples a pixel. strip: rows of samples of a strip.
        """

        def dim(count: int) -> tuple[int, ...]:
            return (-(-count // each), *width)

        def on_device(some: range = range(rows)) -> None:
            if some:
                self.launch(kernel, dim(len(some)), [some.start, *inputs, *self.made(own, len(some))])

        if self.device != "cpu" or rows == 0:
            return on_device
        height = min(each * -(-max(1, strip // n) // each), rows)
        of = rows, height, each, width, own
        spare = self._spares.again(kernel, of, [0, *inputs])
        if spare is None:
            owned = [self.made(own, 1) for _ in range(min(self.threads, -(-rows // height)))]
            command: Any = host_launch(kernel, dim(rows), [0, *inputs, *owned[0]])
            if len(owned) > 1:
                command = self._crew.together(command, rows, height, dim, owned[1:])
            spare = Spare(command, of, owned)

        def run(some: range = range(rows)) -> None:
            spare.command.only(some, dim)
            self.start(spare.command)
            if own is no_inputs or isinstance(own, Scratch):
                self._spares.keep(spare)

        return run

    def on_host(self, kernel: wp.Kernel, inputs: Sequence[Any]) -> Callable[[], None]:
        """What runs a kernel of one thread on the host's own arrays, whatever the device, and on what it shares.

        It is called once at most, as what is `laid_out`.
        """
        given = [value.on_host if isinstance(value, Shared) else value for value in inputs]
        spare = self._spares.again(kernel, None, given) or Spare(host_launch(kernel, 1, given), None, ())

        def run() -> None:
            self.start(spare.command)
            self._spares.keep(spare)

        return run

    def made(self, own: Own, at_once: int) -> Sequence[Any]:
        """A thread's own inputs, for some rows that are worked on at once."""
        if isinstance(own, Scratch):
            return [self.empty((own.rows * at_once, own.width), own.dtype)]
        return own(at_once)

    def empty(self, shape: int | tuple[int, ...], dtype: Any) -> Any:
        """An uninitialised array on the device."""
        size = bytes_of(dtype) * (math.prod(shape) if isinstance(shape, tuple) else shape)
        if self.device != "cpu" or size < LARGE:
            return wp.empty(shape, dtype=dtype, device=self._on)
        held = unset((size,), np.uint8)
        # Called when the array goes, and holds the memory until then.
        return wp.array(
            ptr=held.ctypes.data, dtype=dtype, shape=shape, device="cpu", deleter=lambda *_, held=held: None
        )

    def unset(self, shape: tuple[int, ...], dtype: Any) -> Any:
        """An array of numbers or vectors that launches fill: on the CPU the host's own, which costs less than Warp's.

        Raises TypeError for structures.
        """
        if self.device != "cpu":
            return self.empty(shape, dtype)
        number, inner = as_numbers(dtype)
        if number is None:
            raise TypeError(f"{dtype}: NumPy has no numbers for it")
        return unset((*shape, *inner), number)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any) -> Any:
        """An array on the device filled with 0."""
        array = self.empty(shape, dtype)
        array.zero_()
        return array

    def filled(self, shape: int | tuple[int, ...], dtype: Any, value: float) -> Any:
        """An array on the device filled with a value."""
        array = self.empty(shape, dtype)
        array.fill_(value)
        return array

    def array(self, values: Any, dtype: Any) -> Any:
        """A copy of values on the device."""
        return wp.array(values, dtype=dtype, device=self._on)

    def copied(self, values: NDArray[Any]) -> NDArray[Any]:
        """A copy of the host's array, made by all threads."""
        held = unset(values.shape, values.dtype)

        def copy(first: int) -> None:
            rows = slice(first, first + STRIP_ROWS)
            held[rows] = values[rows]

        self.each(range(0, len(values), STRIP_ROWS), copy)
        return held

    def shared(self, shape: tuple[int, ...], dtype: Any) -> Shared:
        """An array that the host and the device both work on, not set."""
        return Shared(shape, dtype, self._on)

    def lent(self, values: Any, dtype: Any) -> Any:
        """The host's values, of that type, for a launch to read: on the CPU as they are, at less cost than a view."""
        return np.ascontiguousarray(values) if self.device == "cpu" else self.view(values, dtype)

    def view(self, values: Any, dtype: Any) -> Any:
        """Values on the device, to be read: the same memory where that is the CPU's, and they are contiguous."""
        held = np.ascontiguousarray(values)
        return wp.array(held, dtype=dtype, device=self._on, copy=self.device != "cpu")
