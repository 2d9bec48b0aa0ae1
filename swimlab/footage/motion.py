"""How the picture content of your own frames moves: uniformly, by files of vectors, or estimated."""

from collections.abc import Callable
from copy import copy
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swimlab.footage.convention import Convention
from swimlab.footage.reader import Reader
from swimlab.footage.readings import other_conventions, other_velocities
from swimlab.footage.source import Box, check_finite
from swimlab.runs.frames import FrameError, Image

Points = NDArray[np.float64]

_TOLERANCE = 1e-4
_ROUNDS = 30


class Motion(Protocol):
    """Where surface points [2, n] (y, x indices, px) of one frame are seen in another, earlier one."""

    def back(self, points: Points, start: int, stop: int) -> Points:
        """The places in frame `stop` of points of frame `start`; start > stop."""

    def moved(self, start: int, stop: int) -> Image:
        """[H, W, 2] px right and down, how far the surface seen in frame `start` moved since frame `stop`."""

    def variants(self) -> dict[str, tuple[str, "Motion"]]:
        """Other readings of the same motion: name -> the setting that chooses it, and the motion."""


class UniformMotion:
    """The whole picture moves by the same (dx, dy) px every frame."""

    def __init__(self, velocity: tuple[float, float], shape: tuple[int, int]) -> None:
        self.velocity = velocity
        self._shape = shape

    def back(self, points: Points, start: int, stop: int) -> Points:
        return np.asarray(points - (start - stop) * np.array(self.velocity[::-1])[:, None])

    def moved(self, start: int, stop: int) -> Image:
        step = (start - stop) * np.array(self.velocity, np.float32)
        return np.broadcast_to(step, (*self._shape, 2))

    def variants(self) -> dict[str, tuple[str, Motion]]:
        others = other_velocities(self.velocity, self._shape[::-1])
        return {name: (setting, UniformMotion(velocity, self._shape)) for name, (velocity, setting) in others.items()}


class FieldMotion:
    """A file of motion vectors a frame."""

    def __init__(
        self, reader: Reader, part: int, channels: tuple[str, str], convention: Convention, crop: Box | None
    ) -> None:
        self.reader = reader
        self.channels = channels
        self.convention = convention
        self._part = part
        self._crop = crop
        self._factors = convention.factors(reader.header.size)
        self._stored = lru_cache(maxsize=4)(self._read)

    def back(self, points: Points, start: int, stop: int) -> Points:
        for index in range(start, stop, -1):
            points = self._step(points, index)
        return points

    def moved(self, start: int, stop: int) -> Image:
        if start == stop + 1 and self.convention.direction == "backward":
            return self._field(start)
        height, width = self._field(start).shape[:2]
        points = np.indices((height, width), dtype=np.float64).reshape(2, -1)
        travelled = points - self.back(points, start, stop)
        return np.moveaxis(travelled[::-1].reshape(2, height, width), 0, 2).astype(np.float32)

    def variants(self) -> dict[str, tuple[str, Motion]]:
        others = other_conventions(self.convention, self.channels, self.reader.header.size)
        return {name: (setting, self._read_as(convention)) for name, (convention, setting) in others.items()}

    def _read_as(self, convention: Convention) -> Motion:
        """The same files, read once for all readings."""
        other = copy(self)
        other.convention = convention
        other._factors = convention.factors(self.reader.header.size)
        return other

    def _field(self, index: int) -> Image:
        """[H, W, 2] px right and down, in the convention's direction."""
        return self._stored(index) * self._factors

    def _vectors(self, index: int, points: Points) -> Points:
        """(y, x) px at points."""
        return sample(self._stored(index), points) * self._factors[::-1, None]

    def _step(self, points: Points, index: int) -> Points:
        """One frame back from `index`."""
        if self.convention.direction == "backward":
            return np.asarray(points - self._vectors(index, points))
        # p + field(p) = points, by fixed-point iteration.
        place = points - self._vectors(index - 1, points)
        for _ in range(_ROUNDS):
            better = points - self._vectors(index - 1, place)
            gone = float(np.max(np.abs(better - place), initial=0.0))
            place = better
            if gone < _TOLERANCE:
                break
        return place

    def _read(self, index: int) -> Image:
        """[H, W, 2] as stored."""
        stored = self.reader.read(index, self._part, self.channels)
        width, height = self.reader.header.size
        if stored.shape[:2] != (height, width):
            raise FrameError(f"{self.reader.label(index)}: is not {width}x{height} px, as most frames are")
        check_finite(stored, self.reader.label(index))
        return self._crop.cut(stored) if self._crop else stored


def sample(field: Image, points: Points) -> Points:
    """(y, x) vectors of a field at points, linear between pixels, the nearest one's outside."""
    return np.stack([ndimage.map_coordinates(field[..., axis], points, order=1, mode="nearest") for axis in (1, 0)])


_BRIGHT = 99.5
"""Percentile of the radiance that becomes white for the estimator, which takes 8-bit codes."""


class EstimatedMotion:
    """Optical flow from each frame back to an earlier one."""

    def __init__(self, picture: Callable[[int], Image]) -> None:
        """picture: index -> [H, W, 3] linear radiance."""
        self._picture = picture
        self._codes = lru_cache(maxsize=2)(self._grey)

    def back(self, points: Points, start: int, stop: int) -> Points:
        return points - sample(self.moved(start, stop), points)

    def moved(self, start: int, stop: int) -> Image:
        import cv2  # heavy

        flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
        flow.setFinestScale(0)
        flow.setVariationalRefinementIterations(10)
        first, second = self._codes(start), self._codes(stop)
        return -np.asarray(flow.calc(first, second, np.zeros((*first.shape, 2), np.float32)), np.float32)

    def variants(self) -> dict[str, tuple[str, Motion]]:
        """None: it is found by matching, so there is nothing to check."""
        return {}

    def _grey(self, index: int) -> NDArray[np.uint8]:
        grey = self._picture(index).mean(axis=2)
        low, high = float(grey.min()), float(np.percentile(grey, _BRIGHT))
        share = np.clip((grey - low) / max(high - low, 1e-12), 0, 1)
        return np.asarray(np.rint(255 * np.sqrt(share)), np.uint8)
