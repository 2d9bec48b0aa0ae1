"""Other readings of the same motion weighed against the given one: signs, directions, units, lengths, and none."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import get_args

import numpy as np

from metrics.clip import WHOLE
from swimlab.footage.convention import Direction
from swimlab.footage.motion import EstimatedMotion, Motion, Points
from swimlab.footage.warping import GIVEN, IDENTITY, Pair, Reading, Rival, grid, residuals_of
from swimlab.runs.frames import Image

FLOWING = "optical flow"

CLEAR = 0.8
"""A reading wins clearly where its residual is under this share of the given one's: two thirds of the energy."""
NOTHING = 0.005
"""A reading that leaves less loses to no other: there is nothing left to explain."""
POOR = 0.5
"""Residual from which on motion does not explain the frames, unless they are noise: noise makes this residual where its
rms is 0.58 of the picture's own. A reading that leaves more refuses no other: smooth noise may look the same by
chance."""

TRAVEL = 1.5
"""Frames are compared so far apart that a quarter of the covered points travels this far, px: the rest may be sky."""
APART = 16
"""... but no more frames apart than this."""
LEAST = 0.2
"""Less travel than this cannot be distinguished from none, px."""

_PAIRS = 3
_ALIKE = 0.01
"""Residuals nearer to each other than this count as equal."""
_PACED = 2_000
"""Points that say how fast a reading is."""
_MOVING = 0.75


@dataclass(frozen=True)
class Pace:
    """How far a quarter of the covered points travels at least, px: in one frame, and in so many frames apart."""

    apart: int
    step: float
    travel: float


@dataclass(frozen=True)
class Weighing:
    """rivals: the given reading, none, and the others, by name. settings: what chooses them. pace: of the given one."""

    rivals: dict[str, Rival]
    settings: dict[str, str]
    pace: Pace
    shape: tuple[int, int]

    @property
    def residuals(self) -> dict[str, float]:
        """Reading -> 0..1 and more; the given one is lacking where it leaves the frame, or the picture is flat."""
        return {name: rival.residual for name, rival in self.rivals.items()}

    @property
    def beyond_belief(self) -> bool:
        """Whether the motion leaves the picture at once."""
        return self.pace.step > max(self.shape)

    @property
    def best(self) -> str:
        """The reading that fits best, if clearly better than the given one; else empty.

        Of readings that fit equally well, as directions do where the motion is steady, the one that changes least.
        """
        winners = [
            name
            for name, rival in self.rivals.items()
            if rival.given >= NOTHING and rival.ratio < CLEAR and rival.residual <= POOR
        ]
        least = min((self.rivals[name].residual for name in winners), default=0.0)
        near = [name for name in winners if _as_good(self.rivals[name].residual, least)]
        return next((name for name in [*self.settings, IDENTITY] if name in near), "")

    def error(self) -> str:
        """What to say where another reading or none fits clearly better, or the given one is beyond belief."""
        best = self.best
        named = "no motion at all" if best == IDENTITY else best
        found = f"{named} leaves {self.rivals[best].residual:.3f} of the change between frames" if best else ""
        if self.beyond_belief:
            mend = "check --motion-convention, --motion-unit and --motion-scale"
            mend = f"{found}. Use {self.settings[best]}" if best in self.settings else mend
            size = f"{self.shape[1]}x{self.shape[0]} px"
            return f"moves {self.pace.step:.0f} px a frame in a picture of {size}: is its unit right? {mend}"
        if not best:
            return ""
        rest = f", the motion as given {self.rivals[best].given:.3f}" if GIVEN in self.rivals else ""
        mend = f"Use {self.settings[best]}" if best in self.settings else "Check its channels, unit and scale"
        return f"does not fit the frames: {found}{rest}. {mend}"

    def worth_naming(self) -> str:
        """The residuals of the given reading, none, and the best of the others."""
        residuals = self.residuals
        named = [name for name in (GIVEN, IDENTITY) if name in residuals]
        others = [name for name in residuals if name not in named]
        named += [min(others, key=lambda name: residuals[name])] if others else []
        return ", ".join(f"{name} {residuals[name]:.3f}" for name in named)

    def undecided(self) -> str:
        """What to say where vectors of the other direction fit as well as the given ones; else empty."""
        near = [
            name
            for name in get_args(Direction)
            if (rival := self.rivals.get(name)) and _as_good(rival.residual, rival.given)
        ]
        return f"{near[0]} vectors would fit as well, as the motion is too steady to tell" if near else ""


