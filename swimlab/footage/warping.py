"""How much of the change between two frames is left once the earlier one is taken from where a motion says."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from metrics.clip import WHOLE
from swimlab.footage.motion import Points
from swimlab.runs.frames import Image

GIVEN = "as given"
IDENTITY = "no motion"

_POINTS = 20_000
_FLAT = 1e-6
_HIDDEN = 0.1
"""Share of the points that may have come into view, or be at an edge of the motion: what differs most is left out."""
_SEEN = 0.05
"""Share of the points that must stay in the frame under the given motion."""
_SHARED = 0.5
"""... and under another: few points may agree by chance."""


class Reading(Protocol):
    """What may move points: a motion, or what is made of one."""

    def back(self, points: Points, start: int, stop: int) -> Points:
        """The places in frame `stop` of points [2, n] (y, x) of frame `start`; start > stop."""


@dataclass(frozen=True)
class Rival:
    """A reading's residual, and the given one's over the same frames and points (1 where that one leaves the frame)."""

    residual: float
    given: float

    @property
    def ratio(self) -> float:
        """The residual as a share of the given one's; 1 where that is rounding alone."""
        return self.residual / self.given if self.given > _FLAT else 1.0


class Pair:
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


def residuals_of(readings: Mapping[str, Reading], pairs: list[Pair]) -> dict[str, Rival]:
    """Residuals of readings, and of none, over pairs of frames; not of those that leave the frame."""
    energy: dict[str, NDArray[np.float64]] = {}
    for pair in pairs:
        for name, squares in _compare(readings, pair).items():
            energy[name] = energy.get(name, np.zeros(3)) + squares
    return {
        name: Rival(float(np.sqrt(square / spread)), float(np.sqrt(given / spread)))
        for name, (square, given, spread) in energy.items()
    }


def _compare(readings: Mapping[str, Reading], pair: Pair) -> dict[str, NDArray[np.float64]]:
    """Squared residuals of each reading and of none, of the given one, and of unrelated pictures; not of flat ones."""
    points = grid(pair.first.shape, _POINTS)
    points = points[:, inside(points, pair.first.shape, pair.covered[0])]
    if points.shape[1] < 2:
        return {}
    target = pair.first[tuple(points.astype(np.intp))]
    unrelated = target - np.random.default_rng(0).permutation(target)
    spline = ndimage.spline_filter(pair.second, order=3, mode="mirror")
    differences: dict[str, NDArray[np.float64]] = {}
    for name, place in (_landed(readings, points, pair) | {IDENTITY: points}).items():
        seen = inside(place, pair.first.shape, pair.covered[1])
        if seen.sum() >= max(2, (_SEEN if name == GIVEN else _SHARED) * len(seen)):
            warped = ndimage.map_coordinates(spline, place, order=3, mode="mirror", prefilter=False)
            differences[name] = np.where(seen, warped - target, np.nan)
    found = {}
    for name, own in differences.items():
        given = differences.get(GIVEN, unrelated)
        both = np.isfinite(own) & np.isfinite(given)
        if both.sum() < max(2, _SEEN * len(both)):
            given, both = unrelated, np.isfinite(own)
        squares = np.array([mean_square(each[both]) for each in (own, given, unrelated)])
        if squares[2] > _FLAT**2:
            found[name] = squares
    return found


def _landed(readings: Mapping[str, Reading], points: Points, pair: Pair) -> dict[str, Points]:
    """Where each reading takes points of the later frame in the earlier one; files are read once for all of them."""
    places = dict.fromkeys(readings, points)
    for index in range(pair.late, pair.early, -1):
        places = {name: readings[name].back(place, index, index - 1) for name, place in places.items()}
    return places


def mean_square(differences: NDArray[np.float64]) -> float:
    """Mean square of all but the largest differences."""
    size = np.abs(differences)
    kept = size[size <= np.quantile(size, 1 - _HIDDEN)] if size.size else size
    return float((kept**2).mean()) if kept.size else 0.0


def grid(shape: tuple[int, ...], count: int) -> Points:
    """[2, n] pixels spread evenly over the picture, about `count`."""
    step = max(1, int(np.ceil(np.sqrt(shape[0] * shape[1] / count))))
    rows, columns = np.mgrid[step // 2 : shape[0] : step, step // 2 : shape[1] : step]
    return np.stack([rows.ravel(), columns.ravel()]).astype(np.float64)


def inside(place: Points, shape: tuple[int, ...], covered: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
    """[n], whether places [2, n] (y, x) lie within the picture, and are covered."""
    row, column = (np.rint(p).astype(np.intp) for p in place)
    inside = (row >= 1) & (row < shape[0] - 1) & (column >= 1) & (column < shape[1] - 1)
    if covered is None:
        return np.asarray(inside)
    return np.asarray(inside & covered[np.where(inside, row, 0), np.where(inside, column, 0)])
