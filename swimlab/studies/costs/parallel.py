"""What the machine itself gives two threads: the kernels of two frames, on one thread and on one each.

Cores may share memory and clock, or be two hardware threads of one core; then no program is twice as fast on both.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from metrics.kernels.launch import Launcher
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Task


class WholeLauncher(Launcher):
    """A launcher of one thread, which starts a kernel over all rows at once, and holds its launches."""

    def __init__(self) -> None:
        super().__init__(threads=1)
        self._spares.close()  # what is held is not laid out again
        self.held: list[Any] = []

    def start(self, command: Any) -> None:
        """Start a recorded launch and hold it."""
        self.held.append(command)
        super().start(command)


def parallel_tasks(stage: Stage, variant: Variant, launcher: WholeLauncher, pool: ThreadPoolExecutor) -> list[Task]:
    """The kernels of two frames: one frame after the other, and both at the same time.

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