def _as_good(residual: float, least: float) -> bool:
    return residual <= least + min(_ALIKE, 0.2 * least + _ALIKE / 4)


def weigh(
    motion: Motion,
    picture: Callable[[int], Image],
    coverage: Callable[[int], Image] | None,
    frames: list[int],
    fitted: Mapping[str, tuple[str, Reading]],
) -> Weighing:
    """Compare frames under every reading of the motion, each so far apart that it moves far enough.

    fitted: further readings, as `Motion.variants` has them, which count after those.
    """
    shape = picture(frames[0]).shape[:2]
    variants: dict[str, tuple[str, Reading]] = {**motion.variants(), **fitted}
    readings: dict[str, Reading] = {GIVEN: motion} | {name: other for name, (_, other) in variants.items()}
    points = _covered(shape, coverage, frames[len(frames) // 2])
    paces = _paces(readings, points, frames)
    sane = {name: pace for name, pace in paces.items() if pace.step <= max(shape)}
    apart = paces[GIVEN].apart
    rivals: dict[str, Rival] = {}
    moving = [name for name, pace in sane.items() if pace.travel >= LEAST]
    for distance in sorted({sane[name].apart for name in moving} | {apart}, key=lambda distance: distance != apart):
        own = distance == apart
        chosen = [name for name in moving if own or sane[name].apart == distance]
        compared = {name: readings[name] for name in (GIVEN, *chosen) if name in sane}
        pairs = [Pair(picture, coverage, *ends) for ends in _ends(frames, distance, _PAIRS if own else 1)]
        for name, rival in residuals_of(compared, pairs).items():
            # The given reading, and none, count over the given one's distance, others where they do best against it.
            if name not in rivals or (name not in (GIVEN, IDENTITY) and rival.ratio < rivals[name].ratio):
                rivals[name] = rival
    return Weighing(rivals, {name: setting for name, (setting, _) in variants.items()}, paces[GIVEN], shape)


def against_flow(
    motion: Motion, picture: Callable[[int], Image], coverage: Callable[[int], Image] | None, frames: list[int]
) -> Rival | None:
    """The residual of optical flow from one frame to the next; None where every other one is left out."""
    neighbours = [(late, early) for early, late in pairwise(frames) if late == early + 1]
    if not neighbours:
        return None
    pair = Pair(picture, coverage, *neighbours[len(neighbours) // 2])
    return residuals_of({GIVEN: motion, FLOWING: EstimatedMotion(picture)}, [pair]).get(FLOWING)


def _ends(frames: list[int], apart: int, count: int) -> list[tuple[int, int]]:
    """Later and earlier frames, spread over the clip, or in its middle."""
    last = len(frames) - 1
    ends = {apart, (apart + last) // 2, last} if count > 1 else {(apart + last) // 2}
    return [(frames[end], frames[end - apart]) for end in sorted(ends)]


def _paces(readings: Mapping[str, Reading], points: Points, frames: list[int]) -> dict[str, Pace]:
    """How far each reading goes, until it goes far enough; frame by frame, so that files are read once for all."""
    end = len(frames) // 2
    paces: dict[str, Pace] = {}
    places = dict.fromkeys(readings, points)
    for apart in range(1, min(APART, end) + 1):
        late, early = frames[end - apart + 1], frames[end - apart]
        for name in [name for name in readings if name not in paces or paces[name].travel < TRAVEL]:
            places[name] = readings[name].back(places[name], late, early)
            travel = float(np.quantile(np.hypot(*(places[name] - points)), _MOVING))
            paces[name] = Pace(apart, paces[name].step if name in paces else travel, travel)
    return paces


def _covered(shape: tuple[int, ...], coverage: Callable[[int], Image] | None, frame: int) -> Points:
    """A few points, of the covered ones if there are any."""
    points = grid(shape, _PACED)
    if coverage is not None:
        covered = coverage(frame)[tuple(points.astype(np.intp))] >= WHOLE
        points = points[:, covered] if covered.any() else points
    return points
