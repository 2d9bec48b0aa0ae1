"""The factor by which a motion is too short or too long, over as many frames as the surface stays in view."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.check.grey import Frames
from swimlab.footage.check.lucas_kanade import Fit, Values, fit_displacement
from swimlab.footage.motion import Motion, Points

LONGEST = 32
"""Frames that a baseline spans at most."""
LEAST = 0.2
"""An axis that travels less than this over a baseline has no factor, px."""

_WINDOWS = 3
_SEEN = 0.3
"""Share of the points that must stay in view."""


@dataclass(frozen=True)
class Scale:
    """How the motion is to be corrected over a baseline of `apart` frames; axes in the order x, y.

    factor: by which the motion is to be multiplied; 1 where it does not travel. drift: px a frame to be added where it
    does not. error: the standard error of either; infinite where the picture does not tell. travel: px over the
    baseline. explained: share of the energy left over the baseline that the correction takes away; better: share of the
    points that it does good.
    """

    factor: Values
    drift: Values
    error: Values
    travel: Values
    apart: int
    explained: float
    better: float

    @property
    def off(self) -> Values:
        """px over the baseline by which the motion is off."""
        return np.abs((self.factor - 1) * self.travel + self.drift * self.apart)

    @property
    def unsure(self) -> Values:
        """px over the baseline, the standard error of `off`."""
        return np.asarray(self.error * np.where(self.travel >= LEAST, self.travel, self.apart))


class ScaledMotion:
    """A motion multiplied by factors, and with a drift added, (x, y) each."""

    def __init__(self, motion: Motion, factor: Values, drift: Values) -> None:
        self._motion = motion
        self._factor, self._drift = factor[::-1, None], drift[::-1, None]

    def back(self, points: Points, start: int, stop: int) -> Points:
        for index in range(start, stop, -1):
            step = points - self._motion.back(points, index, index - 1)
            points = points - self._factor * step - self._drift
        return points


def fit_scale(motion: Motion, frames: Frames, run: list[int]) -> Scale | None:
    """Fit factors over a few baselines, spread over a run of frames; None where too little stays in view."""
    apart = min(len(run) - 1, LONGEST)
    ends = sorted({apart, (apart + len(run) - 1) // 2, len(run) - 1})[-_WINDOWS:]
    found = [window for end in ends if (window := _window(motion, frames, run[end - apart : end + 1]))]
    if not found:
        return None
    length = max(window.apart for window in found)
    found = [window for window in found if window.apart == length]
    travels = np.array([window.travel for window in found]).mean(axis=0)
    theta = np.array([window.fit.theta for window in found])
    error = np.maximum(np.array([window.fit.error for window in found]), 1e-12)
    weight = np.where(np.isfinite(error), error, 1e12) ** -2
    mean = (weight * theta).sum(axis=0) / weight.sum(axis=0)
    # Windows that disagree know less than each of them says.
    spread = np.sqrt((weight * (theta - mean) ** 2).sum(axis=0) / weight.sum(axis=0) / max(len(found) - 1, 1))
    unsure = np.maximum(np.sqrt(1 / weight.sum(axis=0)), spread)
    unsure[~np.isfinite(error).any(axis=0)] = np.inf
    mean[~np.isfinite(unsure)] = 0.0
    moving = travels >= LEAST
    before, after = (sum(getattr(window.fit, name) for window in found) for name in ("before", "after"))
    return Scale(
        factor=1 + np.where(moving, mean, 0.0),
        drift=np.where(moving, 0.0, mean),
        error=unsure,
        travel=travels,
        apart=length,
        better=float(np.mean([window.fit.better for window in found])),
        explained=1 - after / before if before > 0 else 0.0,
    )


@dataclass(frozen=True)
class _Window:
    fit: Fit
    travel: Values
    apart: int


def _window(motion: Motion, frames: Frames, run: list[int]) -> _Window | None:
    """The fit over the longest baseline that ends a run, found over ever longer ones: each begins where one ended."""
    last = len(run) - 1
    points = frames.points(run[last])
    places = points
    best: _Window | None = None
    for step in range(1, last + 1):
        places = motion.back(places, run[last - step + 1], run[last - step])
        if step != last and step & (step - 1):
            continue
        early = run[last - step]
        seen = frames.seen(places, early)
        if seen.sum() < max(2, _SEEN * len(seen)):
            break
        here, there = points[:, seen], places[:, seen]
        moved = here - there
        travel = np.sqrt((moved**2).mean(axis=1))[::-1]
        basis = _basis(moved, travel, step)
        target = frames.grey(run[last]).codes[tuple(here.astype(np.intp))]
        start = None if best is None else _carried(best, travel)
        fit = fit_displacement(target, frames.grey(early), there, basis, frames.block_of(here), start)
        best = _Window(fit, travel, run[last] - early)
    return best


def _basis(moved: Points, travel: Values, step: int) -> NDArray[np.float64]:
    """[2 (x, y), 2 (y, x), n]: how points move where an axis travels, else px a frame."""
    basis = np.zeros((2, *moved.shape))
    for axis in (0, 1):
        basis[axis, 1 - axis] = moved[1 - axis] if travel[axis] >= LEAST else step
    return basis


def _carried(shorter: _Window, travel: Values) -> Values:
    """What the fit over a shorter baseline says; nothing of axes that had not travelled then."""
    return np.where((shorter.travel >= LEAST) == (travel >= LEAST), shorter.fit.theta, 0.0)
