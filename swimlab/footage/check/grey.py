"""Frames in grey codes that keep highlights from ruling, and points spread over them."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from metrics.clip import WHOLE
from swimlab.footage.motion import Points
from swimlab.footage.warping import grid, inside
from swimlab.runs.frames import Image

POINTS = 8_000
ROWS, COLUMNS = 8, 12
"""Blocks of the picture."""


class Grey:
    """One frame: grey / (typical + |grey|), from -1 to 1, as a cubic spline."""

    def __init__(self, picture: Image, typical: float, covered: NDArray[np.bool_] | None) -> None:
        grey = picture.astype(np.float64) @ np.full(3, 1 / 3)
        self.codes = grey / (typical + np.abs(grey))
        self.covered = covered
        self._spline: NDArray[np.float64] | None = None

    def at(self, points: Points) -> NDArray[np.float64]:
        """[n] codes between pixels."""
        if self._spline is None:
            self._spline = ndimage.spline_filter(self.codes, order=3, mode="mirror")
        return np.asarray(ndimage.map_coordinates(self._spline, points, order=3, mode="mirror", prefilter=False))

    def gradient(self, points: Points) -> Points:
        """[2, n] (y, x) change of the code in a px, over half a pixel to both sides."""
        down, right = np.array([[0.5], [0.0]]), np.array([[0.0], [0.5]])
        return np.stack([self.at(points + step) - self.at(points - step) for step in (down, right)])


class Frames:
    """Grey frames by index, a few of them held."""

    def __init__(
        self, picture: Callable[[int], Image], coverage: Callable[[int], Image] | None, frames: list[int]
    ) -> None:
        """frames: of which a few say what grey is typical."""
        self.picture = picture
        self.coverage = coverage
        chosen = {frames[0], frames[len(frames) // 2], frames[-1]}
        self._typical = float(np.mean([np.abs(picture(index)).mean(dtype=np.float64) for index in chosen])) or 1.0
        self.grey = lru_cache(maxsize=3)(self._grey)
        self.shape: tuple[int, int] = picture(frames[0]).shape[:2]

    def points(self, index: int) -> Points:
        """[2, n] covered pixels (y, x) of a frame, spread evenly."""
        points = grid(self.shape, POINTS)
        return points[:, self.seen(points, index)]

    def seen(self, places: Points, index: int) -> NDArray[np.bool_]:
        """[n], whether places lie within a frame and are covered there."""
        return inside(places, self.shape, self.grey(index).covered)

    def block_of(self, points: Points) -> NDArray[np.intp]:
        """[n], the block that points lie in."""
        return block_of(points, self.shape)

    def _grey(self, index: int) -> Grey:
        covered = None if self.coverage is None else self.coverage(index) >= WHOLE
        return Grey(self.picture(index), self._typical, covered)


def block_of(points: Points, shape: tuple[int, ...]) -> NDArray[np.intp]:
    """[n], the block of a picture that points lie in."""
    row = np.clip(points[0] * ROWS / shape[0], 0, ROWS - 1).astype(np.intp)
    return np.asarray(row * COLUMNS + np.clip(points[1] * COLUMNS / shape[1], 0, COLUMNS - 1).astype(np.intp))
