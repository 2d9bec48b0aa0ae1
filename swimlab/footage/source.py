"""Frames as linear radiance: channels chosen, colours decoded, alpha and crop applied."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from metrics.display import Display, Domain
from swimlab.footage.channels import find_alpha, find_colour, find_parts
from swimlab.footage.colour import AS_STORED, AUTO, SRGB, decode, quantisation_floor, resolve
from swimlab.footage.latest import Latest
from swimlab.footage.reader import LEAVE_OUT, Reader
from swimlab.runs.frames import FrameError, Image

AlphaUse = Literal["ignore", "mask", "unpremultiply"]

BRIGHTEST = 1e12
"""Values beyond this are mistakes: their squares, and sums of them, leave single precision."""
_OPAQUE = 1 - 0.5 / 255
"""Alpha from here on is 1 as far as 8 bit can say; halves and denoisers miss 1 by less."""


def least(givers: Sequence[Callable[[int], Image]]) -> Callable[[int], Image] | None:
    """The least of several coverages, each index -> [H, W]; None where there is none."""
    return Least(tuple(givers)) if givers else None


@dataclass(frozen=True)
class Least:
    """The least of several coverages."""

    givers: tuple[Callable[[int], Image], ...]

    def __call__(self, index: int) -> Image:
        return np.asarray(np.minimum.reduce([giver(index) for giver in self.givers]))


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
    """How stored values become radiance; None where it is not said.

    channels: three channels with commas, one, or a layer; None: found. colour_space: a name of OpenColorIO's
    configuration, "linear", "srgb" or "auto"; None: auto, what the files say. alpha: "ignore" (None) takes colours as
    stored, "mask" measures only pixels of alpha 1, "unpremultiply" divides premultiplied colours by alpha and measures
    where it is above 0. part: name, view or index of the only part of a file to look into.
    """

    channels: str | None = None
    colour_space: str | None = None
    alpha: AlphaUse | None = None
    part: str | None = None
    crop: Box | None = None


class Source:
    """Frames by index as linear radiance."""

    def __init__(self, reader: Reader, look: Look, *, prefix: str = "") -> None:
        """Frames without alpha are wholly opaque. prefix: of the input's options, as "reference-".

        Raises FrameError where channels, colour space or crop are not available.
        """
        self.reader = reader
        self.look = look
        self.measured: Callable[[int], Image] | None = None
        """Index -> [H, W], 0 where a frame is not measured: there it need not be finite."""
        self.part, self.channels = find_colour(reader.header, look.channels, reader.name, part=look.part, prefix=prefix)
        part = reader.header.parts[self.part]
        self.stored_as = part.types[part.channels.index(self.channels[0])]
        try:
            self.space = resolve(look.colour_space or AUTO, stored_as=self.stored_as, metadata=part.colour_space)
        except ValueError as error:
            option = f"--{prefix}colorspace"
            if look.colour_space in (None, AUTO):
                raise FrameError(
                    f"{reader.name}: says that it is in {part.colour_space}, which is not known: name a colour space "
                    f"with {option}, or linear to take values as they are"
                ) from error
            raise FrameError(f"{option} {look.colour_space}: {error}") from error
        self._alpha = find_alpha(part, self.channels) if look.alpha not in (None, "ignore") else None
        check_crop(look.crop, reader.header.size, reader.name)
        self._read = Latest(self._stored, 2)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width after cropping."""
        width, height = self.reader.header.size
        return (self.look.crop.height, self.look.crop.width) if self.look.crop else (height, width)

    @property
    def reading(self) -> tuple[object, ...]:
        """Part, channels, colour space, use of alpha and crop: frames of the same files read alike are equal."""
        return self.part, self.channels, self.space, self.look.alpha or "ignore", self.look.crop

    @property
    def has_coverage(self) -> bool:
        """Whether the alpha says where to measure."""
        return self._alpha is not None

    def problems(self) -> dict[int, str]:
        """What is wrong with frames, by index, as far as headers tell."""
        return self.reader.problems(self.part, self._channels_read)

    def picture(self, index: int, *, rows: slice = slice(None)) -> Image:
        """[H, W, 3] linear radiance, or some of its rows; 0 where it is not measured and no finite number.

        Raises FrameError naming the frame, also for NaN, Inf and values of no picture.
        """
        stored = self._read(index)[rows]
        colour = stored[..., : len(self.channels)]
        if self._alpha is not None and self.look.alpha == "unpremultiply" and not self.reader.header.unassociated:
            alpha = stored[..., -1:]
            colour = np.where(alpha > 0, colour / np.where(alpha > 0, alpha, 1), 0)
        colour = self._usable(colour, index, rows)
        radiance = self._decoded(colour)
        return np.asarray(np.broadcast_to(radiance, (*radiance.shape[:2], 3)))

    def _usable(self, colour: Image, index: int, rows: slice) -> Image:
        """Colours without what is not measured and not finite. Raises FrameError where that is measured."""
        usable = np.abs(colour) <= BRIGHTEST
        if usable.all():
            return colour
        unmeasured = False if self.measured is None else (self.measured(index)[rows] <= 0)[..., None]
        check_usable(np.where(unmeasured, 0, colour), self.reader.label(index))
        return np.where(usable, colour, np.float32(0))

    def _decoded(self, colour: NDArray[Any]) -> NDArray[Any]:
        """Linear radiance of stored colours, grey ones as grey in every channel where the space needs three."""
        if self.space not in (AS_STORED, SRGB):
            colour = np.broadcast_to(colour, (*colour.shape[:2], 3))
        try:
            return decode(colour, self.space)
        except ValueError as error:
            raise FrameError(f"{self.reader.name}: {error}") from error

    def coverage(self, index: int) -> Image:
        """[H, W] 1 where the alpha lets a pixel be measured, else 0."""
        alpha = self._read(index)[..., -1]
        enough = alpha > 0 if self.look.alpha == "unpremultiply" else alpha >= _OPAQUE
        return enough.astype(np.float32)

    def quantisation(self, indices: Iterable[int], domain: Domain, display: Display) -> list[float | None]:
        """Mean squared errors of rounding some frames to stored codes, radiance^2; None for 32-bit floats."""
        return [
            quantisation_floor(
                self._quantised(index),
                stored_as=self.stored_as,
                space=self.space,
                domain=domain,
                display=display,
                full_scale=self.reader.header.full_scale,
            )
            for index in indices
        ]

    def _quantised(self, index: int) -> Image:
        """Stored colours [H, W, 3 or 1] as `decode` takes them, 0 where they are no finite number."""
        colour = np.nan_to_num(self._read(index)[..., : len(self.channels)], nan=0, posinf=0, neginf=0)
        return colour if self.space in (AS_STORED, SRGB) else np.broadcast_to(colour, (*colour.shape[:2], 3))

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
        return self.look.crop.cut(pixels) if self.look.crop else pixels


