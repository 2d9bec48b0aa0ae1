"""How much of the work is serial: times on one thread and on two, by Amdahl's law."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from statistics import median, quantiles

import numpy as np

from metrics import measure
from sequences import Sequence as Scenery
from swimlab.render.material import load_material
from swimlab.studies.bench import Clips, growing
from swimlab.studies.costs.watched import Frame, WatchedLauncher, watched_frames
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Task, Time, in_turns, wall

RENDERED = ("pixel-point", "pixel-trilinear", "pixel-aniso", "vmf")
RENDER_SIZE = (1280, 720)
MEASURE_SIZE = (1920, 1080)
MEASURED = "measuring"
THREADS = (1, 2)
FRAMES = 3
"""Frames of the clip that is measured."""


@dataclass(frozen=True)
class Serial:
    """What is done, at a size (px), with milliseconds by the clock on one thread and on two.

    shares: in each round the part s of the work for which the second thread is of no use, t2/t1 = s + (1 - s)/2
    (Amdahl 1967); beyond 0..1 where something else disturbed the round. outside: of the time of all cores on one thread
    what no kernel spent, which is the most of a picture that is serial, and which other programs hardly disturb; None
    where not all shared work is kernels. busy: cores at work on average with two threads.
    """

    what: str
    size: tuple[int, int]
    one_ms: float
    two_ms: float
    shares: Sequence[float]
    outside: float | None
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


def of_times(
    what: str, size: tuple[int, int], one: Sequence[Time], two: Sequence[Time], kernels: Sequence[float] | None = None
) -> Serial:
    """From the times of rounds on one thread and on two, paired; kernels: ms in kernels of each round on one."""
    outside = [1 - ms / each.cpu for ms, each in zip(kernels, one, strict=True)] if kernels else None
    return Serial(
        what,
        size,
        one_ms=wall(one),
        two_ms=wall(two),
        shares=[serial_share(a.wall, b.wall) for a, b in zip(one, two, strict=True)],
        outside=median(outside) if outside else None,
        busy=median(each.cpu / each.wall for each in two),
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
        tasks: dict[str, Task] = {}
        noted: dict[str, list[Frame]] = {}
        for threads in THREADS:
            launcher = stack.enter_context(WatchedLauncher(threads=threads))
            sized = sequence.with_changes(size=render_size)
            material = load_material(sized, launcher, twisted=False)
            stage = Stage(sized, [0], samples=4, launcher=launcher, material=material)
            for name in RENDERED:
                label = f"{name} {threads}"
                tasks[label], noted[label] = watched_frames(stage, Variant(name, name), launcher)
        times = in_turns(tasks, rounds)
    found = []
    for name in RENDERED:
        one, two = f"{name} 1", f"{name} 2"
        kernels = [sum(frame.kernels.values()) for frame in noted[one][1:]]
        found.append(of_times(name, render_size, times[one], times[two], kernels))
    advance("rendering")
    alone, both = in_turns({str(threads): _measuring(measure_size, threads) for threads in THREADS}, rounds).values()
    advance(MEASURED)
    return [*found, of_times(MEASURED, measure_size, alone, both)]


def _measuring(size: tuple[int, int], threads: int) -> Task:
    """All measures of a clip of noise in which every pixel has a vector of its own."""
    width, height = size
    rng = np.random.default_rng(0)
    pool = rng.random((height + FRAMES, width + FRAMES, 3), np.float32)
    still, motion = rng.random((height, width, 3), np.float32), growing(width, height)
    made = Clips(lambda t: pool[t : t + height, t : t + width], lambda _: still, lambda _: motion, FRAMES)
    return lambda turn: lambda: measure(*made.pair(unwarped=True), threads=threads)
