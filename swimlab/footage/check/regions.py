"""Where in the picture the motion does not fit: blocks that a displacement of their own mends, all along a clip."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swimlab.footage.check.grey import COLUMNS, ROWS, Frames
from swimlab.footage.check.lucas_kanade import Values, fit_displacement, sides
from swimlab.footage.check.pairs import PairFit
from swimlab.footage.motion import EstimatedMotion, Motion

STRAY = 0.1
"""Displacements shorter than this are no region's fault, px a frame."""
SURE = 6.0
"""... nor those of fewer standard errors."""
MENDED = 0.5
"""... nor those that take away less than this share of the energy that a block leaves."""
SMALLEST = 3
"""Blocks side by side that make a region."""
FEWEST_PAIRS = 4
"""Pairs that tell what stays from what happens once."""

_FLOWS = 3
_STARK = 4.0
"""A block is looked at by optical flow if it leaves this many times the energy of the quarter that leaves least."""
_FLOW_MENDS = 0.8
"""Optical flow fits noise too, so it is to take away this share in every pair that is looked at."""
_SEEN = 20
_STILL = 0.02
"""Vectors up to this length are zeros, px."""


@dataclass(frozen=True)
class Region:
    """Blocks [ROWS, COLUMNS] that do not fit. shift: (x, y) px a frame that they move more than the motion says.

    box: left, top, right, bottom in px. fraction: share of the compared points. zero: the vectors there are 0.
    """

    blocks: NDArray[np.bool_]
    shift: Values
    box: tuple[int, int, int, int]
    fraction: float
    zero: bool


def find_region(motion: Motion, frames: Frames, pairs: list[PairFit]) -> Region | None:
    """The blocks that do not fit; None where there are none, or too few pairs to tell."""
    if len(pairs) < FEWEST_PAIRS:
        return None
    sums = np.array([pair.blocks for pair in pairs])
    shifts = _by_gradient(sums)
    flowed = _by_flow(motion, frames, pairs, sums)
    shifts = np.where(np.isnan(shifts), flowed, shifts)
    unfit = _grouped(~np.isnan(shifts).any(axis=1).reshape(ROWS, COLUMNS))
    if not unfit.any():
        return None
    number = sums[..., 6].sum(axis=0)
    chosen = unfit.ravel()
    rows, columns = np.nonzero(unfit)
    height, width = frames.shape
    box = (
        int(columns.min() * width / COLUMNS),
        int(rows.min() * height / ROWS),
        int(np.ceil((columns.max() + 1) * width / COLUMNS)),
        int(np.ceil((rows.max() + 1) * height / ROWS)),
    )
    middle = pairs[len(pairs) // 2]
    points = frames.points(middle.late)
    within = points[:, chosen[frames.block_of(points)]]
    places = motion.back(within, middle.late, middle.early)
    length = np.hypot(*(within - places))
    seen = frames.seen(places, middle.early)
    within, places = within[:, seen], places[:, seen]
    target = frames.grey(middle.late).codes[tuple(within.astype(np.intp))]
    start = np.median(shifts[chosen], axis=0)
    basis, numbers = sides(places.shape[1]), frames.block_of(within)
    fit = fit_displacement(target, frames.grey(middle.early), places, basis, numbers, start)
    return Region(
        blocks=unfit,
        shift=fit.theta,
        box=box,
        fraction=float(number[chosen].sum() / number.sum()),
        zero=bool(length.size and np.median(length) < _STILL and middle.reach > _STILL),
    )


def _by_gradient(sums: Values) -> Values:
    """[blocks, 2] (x, y) px that blocks lack in all pairs, by least squares; NaN where that mends little."""
    found = np.full((sums.shape[1], 2), np.nan)
    for block in range(sums.shape[1]):
        yy, yx, xx, gy, gx, energy, number = np.moveaxis(sums[:, block], 1, 0)
        curvature = np.array([[yy, yx], [yx, xx]]).transpose(2, 0, 1)
        score = np.stack([gy, gx], axis=1)
        whole = curvature.sum(axis=0)
        if number.min() < _SEEN or np.linalg.det(whole) <= 1e-6 * np.trace(whole) ** 2:
            continue
        inverse = np.linalg.inv(whole)
        shift = inverse @ score.sum(axis=0)
        mended = score.sum(axis=0) @ shift
        left = score - np.einsum("tij,j->ti", curvature, shift)
        variance = inverse @ (left.T @ left) @ inverse
        sure = np.hypot(*shift) > max(STRAY, SURE * float(np.sqrt(np.trace(variance))))
        if sure and mended > MENDED * energy.sum():
            found[block] = shift[::-1]
    return found


def _by_flow(motion: Motion, frames: Frames, pairs: list[PairFit], sums: Values) -> Values:
    """The same by optical flow, of blocks that leave far more than others: gradients tell of a pixel or two only."""
    number = sums[..., 6].sum(axis=0)
    energy = sums[..., 5].sum(axis=0) / np.maximum(number, 1)
    known = number > 0
    stark = known & (energy > _STARK * np.quantile(energy[known], 0.25)) if known.any() else known
    found = np.full((sums.shape[1], 2), np.nan)
    if not stark.any():
        return found
    flow = EstimatedMotion(frames.picture)
    chosen = sorted({int(k) for k in np.linspace(0, len(pairs) - 1, _FLOWS)})
    lacking = np.full((len(chosen), sums.shape[1], 2), np.nan)
    for which, pair in enumerate(pairs[k] for k in chosen):
        points = frames.points(pair.late)
        blocks = frames.block_of(points)
        target = frames.grey(pair.late).codes[tuple(points.astype(np.intp))]
        given, other = (each.back(points, pair.late, pair.early) for each in (motion, flow))
        left = [frames.grey(pair.early).at(places) - target for places in (given, other)]
        seen = frames.seen(given, pair.early) & frames.seen(other, pair.early)
        for block in np.flatnonzero(stark):
            inside = seen & (blocks == block)
            moved = (given - other)[::-1, inside]
            if inside.sum() < _SEEN or (left[1][inside] ** 2).sum() > (1 - _FLOW_MENDS) * (left[0][inside] ** 2).sum():
                continue
            lacking[which, block] = np.median(moved, axis=1)
    every = ~np.isnan(lacking).any(axis=(0, 2))
    found[every] = np.median(lacking[:, every], axis=0)
    found[np.hypot(*found.T) < STRAY] = np.nan
    return found


def _grouped(unfit: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Without blocks that stand in groups of less than SMALLEST."""
    labels, count = ndimage.label(unfit)
    sizes = ndimage.sum_labels(unfit, labels, np.arange(1, count + 1))
    return np.asarray(np.isin(labels, 1 + np.flatnonzero(np.asarray(sizes) >= SMALLEST)))
