"""Motion verified by warping: the right reading of the vectors brings an earlier frame onto a later one.

For a few pairs of frames the later one is compared with the earlier one taken from where the motion says; so for every
sign and direction, and for no motion at all. Residuals are rms differences, but for the tenth of the points that differ
most, since what comes into view was nowhere before; over those of points paired at random: 0 for a perfect match, 1 for
pictures that have nothing to do with each other.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swimlab.footage.motion import Motion, Points
from swimlab.frames import FrameError, Image

GIVEN = "as given"
IDENTITY = "no motion"

CLEAR = 0.8
"""A reading wins clearly where its residual is under this share of the given one's: two thirds of the energy."""

TRAVEL = 1.5
"""Frames are compared so far apart that a quarter of the covered points travels this far, px: the rest may be sky."""
APART = 16
"""... but no more frames apart than this."""
LEAST = 0.2
"""Less travel than this cannot be told from none, px."""

WHOLE = 1 - 1e-6
"""Coverage from which on a pixel is wholly covered."""

_PAIRS = 3
_POINTS = 20_000
_FLAT = 1e-6
_HIDDEN = 0.1
"""Share of the points that may have come into view, or be at an edge of the motion."""
_MOVING = 0.75
_SEEN = 0.05
"""Share of the points that must stay in the frame under every reading."""


@dataclass(frozen=True)
class Verification:
    """residuals: reading -> 0..1 and more; empty where nothing could be compared, for the reason given.

    settings: reading -> the options that choose it.
    """

    residuals: dict[str, float]
    settings: dict[str, str]
    reason: str = ""

    def lines(self) -> list[str]:
        """What to print."""
        if self.reason:
            return [f"motion not verified: {self.reason}"]
        listed = ", ".join(f"{name} {value:.3f}" for name, value in self.residuals.items())
        lines = [f"motion verified by warping, residuals: {listed}"]
        if self.residuals[GIVEN] > CLEAR * self.residuals[IDENTITY]:
            lines.append("the motion hardly explains how the frames change: check its unit and scale")
        return lines

    def check(self) -> None:
        """Raise FrameError where no motion or another reading explains the frames clearly better than the given one."""
        if self.reason:
            return
        given, best = self.residuals[GIVEN], min(self.residuals, key=lambda name: self.residuals[name])
        if self.residuals[best] >= CLEAR * given:
            return
        found = f"leaves {self.residuals[best]:.3f} of the change between frames, the motion as given {given:.3f}"
        if best == IDENTITY:
            raise FrameError(
                f"--motion: does not fit the frames: no motion at all {found}. Check its channels, unit and scale, or "
                "measure all the same with --motion-unverified"
            )
        raise FrameError(
            f"--motion: does not fit the frames: {best} {found}. Use {self.settings[best]}, or measure all the same "
            "with --motion-unverified"
        )


