"""A launcher that notes how long each kernel ran."""

import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import warp as wp

from metrics.kernels.crew import Together
from metrics.kernels.launch import Launcher
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Task


class WatchedLauncher(Launcher):
    """On the CPU a kernel's time is that of its threads, which other programs do not lengthen; on a GPU it is the
    clock's, and the launcher waits for each kernel.

    Where a crew helps it is the process's, with what waking the helpers takes. A system may not yet have counted the
    last of a helper's time, which then is in a later reading: take means or medians.
    """

    def __init__(self, *, threads: int | None = None, device: str = "cpu") -> None:
        super().__init__(threads=threads, device=device)
        self._noted: list[tuple[wp.Kernel, float]] = []

    def start(self, command: Any) -> None:
        """Start a recorded launch and note its time."""
        clock = self._clock(command)
        began = clock()
        super().start(command)
        self._noted.append((command.kernel, 1e3 * (clock() - began)))

    def take(self) -> Mapping[str, float]:
        """Milliseconds of all threads by kernel since the last call."""
        spent: dict[str, float] = defaultdict(float)
        noted, self._noted = self._noted, []
        for kernel, ms in noted:
            spent[kernel_name(kernel)] += ms
        return spent

    def _clock(self, command: Any) -> Callable[[], float]:
        if self.device == "cpu":
            # Of threads that start launches of their own each has its time; where a crew helps, nothing else runs.
            return time.process_time if isinstance(command, Together) else time.thread_time

        def when_done() -> float:
            wp.synchronize_device(self.device)
            return time.perf_counter()

        return when_done


class Frame(NamedTuple):
    """Milliseconds of all threads by kernel, and evaluations of the model."""

    kernels: Mapping[str, float]
    shaded: int


def watched_frames(stage: Stage, variant: Variant, launcher: WatchedLauncher) -> tuple[Task, list[Frame]]:
    """Rendering one frame in the midst of its sequence, mesh and set-up included; and what is noted of each.

    A turn renders the next two frames of the sequence: one to prepare, as what took its turn before has emptied the
    caches of all that the technique needs, and then the one that is timed and noted.
    """
    render, noted = variant.begin(), list[Frame]()

    def prepare(turn: int) -> Callable[[], object]:
        before = stage.frames[0] + 2 * turn
        render(stage.shot(before))
        launcher.take()

        def run() -> None:
            picture = render(stage.shot(before + 1))
            noted.append(Frame(launcher.take(), picture.shaded))

        return run

    return prepare, noted


def kernel_name(kernel: wp.Kernel) -> str:
    """The kernel's name, or that of the function which makes it for each case."""
    function: Any = kernel.func
    return str(function.__qualname__).split(".")[0]
