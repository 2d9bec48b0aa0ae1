"""Frames as linear radiance: channels chosen, colours decoded, alpha and crop applied."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from metrics.clip import WHOLE
from metrics.display import Display, Domain
from swimlab.footage.channels import find_alpha, find_colour
from swimlab.footage.colour import ColourSpace, decode, quantisation_floor, resolve
from swimlab.footage.reader import LEAVE_OUT, Reader
from swimlab.runs.frames import FrameError, Image

AlphaUse = Literal["ignore", "mask", "unpremultiply"]


@dataclass(frozen=True)
class Box:
    """A part of the picture, px from the top left."""

    x: int
    y: int
    width: int
    height: int

    def cut(self, pixels: NDArray[Any]) -> NDArray[Any]:
        """The box's part of an array [H, W, ...]."""
        return pixels[self.y : self.y + self.height, self.x : self.x + self.width]


@dataclass(frozen=True)
class Look:
    """How stored values become radiance.

    channels: three channels with commas, one, or a layer; None: found. alpha: "ignore" takes colours as stored, "mask"
    measures only pixels of alpha 1, "unpremultiply" divides premultiplied colours by alpha and measures where it is
    above 0.
    """

    channels: str | None = None
    colour_space: ColourSpace = "auto"
    alpha: AlphaUse = "ignore"
    crop: Box | None = None


class Source:
    """Frames by index as linear radiance."""

    def __init__(self, reader: Reader, look: Look) -> None:
        """Frames without alpha are wholly opaque. Raises FrameError where channels or crop are not available."""
        self.reader = reader
        self.part, self.channels = find_colour(reader.header, look.channels, reader.name)
        part = reader.header.parts[self.part]
        self.stored_as = part.types[part.channels.index(self.channels[0])]
        self.space = resolve(look.colour_space, stored_as=self.stored_as, metadata=reader.header.colour_space)
        self._look = look
        self._alpha = find_alpha(part, self.channels) if look.alpha != "ignore" else None
        check_crop(look.crop, reader.header.size, reader.name)
        self._read = lru_cache(maxsize=2)(self._stored)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width after cropping."""
        width, height = self.reader.header.size
        return (self._look.crop.height, self._look.crop.width) if self._look.crop else (height, width)

    @property
    def has_coverage(self) -> bool:
        """Whether the alpha says where to measure."""
        return self._alpha is not None

    def problems(self) -> dict[int, str]:
        """What is wrong with frames, by index, as far as headers tell."""
        return self.reader.problems(self.part, self._channels_read)

    def picture(self, index: int) -> Image:
        """[H, W, 3] linear radiance. Raises FrameError naming the frame, also for NaN and Inf."""
        stored = self._read(index)
        colour = stored[..., : len(self.channels)]
        check_finite(colour, self.reader.label(index))
        if self._alpha is not None and self._look.alpha == "unpremultiply" and not self.reader.header.unassociated:
            alpha = stored[..., -1:]
            colour = np.where(alpha > 0, colour / np.where(alpha > 0, alpha, 1), 0)
        radiance = decode(colour, self.space)
        return np.asarray(np.broadcast_to(radiance, (*radiance.shape[:2], 3)))

    def coverage(self, index: int) -> Image:
        """[H, W] 1 where the alpha lets a pixel be measured, else 0."""
        alpha = self._read(index)[..., -1]
        enough = alpha > 0 if self._look.alpha == "unpremultiply" else alpha >= WHOLE
        return enough.astype(np.float32)

    def quantisation(self, indices: Iterable[int], domain: Domain, display: Display) -> list[float | None]:
        """Mean squared errors of rounding some frames to stored codes, radiance^2; None for 32-bit floats."""
        return [
            quantisation_floor(
                self._read(index)[..., : len(self.channels)],
                stored_as=self.stored_as,
                space=self.space,
                domain=domain,
                display=display,
                full_scale=self.reader.header.full_scale,
            )
            for index in indices
        ]

    @property
    def _channels_read(self) -> tuple[str, ...]:
        return (*self.channels, self._alpha) if self._alpha is not None else self.channels

    def _stored(self, index: int) -> Image:
        try:
            pixels = self.reader.read(index, self.part, self._channels_read)
        except FrameError as error:
            raise FrameError(f"{error}; {LEAVE_OUT}") from error
        width, height = self.reader.header.size
        if pixels.shape[:2] != (height, width):
            raise FrameError(f"{self.reader.label(index)}: is not {width}x{height} px, as most frames are; {LEAVE_OUT}")
        return self._look.crop.cut(pixels) if self._look.crop else pixels


class Mask:
    """Where to measure: one picture for all frames or one a frame, 1 where its first channel is above one half."""

    def __init__(self, reader: Reader, crop: Box | None) -> None:
        self.reader = reader
        self._crop = crop

    def coverage(self, index: int) -> Image:
        """[H, W], 0 or 1. Raises FrameError."""
        index = index if len(self.reader.numbers) > 1 else 0
        pixels = self.reader.read(index, 0, self.reader.header.parts[0].channels[:1])[..., 0]
        check_finite(pixels, self.reader.label(index))
        inside = (pixels > 0.5).astype(np.float32)
        return np.asarray(self._crop.cut(inside) if self._crop else inside)


def check_finite(pixels: Image, label: str) -> None:
    """Raise FrameError naming the frame and the first pixel that is NaN or infinite."""
    finite = np.isfinite(pixels)
    if not finite.all():
        bad = np.argwhere(~finite)
        row, column = bad[0][:2]
        raise FrameError(
            f"{label}: holds {len(bad)} NaN or infinite values, the first at pixel x {column}, y {row}; mend the "
            "frame, or leave it out with --skip-bad-frames"
        )


def check_crop(crop: Box | None, size: tuple[int, int], name: str) -> None:
    """Raise FrameError where a crop does not lie within the picture."""
    width, height = size
    if crop is None:
        return
    across = crop.x >= 0 and crop.width > 0 and crop.x + crop.width <= width
    down = crop.y >= 0 and crop.height > 0 and crop.y + crop.height <= height
    if not (across and down):
        raise FrameError(
            f"--crop {crop.x},{crop.y},{crop.width},{crop.height}: does not lie within {name}, {width}x{height} px"
        )
