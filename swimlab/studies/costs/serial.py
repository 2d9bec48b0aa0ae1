"""How much of the work is serial: times on one thread and on two, by Amdahl's law."""

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from statistics import median, quantiles
from typing import NamedTuple

import numpy as np

from metrics import measure
from metrics.kernels.launch import Launcher
from sequences import Sequence as Scenery
from swimlab.render.material import load_material
from swimlab.studies.bench import Clips, growing
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Task, Time, in_turns, wall

RENDERED = ("pixel-point", "pixel-trilinear", "pixel-aniso", "vmf")
RENDER_SIZE = (1280, 720)
MEASURE_SIZE = (1920, 1080)
MEASURED = "measuring"
FRAMES = 3
"""Frames of the clip that is measured."""


@dataclass(frozen=True)
class Serial:
    """What is done, at a size (px), with milliseconds by the clock on one thread and on two.

    shares: in each round the part s of the work for which the second thread is of no use, t2/t1 = s + (1 - s)/2
    (Amdahl 1967); beyond 0..1 where something else disturbed the round. alone: of the time of all cores what the
    calling thread spent, while no other could work for it; other programs do not disturb it. busy: cores at work on
    average with two threads.
    """

    what: str
    size: tuple[int, int]
    one_ms: float
    two_ms: float
    shares: Sequence[float]
    alone: float
    busy: float

    @property
    def share(self) -> float:
        """The median of the rounds."""
        return median(self.shares)

    @property
    def quartiles(self) -> tuple[float, float]:
        """Of the rounds."""
        low, _, high = quantiles(self.shares, n=4) if len(self.shares) > 1 else [self.share] * 3
        return low, high


def serial_share(one: float, two: float) -> float:
    """The serial part of work that takes `one` on one thread and `two` on two."""
    return 2 * two / one - 1


class Round(NamedTuple):
    """Times of a round, and what the calling thread spent of them, ms."""

    time: Time
    alone: float


def of_rounds(what: str, size: tuple[int, int], one: Sequence[Round], two: Sequence[Round]) -> Serial:
    """From rounds on one thread and on two, paired."""
    return Serial(
        what,
        size,
        one_ms=wall([each.time for each in one]),
        two_ms=wall([each.time for each in two]),
        shares=[serial_share(a.time.wall, b.time.wall) for a, b in zip(one, two, strict=True)],
        alone=median(each.alone / each.time.cpu for each in two),
        busy=median(each.time.cpu / each.time.wall for each in two),
    )


def serial_study(
    sequence: Scenery,
    *,
    rounds: int,
    render_size: tuple[int, int] = RENDER_SIZE,
    measure_size: tuple[int, int] = MEASURE_SIZE,
    advance: Callable[[str], None] = lambda _: None,
) -> list[Serial]:
    """Time rendering and measuring on one thread and on two, in turns. `advance` is called after each of the two."""
    with ExitStack() as stack:
        tasks: dict[tuple[str, int], Task] = {}
        for threads in (1, 2):
            launcher = stack.enter_context(Launcher(threads=threads))
            sized = sequence.with_changes(size=render_size)
            stage = Stage(
                sized, [0], samples=4, launcher=launcher, material=load_material(sized, launcher, twisted=False)
            )
            tasks |= {(name, threads): whole_frame(stage, Variant(name, name)) for name in RENDERED}
        times = _timed(tasks, rounds)
    found = [of_rounds(name, render_size, times[name, 1], times[name, 2]) for name in RENDERED]
    advance("rendering")
    times = _timed({(MEASURED, threads): _measuring(measure_size, threads) for threads in (1, 2)}, rounds)
    advance(MEASURED)
    return [*found, of_rounds(MEASURED, measure_size, times[MEASURED, 1], times[MEASURED, 2])]


def _timed(tasks: Mapping[tuple[str, int], Task], rounds: int) -> dict[tuple[str, int], list[Round]]:
    alone: dict[str, list[float]] = {}

    def noted(label: str, task: Task) -> Task:
        alone[label] = []

        def prepare(turn: int) -> Callable[[], object]:
            run = task(turn)

            def work() -> None:
                began = time.thread_time()
                run()
                alone[label].append(1e3 * (time.thread_time() - began))

            return work

        return prepare

    labels = {f"{name} {threads}": (name, threads) for name, threads in tasks}
    times = in_turns({label: noted(label, tasks[key]) for label, key in labels.items()}, rounds)
    return {
        key: [Round(each, ms) for each, ms in zip(times[label], alone[label][1:], strict=True)]
        for label, key in labels.items()
    }


def whole_frame(stage: Stage, variant: Variant) -> Task:
    """Rendering one frame, the next of the sequence each turn, with the mesh and its set-up."""
    render = variant.begin()
    return lambda turn: lambda: render(stage.shot(stage.frames[0] + turn))


def _measuring(size: tuple[int, int], threads: int) -> Task:
    """All measures of a clip of noise in which every pixel has a vector of its own."""
    width, height = size
    rng = np.random.default_rng(0)
    pool = rng.random((height + FRAMES, width + FRAMES, 3), np.float32)
    still, motion = rng.random((height, width, 3), np.float32), growing(width, height)
    made = Clips(lambda t: pool[t : t + height, t : t + width], lambda _: still, lambda _: motion, FRAMES)
    return lambda turn: lambda: measure(*made.pair(unwarped=True), threads=threads)
