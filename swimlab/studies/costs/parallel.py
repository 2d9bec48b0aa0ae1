"""What the machine itself gives two threads: the kernels of two frames, on one thread and on one each.

Cores may share memory and clock, or be two hardware threads of one core; then no program is twice as fast on both.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import warp as wp

from metrics.kernels.launch import Launcher, OnRows, Own, no_inputs
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Task


class WholeLauncher(Launcher):
    """A launcher of one thread that starts a kernel over all rows at once, and holds these launches."""

    def __init__(self) -> None:
        super().__init__(threads=1)
        self.held: list[Any] = []

    def laid_out(
        self,
        rows: int,
        kernel: wp.Kernel,
        width: tuple[int, ...],
        inputs: Sequence[Any],
        *,
        each: int = 1,
        strip: int = 0,
        n: int = 1,
        own: Own = no_inputs,
    ) -> OnRows:
        """As the launcher does it, but in one strip."""

        def dim(count: int) -> tuple[int, ...]:
            return (-(-count // each), *width)

        command = self.record(kernel, dim(rows), [0, *inputs, *self.made(own, 1)])

        def run(some: range = range(rows)) -> None:
            command.only(some, dim)
            self.held.append(command)
            self.start(command)

        return run


def parallel_tasks(stage: Stage, variant: Variant, launcher: WholeLauncher, pool: ThreadPoolExecutor) -> list[Task]:
    """The kernels over rows of two frames: one frame after the other, and both at the same time.

    Each frame has a picture of its own. The stage is of the launcher; `pool` has a thread for the second frame.
    """
    frames: list[list[Any]] = []
    for _ in range(2):
        launcher.held = []
        variant.begin()(stage.shot(stage.frames[0]))
        frames.append(launcher.held)

    def draw(frame: Sequence[Any]) -> None:
        for command in frame:
            command.launch()

    def one_by_one() -> None:
        for frame in frames:
            draw(frame)

    def at_once() -> None:
        other = pool.submit(draw, frames[1])
        draw(frames[0])
        other.result()

    return [lambda _: one_by_one, lambda _: at_once]
