"""Every frame against the one before: what the motion leaves, and the shift of the whole picture that it lacks."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from swimlab.footage.check.grey import COLUMNS, ROWS, Frames
from swimlab.footage.check.lucas_kanade import Values, fit_displacement, sides
from swimlab.footage.motion import Motion
from swimlab.footage.warping import mean_square

FEWEST = 50
"""Points that must be seen in both frames."""
_FLAT = 1e-6
REACH = 0.75
"""Quantile of the points' motion: a quarter of them moves so far."""


@dataclass(frozen=True)
class PairFit:
    """A frame and an earlier one; pictures are rms, over that of unrelated points: 0 equal, 1 nothing in common.

    change, spread: of the two frames without motion, and of unrelated points, in codes. given: left by the motion.
    rigid: left if all points are shifted by `shift` more, (x, y) px, known to `error`, by which a share `better` of
    them fits better. likeness: correlation under the motion. travel: mean motion (x, y) px. reach: how far a quarter of
    the points moves at least, px. blocks: [blocks, 7], sums over points of the squared gradient (yy, yx, xx), of
    gradient times what is left (y, x), of its square, and their number.
    """

    late: int
    early: int
    change: float
    spread: float
    given: float
    rigid: float
    better: float
    likeness: float
    shift: Values
    error: Values
    travel: Values
    reach: float
    blocks: Values


def fit_pairs(motion: Motion, frames: Frames, indices: list[int]) -> list[PairFit]:
    """All pairs of neighbours, those that have too little in view left out. Frames are read once, in order."""
    found = []
    for early, late in pairwise(indices):
        pair = _fit(motion, frames, late, early)
        if pair is not None:
            found.append(pair)
    return found


def _fit(motion: Motion, frames: Frames, late: int, early: int) -> PairFit | None:
    before, now = frames.grey(early), frames.grey(late)
    points = frames.points(late)
    places = motion.back(points, late, early)
    seen = frames.seen(places, early)
    points, places = points[:, seen], places[:, seen]
    if points.shape[1] < FEWEST:
        return None
    target = now.codes[tuple(points.astype(np.intp))]
    spread = np.sqrt(mean_square(target - np.random.default_rng(0).permutation(target)))
    if spread < _FLAT:
        return None
    blocks = frames.block_of(points)
    fit = fit_displacement(target, before, places, sides(points.shape[1]), blocks)
    warped = before.at(places)
    left = warped - target
    y, x = before.gradient(places)
    sums = (y * y, y * x, x * x, y * left, x * left, left * left, np.ones_like(left))
    moved = points - places
    return PairFit(
        late=late,
        early=early,
        change=np.sqrt(mean_square(before.codes[tuple(points.astype(np.intp))] - target)),
        spread=float(spread),
        given=np.sqrt(fit.before) / spread,
        rigid=np.sqrt(fit.after) / spread,
        better=fit.better,
        likeness=float(np.corrcoef(warped, target)[0, 1]) if warped.std() > _FLAT else 0.0,
        shift=fit.theta,
        error=fit.error,
        travel=moved.mean(axis=1)[::-1],
        reach=float(np.quantile(np.hypot(*moved), REACH)),
        blocks=np.stack([np.bincount(blocks, each, minlength=ROWS * COLUMNS) for each in sums], axis=1),
    )
