"""How the picture content of your own frames moves: uniformly, by files of vectors, or estimated."""

from collections.abc import Callable, Sequence
from copy import copy
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swimlab.footage.convention import Convention
from swimlab.footage.latest import Latest
from swimlab.footage.reader import Reader
from swimlab.footage.readings import OTHER_FILES, other_conventions, other_velocities
from swimlab.footage.source import Box, Mask
from swimlab.footage.vectors import Known, Vectors
from swimlab.runs.frames import Image

Points = NDArray[np.float64]

_AWAY = 1e6
"""Vectors that lead out of every picture."""
_TOLERANCE = 1e-4
_ROUNDS = 30


class Motion(Protocol):
    """Where surface points [2, n] (y, x indices, px) of one frame are seen in another, earlier one."""

    def back(self, points: Points, start: int, stop: int) -> Points:
        """The places in frame `stop` of points of frame `start`; start > stop."""

    def moved(self, start: int, stop: int) -> Image:
        """[H, W, 2] px right and down, how far the surface seen in frame `start` moved since frame `stop`."""

    def known(self, start: int, stop: int) -> Known | None:
        """[H, W] where it is known how the surface seen in frame `start` moved since `stop`; None: everywhere."""

    def variants(self) -> dict[str, tuple[str, "Motion"]]:
        """Other readings of the same motion: name -> the setting that chooses it, and the motion."""


class UniformMotion:
    """The whole picture moves by the same (dx, dy) px every frame, those that are skipped among them."""

    def __init__(
        self, velocity: tuple[float, float], shape: tuple[int, int], numbers: Sequence[int] | None = None
    ) -> None:
        """numbers: of the frames, by index; None: none is skipped."""
        self.velocity = velocity
        self._shape = shape
        self._numbers = numbers

    def back(self, points: Points, start: int, stop: int) -> Points:
        return np.asarray(points - self._apart(start, stop) * np.array(self.velocity[::-1])[:, None])

    def moved(self, start: int, stop: int) -> Image:
        step = self._apart(start, stop) * np.array(self.velocity, np.float32)
        return np.broadcast_to(step, (*self._shape, 2))

    def step(self, frames: Sequence[int]) -> tuple[float, float] | None:
        """(dx, dy) px from each of some frames to the next; None where they are not evenly apart."""
        first, *others = (self._apart(late, early) for early, late in pairwise(frames))
        return None if {*others} - {first} else (first * self.velocity[0], first * self.velocity[1])

    @property
    def apart(self) -> float:
        """Mean number of frames from an index to the next: more than 1 where some are skipped."""
        numbers = self._numbers
        return 1 if numbers is None or len(numbers) < 2 else (numbers[-1] - numbers[0]) / (len(numbers) - 1)

    def _apart(self, start: int, stop: int) -> int:
        """Frames from one to the other."""
        return start - stop if self._numbers is None else self._numbers[start] - self._numbers[stop]

    def known(self, start: int, stop: int) -> Known | None:
        return None

    def variants(self) -> dict[str, tuple[str, Motion]]:
        others = other_velocities(self.velocity, self._shape[::-1])
        return {
            name: (setting, UniformMotion(velocity, self._shape, self._numbers))
            for name, (velocity, setting) in others.items()
        }


