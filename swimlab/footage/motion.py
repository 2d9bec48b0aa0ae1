"""How the surface moves between frames: one vector for all, or a file of vectors a frame."""

from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swimlab.footage.convention import Convention, Direction
from swimlab.footage.reader import Reader
from swimlab.footage.source import Box, check_finite
from swimlab.frames import FrameError, Image

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
        x, y = self.velocity
        return {
            name: (f"--motion {dx:g},{dy:g}", UniformMotion((dx, dy), self._shape))
            for name, dx, dy in (("x flipped", -x, y), ("y flipped", x, -y), ("both flipped", -x, -y))
            if (dx, dy) != (x, y)
        }


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
        self._field = lru_cache(maxsize=4)(self._read)

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
        now = self.convention
        other: Direction = "forward" if now.direction == "backward" else "backward"
        x, y = now.scale
        flips = {
            "x flipped": (now.turned(x=-1), f"--motion-scale {-x:g},{y:g}"),
            "y flipped": (now.turned(y=-1), f"--motion-y {'up' if now.y == 'down' else 'down'}"),
            "both flipped": (now.turned(x=-1, y=-1), f"--motion-scale {-x:g},{-y:g}"),
            f"{other}": (now.turned(direction=other), f"--motion-direction {other}"),
            f"{other}, both flipped": (
                now.turned(x=-1, y=-1, direction=other),
                f"--motion-direction {other} --motion-scale {-x:g},{-y:g}",
            ),
        }
        return {
            name: (setting, FieldMotion(self.reader, self._part, self.channels, convention, self._crop))
            for name, (convention, setting) in flips.items()
        }

    def _step(self, points: Points, index: int) -> Points:
        """One frame back from `index`."""
        if self.convention.direction == "backward":
            return points - sample(self._field(index), points)
        # p + field(p) = points, by fixed-point iteration.
        field = self._field(index - 1)
        place = points - sample(field, points)
        for _ in range(_ROUNDS):
            better = points - sample(field, place)
            gone = float(np.max(np.abs(better - place), initial=0.0))
            place = better
            if gone < _TOLERANCE:
                break
        return place

    def _read(self, index: int) -> Image:
        """[H, W, 2] px right and down, in the convention's direction."""
        stored = self.reader.read(index, self._part, self.channels)
        width, height = self.reader.header.size
        if stored.shape[:2] != (height, width):
            raise FrameError(f"{self.reader.label(index)}: is not {width}x{height} px, as most frames are")
        check_finite(stored, self.reader.label(index))
        field = stored * self._factors
        return self._crop.cut(field) if self._crop else field


def sample(field: Image, points: Points) -> Points:
    """(y, x) vectors of a field at points, linear between pixels, the nearest one's outside."""
    return np.stack([ndimage.map_coordinates(field[..., axis], points, order=1, mode="nearest") for axis in (1, 0)])
