"""What displacement explains the difference between a frame and an earlier one: least squares on the gradient.

A frame differs from the earlier one, taken from where a motion says, by gradient times what the motion lacks; noise and
flicker do not follow the gradient. Source: Lucas and Kanade, An iterative image registration technique with an
application to stereo vision, IJCAI 1981. Standard errors count each block of the picture once, since neighbouring
pixels share their noise: Liang and Zeger, Biometrika 73 (1986). Points that no common displacement explains weigh
little, as highlights, thin geometry and what comes into view: Black and Anandan, CVIU 63 (1996).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.check.grey import Grey
from swimlab.footage.motion import Points
from swimlab.footage.warping import mean_square

Values = NDArray[np.float64]

_ROUNDS = 5
_STEP = 1.0
"""A round moves no point further than this, px: gradients tell of no more."""
_DONE = 1e-4
_ROUNDING = 1e-7
_LEAST_SLOPE = 0.25
_BLIND = 1e-4
"""A direction in which the gradients have less than this share of their energy is not seen, as along stripes."""


@dataclass(frozen=True)
class Fit:
    """theta: [q] factors of the basis. error: their standard errors; infinite where the picture does not tell.

    before, after: mean squares of what is left without and with them, but for the points that differ most. better:
    share of the points with large gradients that fit better with them.
    """

    theta: Values
    error: Values
    before: float
    after: float
    better: float


def fit_displacement(
    target: Values, earlier: Grey, places: Points, basis: Values, blocks: NDArray[np.intp], start: Values | None = None
) -> Fit:
    """The factors theta of a displacement that bring the earlier frame onto the target.

    target: [n] codes of the later frame. places: where its points are in the earlier one. basis: [q, 2, n] px (y, x):
    points come from places - sum theta basis. blocks: [n], which points share their noise. start: the first guess.
    """
    first = earlier.at(places) - target
    slopes = (basis * earlier.gradient(places)).sum(axis=1)
    telling = (slopes**2).sum(axis=0)
    telling = telling >= np.median(telling)
    wide = _width(first, telling)
    lowest, left = np.inf, first
    theta = np.zeros(len(basis))
    guess = theta if start is None else start
    for _ in range(_ROUNDS):
        moved = places - np.tensordot(guess, basis, axes=1)
        tried = earlier.at(moved) - target
        cost = _cost(tried, wide)
        if cost > _cost(first, wide) and np.isinf(lowest):
            moved, tried, cost, guess = places, first, _cost(first, wide), theta
        if cost >= lowest:
            break
        theta, left, lowest = guess, tried, cost
        columns = (basis * earlier.gradient(moved)).sum(axis=1)
        far = (left / _width(left, telling)) ** 2
        weight = (1 + far) ** -2.0
        curvature = (weight * columns) @ columns.T
        # Weighted differences answer less to a displacement than the weights say: where they are large, they fall.
        slope = np.mean(weight * (1 - 4 * far / (1 + far)))
        response = curvature * max(float(slope / weight.mean()), _LEAST_SLOPE)
        score = _sums(weight * columns * left, blocks)
        step = np.linalg.pinv(curvature, rcond=_BLIND, hermitian=True) @ score.sum(axis=1)
        furthest = float(np.abs(np.tensordot(step, basis, axes=1)).max(initial=0.0))
        if furthest < _DONE:
            break
        guess = theta + step * min(1.0, _STEP / furthest)
    better = np.abs(left[telling]) - np.abs(first[telling])
    return Fit(
        theta=theta,
        error=_errors(response, score),
        before=mean_square(first),
        after=mean_square(left),
        better=float(np.mean(better < 0) + np.mean(better == 0) / 2),
    )


def sides(count: int) -> Values:
    """[2 (x, y), 2 (y, x), count]: the basis of a shift of all points."""
    return np.broadcast_to(np.array([[0.0, 1.0], [1.0, 0.0]])[:, :, None], (2, 2, count))


def _width(left: Values, telling: NDArray[np.bool_]) -> float:
    """Differences much above this are no displacement's: thrice the median where the gradient is large."""
    return max(3 * float(np.median(np.abs(left[telling]))), _ROUNDING)


def _cost(left: Values, width: float) -> float:
    return float((left**2 / (left**2 + width**2)).mean())


def _sums(values: Values, blocks: NDArray[np.intp]) -> Values:
    """[q, blocks]."""
    return np.stack([np.bincount(blocks, weights=row) for row in values])


def _errors(response: Values, score: Values) -> Values:
    """Standard errors from scores of blocks; infinite in directions that are not seen."""
    inverse = np.linalg.pinv(response, rcond=_BLIND, hermitian=True)
    energy, axes = np.linalg.eigh(response)
    blind = energy <= _BLIND * max(energy[-1], 0.0)
    hidden = (axes[:, blind] ** 2).sum(axis=1) > _BLIND
    centred = score - score.mean(axis=1, keepdims=True)
    variance = np.diag(inverse @ centred @ centred.T @ inverse)
    return np.where(hidden, np.inf, np.sqrt(np.maximum(variance, 0.0)))