def verify(
    motion: Motion,
    picture: Callable[[int], Image],
    coverage: Callable[[int], Image] | None,
    frames: list[int],
) -> Verification:
    """Compare frames under every reading of the motion.

    picture: index -> [H, W, 3] radiance, of the reference where there is one. coverage: index -> [H, W], compared where
    it is 1. frames: the indices that are measured, in order.
    """
    variants = motion.variants()
    readings = {GIVEN: motion} | {name: other for name, (_, other) in variants.items()}
    settings = {name: setting for name, (setting, _) in variants.items()}
    apart, travel = _far_enough(motion, picture(frames[0]).shape[:2], coverage, frames)
    if travel < LEAST:
        still = _compare({}, _Pair(picture, coverage, frames[apart], frames[0]))
        change = "" if still is None else f", while {np.sqrt(still[0][IDENTITY] / still[1]):.3f} of it changes"
        return Verification({}, settings, f"the picture travels by {travel:.2g} px in {apart} frames only{change}")
    ends = sorted({apart, (apart + len(frames) - 1) // 2, len(frames) - 1})[:_PAIRS]
    energy: dict[str, float] = dict.fromkeys((*readings, IDENTITY), 0.0)
    spread = 0.0
    for end in ends:
        late, early = frames[end], frames[end - apart]
        compared = _compare(readings, _Pair(picture, coverage, late, early))
        if compared is None:
            continue
        for name, value in compared[0].items():
            energy[name] += value
        spread += compared[1]
    if spread <= 0:
        return Verification({}, settings, "the picture is flat, or leaves the frame under this motion")
    return Verification({name: float(np.sqrt(value / spread)) for name, value in energy.items()}, settings)


class _Pair:
    """A later and an earlier frame, in grey codes that keep highlights from ruling."""

    def __init__(
        self,
        picture: Callable[[int], Image],
        coverage: Callable[[int], Image] | None,
        late: int,
        early: int,
    ) -> None:
        self.late, self.early = late, early
        first, second = (picture(index).mean(axis=2, dtype=np.float64) for index in (late, early))
        typical = float(np.abs(first).mean()) or 1.0
        self.first, self.second = (grey / (typical + np.abs(grey)) for grey in (first, second))
        self.covered = [None if coverage is None else coverage(index) >= WHOLE for index in (late, early)]


def _compare(readings: dict[str, Motion], pair: _Pair) -> tuple[dict[str, float], float] | None:
    """Squared residuals of each reading and of none, and of unrelated pictures; None where there is nothing to see."""
    points = _grid(pair.first.shape)
    landed = {name: motion.back(points, pair.late, pair.early) for name, motion in readings.items()}
    landed[IDENTITY] = points
    seen = np.ones(points.shape[1], dtype=bool)
    for place, covered in [(points, pair.covered[0]), *((place, pair.covered[1]) for place in landed.values())]:
        seen &= _inside(place, pair.first.shape, covered)
    if seen.sum() < max(2, _SEEN * len(seen)):
        return None
    target = pair.first[tuple(points[:, seen].astype(np.intp))]
    spread = _mean_square(target - np.random.default_rng(0).permutation(target))
    if spread < _FLAT**2:
        return None
    spline = ndimage.spline_filter(pair.second, order=3, mode="mirror")
    squares = {}
    for name, place in landed.items():
        warped = ndimage.map_coordinates(spline, place[:, seen], order=3, mode="mirror", prefilter=False)
        squares[name] = _mean_square(warped - target)
    return squares, spread


def _mean_square(differences: NDArray[np.float64]) -> float:
    """Mean square of all but the largest differences."""
    kept = max(1, int((1 - _HIDDEN) * differences.size))
    return float(np.partition(differences**2, kept - 1)[:kept].mean())


def _far_enough(
    motion: Motion, shape: tuple[int, ...], coverage: Callable[[int], Image] | None, frames: list[int]
) -> tuple[int, float]:
    """How many frames to compare apart, and how far a quarter of the covered points travels in them at least, px."""
    end = len(frames) // 2
    points = _grid(shape)
    if coverage is not None:
        covered = coverage(frames[end])[tuple(points.astype(np.intp))] >= WHOLE
        points = points[:, covered] if covered.any() else points
    place, apart, travel = points, 0, 0.0
    while apart < min(APART, end) and travel < TRAVEL:
        place = motion.back(place, frames[end - apart], frames[end - apart - 1])
        apart += 1
        travel = float(np.quantile(np.hypot(*(place - points)), _MOVING))
    return apart, travel


def _grid(shape: tuple[int, ...]) -> Points:
    """[2, n] pixels spread evenly over the picture."""
    step = max(1, int(np.ceil(np.sqrt(shape[0] * shape[1] / _POINTS))))
    rows, columns = np.mgrid[step // 2 : shape[0] : step, step // 2 : shape[1] : step]
    return np.stack([rows.ravel(), columns.ravel()]).astype(np.float64)


def _inside(place: Points, shape: tuple[int, ...], covered: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
    row, column = (np.rint(p).astype(np.intp) for p in place)
    inside = (row >= 1) & (row < shape[0] - 1) & (column >= 1) & (column < shape[1] - 1)
    if covered is None:
        return np.asarray(inside)
    return np.asarray(inside & covered[np.where(inside, row, 0), np.where(inside, column, 0)])
