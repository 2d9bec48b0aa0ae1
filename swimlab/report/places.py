"""Where in a frame an error is, and where what changes on the surface: one way for the report and for the gate."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.pictures import Pictures
from swimlab.report.clips import Region
from swimlab.report.display import COVERED
from swimlab.report.following import same_surface, warped
from swimlab.runs.frames import FrameError, Image
from swimlab.runs.record import REFERENCE

Pixels = NDArray[np.bool_]

SIDE = 64
"""Width and height of a region, px, where the frame is as large."""

ERROR, CHANGE = ("mse", "frame_mse"), ("change", "edges_flicker")
"""By which of an entry's values frames are ranked: the first that is known."""


def worst_frames(rows: Iterable[Mapping[str, Any]], *keys: str) -> list[tuple[int, float]]:
    """(frame, value) of an entry's rows by frame, the largest first, under the first key that any of them has."""
    known = list(rows)
    for key in keys:
        found = [(int(row["frame"]), float(row[key])) for row in known if isinstance(row.get(key), int | float)]
        if found:
            return sorted(found, key=lambda each: -each[1])
    return []


def frame_before(rows: Iterable[Mapping[str, Any]], frame: int) -> int | None:
    """The frame that an entry's rows by frame hold before this one."""
    return max((int(row["frame"]) for row in rows if row["frame"] < frame), default=None)


def to_blame(rows: Sequence[Mapping[str, Any]], frame: int) -> int | None:
    """Of a frame and the one before it the one of the larger error, at fault for the change; None where unknown."""
    errors, before = dict(worst_frames(rows, *ERROR)), frame_before(rows, frame)
    if before not in errors or frame not in errors:
        return None
    return frame if errors[frame] >= errors[before] else before


@dataclass(frozen=True)
class Pair:
    """A frame and the one before it. frames, pictures [H, W, 4]: the earlier one first.

    errors: [H, W, 3] of both as the later frame shows them, test minus reference; the pictures themselves without a
    reference. moved: [H, W, 2] px since the earlier one. covered: where the later frame shows a surface wholly; known:
    where the earlier one shows the same. Both errors are 0 where it does not.
    """

    frames: tuple[int, int]
    pictures: tuple[Image, Image]
    errors: tuple[Image, Image]
    moved: Image
    covered: Pixels
    known: Pixels

    @property
    def change(self) -> Image:
        """[H, W, 3], what changes on the surface; 0 where that is not known."""
        return self.errors[1] - self.errors[0]

    def fault(self, region: Region) -> tuple[int, Region]:
        """Which frame has the larger error where the later one shows a region, and where it shows the same."""
        before, now = (float(np.square(cut(error, region).astype(np.float64)).sum()) for error in self.errors)
        return (self.frames[1], region) if now >= before else (self.frames[0], self._before(region))

    def _before(self, region: Region) -> Region:
        """Where the earlier frame shows what is in a region of the later one, as far as it is in the picture."""
        x, y, width, height = region
        there = cut(self.moved, region)[cut(self.known, region)]
        if not len(there):
            return region
        right, down = (round(float(part)) for part in np.median(there, axis=0))
        x, y = x - right, y - down
        rows, columns = self.known.shape
        return min(max(x, 0), columns - width), min(max(y, 0), rows - height), width, height


def pair_into(pictures: Pictures, technique: str, frames: Sequence[int], frame: int, *, reference: bool) -> Pair:
    """A frame, not the first of the run's frames, and the one before it. reference: whether it is what they should be.

    Raises FrameError where a picture or the motion cannot be read.
    """
    place = frames.index(frame) if frame in frames else 0
    if not place:
        raise FrameError(f"the run has no frame {frame} with one before it; measure it again")
    earlier = frames[max(0, place - 2) : place]
    motion = pictures.motion((*earlier, frame))
    before, now = shown = pictures.read(technique, earlier[-1]), pictures.read(technique, frame)
    moved, covered = motion(frame), now[..., 3] >= COVERED
    if reference:
        exact_before, exact = (pictures.read(REFERENCE, each) for each in (earlier[-1], frame))
        covered &= exact[..., 3] >= COVERED
        before, now = before - exact_before, now - exact
    error_before, error = warped(before, moved)[..., :3], now[..., :3]
    known = covered & np.isfinite(error_before).all(axis=2) & np.isfinite(error).all(axis=2)
    if len(earlier) > 1:
        known &= same_surface(moved, motion(earlier[-1]))
    there = known[..., None]
    errors = np.where(there, error_before, np.float32(0)), np.where(there, error, np.float32(0))
    return Pair((earlier[-1], frame), shown, errors, moved, covered, known)


def worst_region(difference: Image, known: Pixels) -> Region:
    """The square (x, y, width, height) of the largest squared difference [H, W, 3], over pixels that are known."""
    return worst_square(np.where(known, np.square(difference.astype(np.float64)).sum(axis=2), 0.0))[0]


def worst_square(power: NDArray[np.float64]) -> tuple[Region, float]:
    """The square (x, y, width, height) in which [H, W] sums up to the most, and that sum."""
    height, width = power.shape
    w, h = min(SIDE, width), min(SIDE, height)
    summed = np.pad(power, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    boxes = summed[h:, w:] - summed[:-h, w:] - summed[h:, :-w] + summed[:-h, :-w]
    y, x = np.unravel_index(int(np.argmax(boxes)), boxes.shape)
    return (int(x), int(y), w, h), float(boxes[y, x])


def cut(picture: NDArray[Any], region: Region) -> NDArray[Any]:
    """A region of [H, W, ...]."""
    x, y, width, height = region
    return picture[y : y + height, x : x + width]
