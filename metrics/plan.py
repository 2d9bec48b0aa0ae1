"""The plan of a measurement: which frames of a clip are aligned with each other."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from metrics.clip import Clip
from metrics.geometry import Geometry

# A motion field whose values lie this near to each other is taken as uniform, px.
UNIFORM = 1e-4
# Rows and columns of a field of which one is looked at first.
_THIN = 16

# Motion is held for a whole span, so a span under non-uniform motion ends here: frames, and pixels in all of them.
LONGEST_UNWARPED = 32
MOST_UNWARPED = 2**25

# A span may be so long that this share of what a single frame would show is still measured. Under a uniform motion
# long spans cost nothing but area; unwarped ones also lose accuracy.
KEPT = 0.2
KEPT_UNWARPED = 0.45

# What changes more slowly than a span is long reads as static, and of an error fixed to the screen what it does not
# travel: spans shorter than this, frames and px, are made only where the longer ones leave next to nothing, this share
# of enough.
SHORTEST = 16
SHORTEST_TRAVEL = 50.0
LITTLE = 1 / 3

Bounds = tuple[int, int]
"""A span's first frame, and the one after its last."""


@dataclass(frozen=True)
class Plan:
    """A clip's spans before they are made: a small value that is the same for every process that makes some of them.

    steps: [count, 2] (y, x) px by which the whole picture moves into each frame; None if it does not move as one.
    bounds: of every span, in order.
    """

    steps: NDArray[np.float64] | None
    bounds: tuple[Bounds, ...]


class Tried(Protocol):
    """A span that is tried."""

    @property
    def measured(self) -> float:
        """Share of the frame that its tiles weigh, 0..1."""


T = TypeVar("T", bound=Tried)


def plan_shots(
    geometry: Geometry, steps: NDArray[np.float64] | None, make: Callable[[int, int], T]
) -> Iterator[tuple[list[Bounds], T]]:
    """Cut every shot of a clip in spans as long as tiles stay in view; yields a shot's, and the middle one, made.

    make: start, stop -> a span. The spans of a shot are about equal, 1, 2, 4, ... of them: as few as measure enough of
    what a single frame shows.
    """
    for first, last in pairwise([0, *geometry.clip.cuts, geometry.count]):
        longest = last - first if steps is not None else longest_unwarped(geometry.clip)
        yield _plan_shot(first, last, make, longest, steps)


def _plan_shot(
    first: int, last: int, make: Callable[[int, int], T], longest: int, steps: NDArray[np.float64] | None
) -> tuple[list[Bounds], T]:
    """The spans of frames first..last-1, and the middle one. longest: frames of one at most."""
    count, middle = last - first, (first + last) // 2
    enough = (KEPT if steps is not None else KEPT_UNWARPED) * make(middle, middle + 1).measured
    number = -(-count // longest)
    while True:
        edges = np.linspace(first, last, number + 1).round().astype(int)
        bounds = [(int(start), int(stop)) for start, stop in pairwise(edges)]
        span = make(*bounds[number // 2])
        short = span.measured > LITTLE * enough and _too_short(count / (2 * number), steps)
        if span.measured >= enough or count < 4 * number or short:
            return bounds, span
        number *= 2


def _too_short(count: float, steps: NDArray[np.float64] | None) -> bool:
    """Whether a span of so many frames is too short to show what moves against the surface."""
    travel = np.inf if steps is None or len(steps) < 2 else count * float(np.hypot(*steps[1:].mean(axis=0)))
    return count < SHORTEST or travel < SHORTEST_TRAVEL


def longest_unwarped(clip: Clip) -> int:
    """Frames of a span under non-uniform motion at most."""
    height, width = clip.shape
    return min(LONGEST_UNWARPED, max(SHORTEST, MOST_UNWARPED // (height * width)))


def uniform_steps(geometry: Geometry) -> NDArray[np.float64] | None:
    """[count, 2] (y, x) px by which the whole picture moves into each frame, or None if it is not so.

    A field is uniform if it varies by no more than UNIFORM px over the covered pixels; its mean is the step. Into the
    first frame of a shot nothing moves.
    """
    clip = geometry.clip
    if not callable(clip.motion):
        return np.tile(np.asarray(clip.motion, dtype=np.float64)[::-1], (clip.count, 1))
    steps = np.zeros((clip.count, 2))
    for t in range(1, clip.count):
        if t in clip.cuts:
            continue
        surface = geometry.surface(t)
        # Most fields that vary do so among a few pixels.
        for thin in (_THIN, 1):
            seen = surface.motion[::thin, ::thin][surface.whole[::thin, ::thin]]
            if len(seen) and max(np.ptp(seen[:, axis]) for axis in range(2)) > UNIFORM:
                return None
        steps[t] = seen.mean(axis=0, dtype=np.float64)[::-1] if len(seen) else steps[t - 1]
    return steps


def velocity_of(clip: Clip, steps: NDArray[np.float64] | None) -> tuple[float, float] | None:
    """(dx, dy) px a frame, if all steps within a shot are the same to a thousandth of a pixel over the clip."""
    if not callable(clip.motion):
        return clip.motion
    within = [t for t in range(1, clip.count) if t not in clip.cuts]
    if steps is None or not within:
        return None
    mean = steps[within].mean(axis=0)
    strayed = np.cumsum(steps[within] - mean, axis=0)
    return (float(mean[1]), float(mean[0])) if np.max(np.abs(strayed)) < 1e-3 else None
