"""The launcher: the one place where kernels are started, on all cores.

One launch on the CPU is a serial loop that releases the interpreter lock, so work is cut into strips of rows that a
pool of threads takes one after another. How it is cut never changes a bit of the result.
"""

import math
import os
import tempfile
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from copy import copy
from functools import lru_cache
from pathlib import Path
from threading import local
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.making import MAKING, made_once
from metrics.machine import cores, user
from metrics.memory import LARGE, let_go, unset

Item = TypeVar("Item")

STRIP_ROWS = 32
"""Rows of samples a task: enough tasks to even out cheap and expensive rows, few enough that starting them
costs nothing, and a strip's visibility buffer stays in the cache."""

LAST_ROWS = 16
"""Rows of samples of the smallest strip of those that shrink: as long as it takes, one thread may wait for another."""

_LOADED: set[tuple[str, wp.Kernel]] = set()


class Strip(NamedTuple):
    """A run of rows of a picture."""

    first: int
    rows: int


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
        self._pool = ThreadPoolExecutor(self.threads, thread_name_prefix="swimlab")

    def close(self) -> None:
        """Let the threads go, and the memory that was kept."""
        self._pool.shutdown()
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

        tasks = [self._pool.submit(work) for _ in range(min(self.threads, len(waiting)) - 1)]
        try:
            work()
            for task in tasks:
                if not task.cancel():  # a thread that has not begun by now finds nothing left
                    task.result()
        except BaseException:
            waiting.clear()
            wait([task for task in tasks if not task.cancel()])
            raise

    def strips(self, rows: int, n: int = 1) -> Sequence[Strip]:
        """Cut a picture with n x n samples a pixel into strips: one on a GPU, where a launch is parallel by itself."""
        height = max(1, STRIP_ROWS // n) if self.device == "cpu" else max(rows, 1)
        return [Strip(first, min(height, rows - first)) for first in range(0, rows, height)]

    def launch(self, kernel: wp.Kernel, dim: int | tuple[int, ...], inputs: Sequence[Any]) -> None:
        """Start one kernel in the calling thread."""
        self.start(self.record(kernel, dim, inputs))

    def record(self, kernel: wp.Kernel, dim: int | tuple[int, ...], inputs: Sequence[Any]) -> Any:
        """A launch that is ready to be started, several times if need be, by one thread at a time."""
        return _recorded(kernel, dim, inputs, self._on)

    def start(self, command: Any) -> None:
        """Start a recorded launch in the calling thread."""
        command.launch()

    def over(
        self,
        rows: int,
        kernel: wp.Kernel,
        width: tuple[int, ...],
        inputs: Sequence[Any],
        *,
        each: int = 1,
        strip: int = LAST_ROWS,
        n: int = 1,
        own: Callable[[int], Sequence[Any]] = lambda _: (),
    ) -> None:
        """Run a kernel over rows of a picture in strips, of n x n samples a pixel; its first input is the first row.

        Its dim is (rows, *width), or a kernel's thread takes `each` rows, of which strips are whole multiples.
        `own(rows)` makes the last inputs, for a strip alone: scratch of as many rows as are worked on at once. A launch
        is recorded once, copied for each of the launcher's threads, and started anew for each strip. strip: rows of
        samples that a strip has at least.
        """
        if rows == 0:
            return
        alone = self.device != "cpu" or self.threads == 1
        least = each * -(-max(1, strip // n) // each)
        strips = _shrinking(rows, rows if alone else least, self.threads)
        at_once = 1 if self.device == "cpu" else rows
        dims = [(-(-strip.rows // each), *width) for strip in strips]
        recorded = self.record(kernel, dims[0], [0, *inputs, *own(at_once)])
        idle = [(recorded, dims[0])]

        def run(index: int) -> None:
            try:
                command, dim = idle.pop()
            except IndexError:
                command, dim = _another(recorded, 1 + len(inputs), own(at_once)), ()
            if dim != dims[index]:
                command.set_dim(dims[index])
            command.set_param_at_index_from_ctype(0, strips[index].first)
            self.start(command)
            idle.append((command, dims[index]))

        self.each(range(len(strips)), run)

    def empty(self, shape: int | tuple[int, ...], dtype: Any) -> Any:
        """An uninitialised array on the device."""
        size = wp.types.type_size_in_bytes(dtype) * math.prod(shape if isinstance(shape, tuple) else (shape,))
        if self.device != "cpu" or size < LARGE:
            return wp.empty(shape, dtype=dtype, device=self._on)
        held = unset((size,), np.uint8)
        # Called when the array goes, and holds the memory until then.
        return wp.array(
            ptr=held.ctypes.data, dtype=dtype, shape=shape, device="cpu", deleter=lambda *_, held=held: None
        )

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

    def view(self, values: Any, dtype: Any) -> Any:
        """Values on the device, to be read: the same memory where that is the CPU's, and they are contiguous."""
        held = np.ascontiguousarray(values)
        return wp.array(held, dtype=dtype, device=self._on, copy=self.device != "cpu")


@lru_cache(maxsize=256)
def _shrinking(rows: int, unit: int, threads: int) -> tuple[Strip, ...]:
    """Strips of whole multiples of `unit` rows: each a half of what one thread would get of the rest, so that there are
    few, and the last are small enough to even out the threads' ends."""
    strips, first = [], 0
    while first < rows:
        units = -(-(rows - first) // unit)
        height = min(unit * -(-units // (2 * threads)), rows - first)
        strips.append(Strip(first, height))
        first += height
    return tuple(strips)


def on_cpu(kernel: wp.Kernel, dim: int, inputs: Sequence[Any]) -> None:
    """Run one kernel on the CPU in the calling thread, on the host's own contiguous arrays.

    Each thread records it once, which leaves a third of what it costs to start a kernel on arrays never seen.
    """
    if dim == 0:
        return
    held = _COMMANDS.held
    if kernel not in held:
        held[kernel] = _OnHost(_recorded(kernel, dim, inputs, "cpu"), dim, inputs)
    held[kernel].run(dim, inputs)


class _OnHost:
    """A recorded launch that is started anew on other arrays of the same kinds."""

    def __init__(self, command: Any, dim: int, inputs: Sequence[Any]) -> None:
        self._command, self._dim = command, dim
        self._kinds = [(each.dtype, each.ndim) if isinstance(each, np.ndarray) else None for each in inputs]
        self._descriptor = next(type(held) for held, kind in zip(command.params[1:], self._kinds, strict=True) if kind)

    def run(self, dim: int, inputs: Sequence[Any]) -> None:
        """Start it. Raises TypeError for an array of another kind, or with gaps."""
        if dim != self._dim:
            self._command.set_dim(dim)
            self._dim = dim
        for index, (value, kind) in enumerate(zip(inputs, self._kinds, strict=True)):
            self._command.set_param_at_index_from_ctype(index, value if kind is None else self._described(value, kind))
        self._command.launch()

    def _described(self, array: NDArray[Any], kind: tuple[np.dtype[Any], int]) -> Any:
        if (array.dtype, array.ndim) != kind or not array.flags.c_contiguous:
            raise TypeError(
                f"{array.dtype} {array.shape} by {array.strides} bytes: the kernel takes {kind} in one piece"
            )
        place, shape, strides = array.ctypes.data, array.shape, array.strides
        return self._descriptor(data=place, grad=0, ndim=array.ndim, shape=shape, strides=strides)


class _Commands(local):
    """A thread's recorded launches on the host's arrays, by kernel."""

    def __init__(self) -> None:
        self.held: dict[wp.Kernel, _OnHost] = {}


_COMMANDS = _Commands()


def _recorded(kernel: wp.Kernel, dim: int | tuple[int, ...], inputs: Sequence[Any], device: Any) -> Any:
    if (str(device), kernel) in _LOADED:
        return wp.launch(kernel, dim=dim, inputs=list(inputs), device=device, record_cmd=True)
    with MAKING:
        start_warp()
        command = wp.launch(kernel, dim=dim, inputs=list(inputs), device=device, record_cmd=True)
        _LOADED.add((str(device), kernel))
    return command


def _another(recorded: Any, first: int, own: Sequence[Any]) -> Any:
    """A launch like a recorded one, for another thread: inputs from `first` on are its own."""
    command = copy(recorded)
    vars(command).update({name: list(held) for name, held in vars(recorded).items() if isinstance(held, list)})
    command.set_param_at_index(0, 0)  # else both threads would write their first row to one number
    for index, value in enumerate(own, first):
        command.set_param_at_index(index, value)
    return command


@contextmanager
def _quiet_stderr() -> Iterator[None]:
    """Keep the driver's notices, which are written to file descriptor 2 from C, off the screen."""
    saved = os.dup(2)
    with Path(os.devnull).open("w") as sink:
        os.dup2(sink.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)


@made_once
def start_warp() -> Path:
    """Initialise Warp, quietly, with a kernel cache that can be written; return the cache's folder."""
    configured = os.environ.get("WARP_CACHE_PATH") or wp.config.kernel_cache_dir
    if configured is None:
        base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")  # noqa: PTH111, no home is no error
        configured = str(Path(base) / "swimlab" / f"warp-{wp.__version__}")
    folder = Path(configured)
    if not _writable(folder):
        folder = Path(tempfile.gettempdir()) / f"swimlab-kernels-{user()}"
        warnings.warn(f"kernel cache {configured} cannot be written; using {folder}", RuntimeWarning, stacklevel=2)
        folder.mkdir(parents=True, exist_ok=True)
    wp.config.log_level = wp.LOG_WARNING
    wp.config.kernel_cache_dir = str(folder)
    with _quiet_stderr():
        wp.init()  # type: ignore[no-untyped-call]
    return folder


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
