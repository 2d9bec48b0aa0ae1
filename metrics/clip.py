"""What is measured: frames of linear radiance and how the surface moves under them."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrics.memory import unset

WHOLE = 1 - 1e-6
"""Coverage from which on a surface covers the whole pixel."""

_ROWS = 64
"""Rows looked at together."""

Image = NDArray[Any]
FrameSource = Callable[[int], Image]


class ClipError(ValueError):
    """A clip cannot be measured; the message names the frame and how to mend it."""


@dataclass(frozen=True)
class Clip:
    """Frames that are read one at a time, and may be read again.

    frame: t -> [H, W, 3] linear radiance, finite, the same size for every t in 0..count-1.
    count: number of frames, at least 1.
    fps: frames a second, above 0.
    motion: how far the picture content moves in one frame, px, +x right and +y down: one (dx, dy) for all
        frames, or t -> [H, W, 2], how far the surface seen at each pixel of frame t moved since frame t - 1.
    coverage: t -> [H, W] in 0..1; only pixels with coverage 1 are measured. None: all of them.
    depth: t -> [H, W] in metres, by which scores are split into bands. None: no bands.
    pixels_per_degree: of visual angle, for measures of visibility.
    luminance: cd/m^2 that radiance 1 is shown with; None if unknown.
    cuts: frames t that begin a new shot, in order, of 1..count-1: nothing in them is seen in frame t - 1.

    Raises ClipError if count, fps, viewing, cuts or a uniform motion is out of range, and on reading a bad frame.
    """

    frame: FrameSource
    count: int
    fps: float = 60.0
    motion: tuple[float, float] | FrameSource = (0.0, 0.0)
    coverage: FrameSource | None = None
    depth: FrameSource | None = None
    pixels_per_degree: float | None = None
    luminance: float | None = None
    cuts: tuple[int, ...] = ()
    _shape: list[tuple[int, int]] = field(default_factory=list, init=False, repr=False, compare=False)
    _first: list[Image] = field(default_factory=list, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ClipError(f"a clip needs at least one frame, this one has {self.count}")
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise ClipError(f"fps is {self.fps}; give frames a second, above 0")
        for name, value in (("pixels per degree", self.pixels_per_degree), ("luminance", self.luminance)):
            if value is not None and not (np.isfinite(value) and value > 0):
                raise ClipError(f"{name} is {value}; give a number above 0, or leave it out")
        if list(self.cuts) != sorted({cut for cut in self.cuts if 0 < cut < self.count}):
            raise ClipError(f"cuts are {self.cuts}; give frames of 1 to {self.count - 1}, each once and in order")
        if not callable(self.motion) and not (len(self.motion) == 2 and np.all(np.isfinite(self.motion))):
            raise ClipError(f"motion is {self.motion}; give (dx, dy) in px a frame, or a field for every frame")

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels, from frame 0, which is kept for who asks for it next."""
        if not self._shape:
            self._first.append(self.planes(0))
        return self._shape[0]

    def with_geometry(self, other: "Clip") -> "Clip":
        """The same clip, with another one's coverage and depth where it has none of its own."""
        clip = replace(self, coverage=self.coverage or other.coverage, depth=self.depth or other.depth)
        clip._shape.append(self.shape)
        return clip

    def image(self, t: int) -> NDArray[np.float64]:
        """Frame t as [3, H, W] float64. Raises ClipError as `planes` does."""
        return self.planes(t).astype(np.float64, copy=False)

    def planes(self, t: int) -> Image:
        """Frame t as [3, H, W], float64 if it came so, else float32.

        Raises ClipError naming the frame if it is not [H, W, 3], has another size or holds NaN or Inf.
        """
        import cv2  # heavy

        if t == 0 and self._first:
            return self._first.pop()
        raw = np.asarray(self.frame(t))
        if raw.ndim != 3 or raw.shape[2] != 3:
            raise ClipError(f"frame {t} has shape {raw.shape}; give height x width x 3 channels (R, G, B)")
        if not self._shape:
            self._shape.append((raw.shape[0], raw.shape[1]))
        self._check(raw, "frame", t)
        precision = np.float64 if raw.dtype.itemsize > 4 else np.float32
        planes = np.moveaxis(np.asarray(raw, precision), 2, 0)
        if not planes.flags.c_contiguous:
            planes = unset(planes.shape, precision)
            cv2.split(np.asarray(raw, precision), list(planes))
        return planes

    def share(self, t: int) -> Image | None:
        """[H, W], how much of each pixel of frame t a surface covers, 0..1; None if there is no mask."""
        if self.coverage is None:
            return None
        share = np.asarray(self.coverage(t))
        self._check(share, "coverage of frame", t)
        return share

    def covered(self, t: int) -> NDArray[np.bool_] | None:
        """[H, W], true where a surface covers the whole pixel of frame t; None if there is no mask."""
        share = self.share(t)
        return None if share is None else share >= WHOLE

    def moved(self, t: int) -> NDArray[np.float32]:
        """[H, W, 2] px since frame t - 1; 0 for what is not finite in pixels that no surface covers wholly.

        Raises ClipError as `image` does.
        """
        if not callable(self.motion):
            return np.broadcast_to(np.asarray(self.motion, dtype=np.float32), (*self.shape, 2))
        raw = np.asarray(self.motion(t), dtype=np.float32)
        if raw.ndim != 3 or raw.shape[2] != 2:
            raise ClipError(f"motion of frame {t} has shape {raw.shape}; give height x width x 2 (x, y)")
        whole = _finite(raw)
        covered = None if whole else self.covered(t)
        if covered is not None and covered.shape == raw.shape[:2]:
            raw = np.where(np.isfinite(raw) | covered[:, :, None], raw, np.float32(0.0))
        self._check(raw, "motion of frame", t, finite=not whole)
        return raw

    def distance(self, t: int) -> NDArray[np.float64] | None:
        """[H, W] depth of frame t in metres, or None."""
        if self.depth is None:
            return None
        raw = np.asarray(self.depth(t), dtype=np.float64)
        self._check(raw, "depth of frame", t, finite=False)
        return raw

    def _check(self, raw: Image, what: str, t: int, *, finite: bool = True) -> None:
        if raw.shape[:2] != self.shape:
            (height, width), (first, second) = raw.shape[:2], self.shape
            raise ClipError(
                f"{what} {t} is {width}x{height} px, but the clip is {second}x{first} px; "
                "all frames of a clip need one size"
            )
        if finite and not _finite(raw):
            bad = np.argwhere(~np.isfinite(raw))
            row, column = bad[0][:2]
            raise ClipError(
                f"{what} {t} holds {len(bad)} NaN or infinite values, the first at pixel x {column}, y {row}; "
                "mend the frame or leave it out"
            )


def _finite(raw: Image) -> bool:
    """Whether all values are finite; found some rows at a time, which stay in the cache."""
    return all(bool(np.isfinite(raw[row : row + _ROWS]).all()) for row in range(0, len(raw), _ROWS))
