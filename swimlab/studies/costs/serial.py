"""How much of the work is serial: times on one thread and on two, by Amdahl's law, and what of it is the program's."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from statistics import median, quantiles

import numpy as np

from metrics import measure
from metrics.kernels.launch import Launcher
from sequences import Sequence as Scenery
from swimlab.render.material import load_material
from swimlab.studies.bench import Clips, growing
from swimlab.studies.costs.parallel import WholeLauncher, parallel_tasks
from swimlab.studies.costs.watched import Frame, WatchedLauncher, watched_frames
from swimlab.studies.trials import Stage, Variant
from swimlab.studies.turns import Task, Time, in_turns, wall

RENDERED = ("pixel-point", "pixel-trilinear", "pixel-aniso", "vmf")
RENDER_SIZE = (1280, 720)
MEASURE_SIZE = (1920, 1080)
MEASURED = "measuring"
THREADS = (1, 2)
FRAMES, ROUNDS = 8, 5
"""Frames of the clip that is measured, and rounds of it at most: each takes ten seconds."""


@dataclass(frozen=True)
class Serial:
    """What is done, at a size (px), with milliseconds by the clock on one thread and on two.

    shares: in each round the part s of the work for which the second thread is of no use, t2/t1 = s + (1 - s)/2
    (Amdahl 1967); beyond 0..1 where something else disturbed the round. own: the program's share of that, in each
    round: of the work on two threads what is done while the other has nothing to do; the rest is the machine's, or that
    of other programs. gain: how many times as fast the machine runs the same kernels as two independent launches at
    once as one after the other: 2 where cores share nothing. outside: of the time of all cores on one thread what no
    kernel spent. Both are None where not all shared work is kernels; there threads come and go, nobody knows how long
    they waited for a core, and `own` is the most that it can be. busy: cores at work on average with two threads.
    """

    what: str
    size: tuple[int, int]
    one_ms: float
    two_ms: float
    shares: Sequence[float]
    own: Sequence[float]
    gain: float | None
    outside: float | None
    busy: float

    @property
    def share(self) -> float:
        """The median of the rounds."""
        return median(self.shares)

    @property
    def quartiles(self) -> tuple[float, float]:
        """Of the rounds."""
        return _quartiles(self.shares)

    @property
    def own_share(self) -> float:
        """The median of the rounds."""
        return median(self.own)

    @property
    def own_quartiles(self) -> tuple[float, float]:
        """Of the rounds."""
        return _quartiles(self.own)


def _quartiles(values: Sequence[float]) -> tuple[float, float]:
    low, _, high = quantiles(values, n=4) if len(values) > 1 else [median(values)] * 3
    return low, high


def serial_share(one: float, two: float) -> float:
    """The serial part of work that takes `one` on one thread and `two` on two."""
    return 2 * two / one - 1


def own_share(two: Time) -> float:
    """Of the work of two threads, the part that is done while the other has nothing to do.

    A thread that is ready and has no core, since the machine or another program holds it, does have something to do.
    """
    return (2 * two.wall - two.cpu - two.waited) / two.cpu


@dataclass(frozen=True)
class Rounds:
    """Times of rounds, paired: on one thread, on two; of the kernels of two frames one after the other, at once.

    kernels: ms in kernels of each round on one thread.
    """

    one: Sequence[Time]
    two: Sequence[Time]
    kernels: Sequence[float] = ()
    in_turn: Sequence[Time] = ()
    at_once: Sequence[Time] = ()

    def serial(self, what: str, size: tuple[int, int]) -> Serial:
        """What they come to."""
        outside = [1 - ms / each.cpu for ms, each in zip(self.kernels, self.one, strict=True)] if self.kernels else None
        gains = [a.wall / b.wall for a, b in zip(self.in_turn, self.at_once, strict=True)]
        return Serial(
            what,
            size,
            one_ms=wall(self.one),
            two_ms=wall(self.two),
            shares=[serial_share(a.wall, b.wall) for a, b in zip(self.one, self.two, strict=True)],
            own=[own_share(each if self.kernels else each._replace(waited=0.0)) for each in self.two],
            gain=median(gains) if gains else None,
            outside=median(outside) if outside else None,
            busy=median(each.cpu / each.wall for each in self.two),
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
    sized = sequence.with_changes(size=render_size)
    with ExitStack() as stack:
        tasks: dict[str, Task] = {}
        noted: dict[str, list[Frame]] = {}
        for threads in THREADS:
            launcher = stack.enter_context(WatchedLauncher(threads=threads))
            stage = _stage(sized, launcher)
            for name in RENDERED:
                label = f"{name} {threads}"
                tasks[label], noted[label] = watched_frames(stage, Variant(name, name), launcher)
        whole, pool = stack.enter_context(WholeLauncher()), stack.enter_context(ThreadPoolExecutor(1))
        stage = _stage(sized, whole)
        for name in RENDERED:
            kernels_alone = parallel_tasks(stage, Variant(name, name), whole, pool)
            tasks[f"{name} in turn"], tasks[f"{name} at once"] = kernels_alone
        times = in_turns(tasks, rounds)
    found = []
    for name in RENDERED:
        kernels = [sum(frame.kernels.values()) for frame in noted[f"{name} 1"][1:]]
        one, two, in_turn, at_once = (times[f"{name} {how}"] for how in ("1", "2", "in turn", "at once"))
        found.append(Rounds(one, two, kernels, in_turn, at_once).serial(name, render_size))
    advance("rendering")
    measured = {str(threads): _measuring(measure_size, threads) for threads in THREADS}
    alone, both = in_turns(measured, min(rounds, ROUNDS)).values()
    advance(MEASURED)
    return [*found, Rounds(alone, both).serial(MEASURED, measure_size)]


def _stage(sequence: Scenery, launcher: Launcher) -> Stage:
    material = load_material(sequence, launcher, twisted=False)
    return Stage(sequence, [0], samples=4, launcher=launcher, material=material)


def _measuring(size: tuple[int, int], threads: int) -> Task:
    """All measures of a clip of noise in which every pixel has a vector of its own."""
    width, height = size
    rng = np.random.default_rng(0)
    pool = rng.random((height + FRAMES, width + FRAMES, 3), np.float32)
    still, motion = rng.random((height, width, 3), np.float32), growing(width, height)
    made = Clips(lambda t: pool[t : t + height, t : t + width], lambda _: still, lambda _: motion, FRAMES)
    return lambda turn: lambda: measure(*made.pair(unwarped=True), threads=threads)
