"""What displacement explains the difference between a frame and an earlier one: least squares on the gradient.

A frame differs from the earlier one, taken from where a motion says, by gradient times what the motion lacks; noise and
flicker do not follow the gradient. Source: Lucas and Kanade, An iterative image registration technique with an
application to stereo vision, IJCAI 1981. Standard errors count each block of the picture once, since neighbouring
pixels share their noise: Liang and Zeger, Biometrika 73 (1986).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.check.grey import Grey
from swimlab.footage.motion import Points

Values = NDArray[np.float64]

HIDDEN = 0.1
"""Share of the points that may have come into view: what differs most is left out."""

_ROUNDS = 5
_STEP = 1.0
"""A round moves no point further than this, px: gradients tell of no more."""
_DONE = 1e-4
_BLIND = 1e-4
"""A direction in which the gradients have less than this share of their energy is not seen, as along stripes."""


@dataclass(frozen=True)
class Fit:
    """theta: [q] factors of the basis. error: their standard errors; infinite where the picture does not tell.

    before, after: mean squares of what is left without and with them, but for the points that differ most.
    """

    theta: Values
    error: Values
    before: float
    after: float


def fit_displacement(
    target: Values, earlier: Grey, places: Points, basis: Values, blocks: NDArray[np.intp], start: Values | None = None
) -> Fit:
    """The factors theta of a displacement that bring the earlier frame onto the target.

    target: [n] codes of the later frame. places: where its points are in the earlier one. basis: [q, 2, n] px (y, x):
    points come from places - sum theta basis. blocks: [n], which points share their noise. start: the first guess.
    """
    lowest = before = mean_square(earlier.at(places) - target)
    theta = np.zeros(len(basis))
    guess = theta if start is None else start
    curvature = score = np.zeros((len(basis), 0))
    for _ in range(_ROUNDS):
        moved = places - np.tensordot(guess, basis, axes=1)
        left = earlier.at(moved) - target
        square = mean_square(left)
        if square > lowest:
            if curvature.size:
                break
            moved, left, square, guess = places, earlier.at(places) - target, before, theta
        theta, lowest = guess, square
        kept = _kept(left)
        columns = (basis * earlier.gradient(moved)).sum(axis=1)[:, kept]
        curvature = columns @ columns.T
        score = _sums(columns * left[kept], blocks[kept])
        step = np.linalg.pinv(curvature, rcond=_BLIND, hermitian=True) @ score.sum(axis=1)
        furthest = float(np.abs(np.tensordot(step, basis, axes=1)).max(initial=0.0))
        if furthest < _DONE:
            break
        guess = theta + step * min(1.0, _STEP / furthest)
    return Fit(theta, _errors(curvature, score), before, lowest)


def sides(count: int) -> Values:
    """[2 (x, y), 2 (y, x), count]: the basis of a shift of all points."""
    return np.broadcast_to(np.array([[0.0, 1.0], [1.0, 0.0]])[:, :, None], (2, 2, count))


def mean_square(differences: Values) -> float:
    """Mean square of all but the largest differences."""
    kept = differences[_kept(differences)]
    return float((kept**2).mean()) if kept.size else 0.0


def _kept(differences: Values) -> NDArray[np.bool_]:
    size = np.abs(differences)
    return np.asarray(size <= np.quantile(size, 1 - HIDDEN)) if size.size else np.zeros(0, np.bool_)


def _sums(values: Values, blocks: NDArray[np.intp]) -> Values:
    """[q, blocks]."""
    return np.stack([np.bincount(blocks, weights=row) for row in values])


def _errors(curvature: Values, score: Values) -> Values:
    """Standard errors from scores of blocks; infinite in directions that are not seen."""
    if curvature.shape[0] != curvature.shape[1]:
        return np.full(len(curvature), np.inf)
    inverse = np.linalg.pinv(curvature, rcond=_BLIND, hermitian=True)
    energy, axes = np.linalg.eigh(curvature)
    blind = energy <= _BLIND * max(energy[-1], 0.0)
    hidden = (axes[:, blind] ** 2).sum(axis=1) > _BLIND
    centred = score - score.mean(axis=1, keepdims=True)
    variance = np.diag(inverse @ centred @ centred.T @ inverse)
    return np.where(hidden, np.inf, np.sqrt(np.maximum(variance, 0.0)))