class Mask:
    """Where to measure: one picture for all frames or one a frame, 1 where a channel of it is above one half."""

    def __init__(
        self,
        reader: Reader,
        crop: Box | None,
        *,
        channel: str | None = None,
        part: str | None = None,
        prefix: str = "mask-",
    ) -> None:
        """channel: None: the first one. part: name, view or index; None: the first that has the channel.

        prefix: of the options. Raises FrameError for a part or channel that is not there.
        """
        self.reader = reader
        self._crop = crop
        parts = find_parts(reader.header, part, reader.name, option=f"--{prefix}part")
        having = [index for index, each in parts.items() if channel in (None, *each.channels)]
        if not having:
            listed = "; ".join(", ".join(each.channels) for each in parts.values())
            raise FrameError(f"--{prefix}channels {channel}: {reader.name} has {listed}; name one of them")
        self._part = having[0]
        self._channels = (channel or parts[self._part].channels[0],)

    def problems(self) -> dict[int, str]:
        """What is wrong with files, by index, as far as headers tell."""
        return self.reader.problems(self._part, self._channels)

    def coverage(self, index: int) -> Image:
        """[H, W], 0 or 1. Raises FrameError."""
        index = index if len(self.reader.numbers) > 1 else 0
        pixels = self.reader.read(index, self._part, self._channels)[..., 0]
        check_usable(pixels, self.reader.label(index))
        inside = (pixels > 0.5).astype(np.float32)
        return np.asarray(self._crop.cut(inside) if self._crop else inside)


def check_usable(pixels: Image, label: str) -> None:
    """Raise FrameError naming the frame and the first pixel that is NaN, infinite or too large to be measured."""
    usable = np.abs(pixels) <= BRIGHTEST
    if usable.all():
        return
    bad = np.argwhere(~usable)
    place = f"the first at pixel x {bad[0][1]}, y {bad[0][0]}"
    finite = pixels[~usable][np.isfinite(pixels[~usable])]
    what = f"values of up to {np.abs(finite).max():.3g}" if len(finite) == len(bad) else "NaN or infinite values"
    raise FrameError(
        f"{label}: holds {len(bad)} {what}, {place}; mend the frame, mask the place with --mask, or leave it out with "
        "--skip-bad-frames"
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