class FieldMotion:
    """A file of motion vectors a frame, of frames that are skipped too."""

    def __init__(
        self,
        reader: Reader,
        part: int,
        channels: tuple[str, str],
        convention: Convention,
        crop: Box | None,
        *,
        size: tuple[int, int] | None = None,
        mask: Mask | None = None,
        places: Sequence[int] | None = None,
    ) -> None:
        """size: width and height of the frames; None: that of the vectors. crop: in the frames' px.

        places: of the frames among the vectors, by index; None: no frame is skipped.
        """
        self._places = places
        self.channels = channels
        self.convention = convention
        self.vectors = Vectors(reader, part, channels, convention, size=size, crop=crop, mask=mask)
        self._stored = self.vectors.stored
        self.factors = self._factors_of(convention)
        """What stored (x, y) less the offset are multiplied with to be px of the frames, right and down."""

    def back(self, points: Points, start: int, stop: int) -> Points:
        for index in range(self._place(start), self._place(stop), -1):
            points = self._step(points, index)
        return points

    def moved(self, start: int, stop: int) -> Image:
        late, early = self._place(start), self._place(stop)
        if late == early + 1 and self.convention.direction == "backward":
            return self._field(late)
        height, width = self._field(late).shape[:2]
        points = np.indices((height, width), dtype=np.float64).reshape(2, -1)
        travelled = points - self.back(points, start, stop)
        return np.moveaxis(travelled[::-1].reshape(2, height, width), 0, 2).astype(np.float32)

    def known(self, start: int, stop: int) -> Known | None:
        start, stop = self._place(start), self._place(stop)
        backward = self.convention.direction == "backward"
        if self.vectors.whole(range(stop + 1, start + 1) if backward else range(stop, start)):
            return None
        if start == stop + 1 and self.convention.direction == "backward":
            return self.vectors.known(start)
        height, width = self.vectors.known(start).shape
        points = np.indices((height, width), dtype=np.float64).reshape(2, -1)
        known = np.ones(height * width, np.bool_)
        for index in range(start, stop, -1):
            earlier = self._step(points, index)
            asked, places = (index, points) if self.convention.direction == "backward" else (index - 1, earlier)
            row, column = np.rint(places).astype(np.intp)
            known &= self.vectors.known(asked)[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
            points = earlier
        return known.reshape(height, width)

    def variants(self) -> dict[str, tuple[str, Motion]]:
        others = other_conventions(self.convention, self.channels, self.vectors.reader.header.size)
        found: dict[str, tuple[str, Motion]] = {
            name: (setting, self._read_as(convention)) for name, (convention, setting) in others.items()
        }
        return found | {name: (setting, self._of_files(by)) for name, (by, setting) in OTHER_FILES.items()}

    def _place(self, index: int) -> int:
        """The place of a frame among the vectors."""
        return index if self._places is None else self._places[index]

    def _read_as(self, convention: Convention) -> Motion:
        """The same files, read once for all readings."""
        other = copy(self)
        other.convention = convention
        other.factors = self._factors_of(convention)
        if convention.channels == (self.channels[::-1],):
            other._stored = lambda index: self._stored(index)[..., ::-1]
        return other

    def _of_files(self, by: int) -> Motion:
        """Each frame by the file of another; out of the picture where that one is not known to be good."""
        other = copy(self)
        other._stored = lambda index: (
            self._stored(index + by)
            if self.vectors.surveyed(index + by)
            else np.full((*self._stored(index).shape[:2], 2), _AWAY, np.float32)
        )
        return other

    def _factors_of(self, convention: Convention) -> NDArray[np.float32]:
        return convention.factors(self.vectors.reader.header.size) * self.vectors.ratio

    def _field(self, index: int) -> Image:
        """[H, W, 2] px right and down, in the convention's direction."""
        return (self._stored(index) - np.array(self.convention.offset, np.float32)) * self.factors

    def _vectors(self, index: int, points: Points) -> Points:
        """(y, x) px at points."""
        offset = np.array(self.convention.offset[::-1])[:, None]
        return np.asarray((sample(self._stored(index), points) - offset) * self.factors[::-1, None])

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
        self._codes = Latest(self._grey, 2)

    def back(self, points: Points, start: int, stop: int) -> Points:
        return points - sample(self.moved(start, stop), points)

    def moved(self, start: int, stop: int) -> Image:
        import cv2  # heavy

        flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
        flow.setFinestScale(0)
        flow.setVariationalRefinementIterations(10)
        first, second = self._codes(start), self._codes(stop)
        return -np.asarray(flow.calc(first, second, np.zeros((*first.shape, 2), np.float32)), np.float32)

    def known(self, start: int, stop: int) -> Known | None:
        return None

    def variants(self) -> dict[str, tuple[str, Motion]]:
        """None: it is found by matching, so there is nothing to check."""
        return {}

    def _grey(self, index: int) -> NDArray[np.uint8]:
        grey = self._picture(index).mean(axis=2)
        low, high = float(grey.min()), float(np.percentile(grey, _BRIGHT))
        share = np.clip((grey - low) / max(high - low, 1e-12), 0, 1)
        return np.asarray(np.rint(255 * np.sqrt(share)), np.uint8)
