"""What an image file says of itself, and its stored values, through OpenImageIO."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swimlab.footage.colour_tags import stated_space
from swimlab.runs.frames import FrameError, Image, oiio_name, read_pixels

_SQUARE = 1e-3
"""Pixels whose sides differ by less, as a share, are square."""
LOSSY = frozenset({"dwaa", "dwab", "b44", "b44a", "pxr24", "jpeg", "webp", "lossy video"})
"""Compressions that change the pixels."""


@dataclass(frozen=True)
class Part:
    """A part (OpenImageIO: subimage) of a file: its channels, and what each is stored as: uint8, half, float...

    colour_space: what its metadata says, None where it says nothing. view: of a stereo pair, as left. deep: with any
    number of samples a pixel, it is no picture.
    """

    name: str
    channels: tuple[str, ...]
    types: tuple[str, ...]
    colour_space: str | None = None
    view: str = ""
    deep: bool = False


@dataclass(frozen=True)
class Header:
    """size: width, height of the picture (EXR: of its display window).

    unassociated: the colours are not premultiplied. full_scale: codes from black to white of integers that do not use
    their whole range (video), else None. pixel_aspect: width of a pixel over its height.
    """

    size: tuple[int, int]
    parts: tuple[Part, ...]
    compression: str
    fps: float | None = None
    unassociated: bool = False
    full_scale: int | None = None
    pixel_aspect: float = 1.0

    @property
    def oblong(self) -> str:
        """What its pixels are where they are not square, in words; else empty."""
        aspect = self.pixel_aspect
        return f"{aspect:.4g} times as wide as high" if abs(aspect - 1) > _SQUARE else ""


def read_header(path: Path) -> Header:
    """Read what a file says of itself. Raises FrameError where it is no image file that can be read."""
    source = _open(path)
    parts: list[Part] = []
    first: Any = source.spec()
    while source.seek_subimage(len(parts), 0):
        spec = source.spec()
        types = [str(kind) for kind in spec.channelformats] or [str(spec.format)] * spec.nchannels
        name = spec.get_string_attribute("oiio:subimagename") or spec.get_string_attribute("name")
        space, view = stated_space(path, spec), spec.get_string_attribute("view")
        parts.append(Part(name, tuple(spec.channelnames), tuple(types), space, view, deep=bool(spec.deep)))
    source.close()
    if all(part.deep for part in parts):
        raise FrameError(f"{path}: is deep, with any number of samples a pixel; flatten it, as oiiotool --flatten does")
    if first.get_int_attribute("oiio:Movie"):
        raise FrameError(f"{path}: is a moving picture; write its frames as files, as ffmpeg does, and name these")
    suffix = path.suffix.lower()
    rate = first.getattribute("FramesPerSecond")
    if isinstance(rate, tuple):
        rate = rate[0] / rate[1] if rate[1] else 0
    return Header(
        size=(first.full_width, first.full_height),
        parts=tuple(parts),
        compression="jpeg" if suffix in (".jpg", ".jpeg") else first.get_string_attribute("compression") or suffix[1:],
        fps=float(rate) if rate and rate > 0 else None,
        unassociated=bool(first.get_int_attribute("oiio:UnassociatedAlpha", 0)),
        pixel_aspect=first.get_float_attribute("PixelAspectRatio", 1.0) or 1.0,
    )


def read_stored(path: Path, part: int, channels: Sequence[str]) -> Image:
    """The stored values of named channels [H, W, len(channels)] over the display window, 0 outside the data.

    Integers are scaled to 0..1; colours are neither decoded nor multiplied. Raises FrameError.
    """
    source = _open(path)
    if not source.seek_subimage(part, 0):
        raise FrameError(f"{path}: has no part {part}")
    spec = source.spec()
    names = list(spec.channelnames)
    absent = [name for name in channels if name not in names]
    if absent:
        raise FrameError(f"{path}: has no channel {', '.join(absent)}; it has {', '.join(names)}")
    wanted = [names.index(name) for name in channels]
    chosen = read_pixels(source, wanted, part=part)
    source.close()
    if chosen is None:
        raise FrameError(f"{path}: is damaged: {source.geterror().strip()}")
    return _in_display_window(chosen, spec)


def find_damage(path: Path) -> str:
    """What is wrong with a file's data, empty if nothing: what is written first and last is read, tiles in full."""
    import OpenImageIO as oiio  # noqa: N813, heavy

    try:
        source = _open(path)
    except FrameError as error:
        return str(error)
    part = 0
    while source.seek_subimage(part, 0):
        spec = source.spec()
        if spec.tile_width:
            read = [source.read_image(part, 0, 0, spec.nchannels, oiio.FLOAT)]
        else:
            rows = {spec.y, spec.y + spec.height - 1}
            read = [source.read_scanlines(part, 0, y, y + 1, 0, 0, spec.nchannels, oiio.FLOAT) for y in sorted(rows)]
        if any(pixels is None for pixels in read):
            return f"{path}: is damaged: {source.geterror().strip()}"
        part += 1
    source.close()
    # What seeking past the last part, or decoding with a warning, leaves behind is no fault of the frame.
    source.geterror()
    return ""


def _open(path: Path) -> Any:
    import OpenImageIO as oiio  # noqa: N813, heavy

    # Without this, OpenImageIO multiplies the colours of a PNG by its alpha.
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(oiio_name(path), config)
    if source is None:
        raise FrameError(f"{path}: cannot be opened: {oiio.geterror()}")
    return source


def _in_display_window(pixels: Image, spec: Any) -> Image:
    left, top = spec.x - spec.full_x, spec.y - spec.full_y
    if (left, top, spec.width, spec.height) == (0, 0, spec.full_width, spec.full_height):
        return pixels
    whole = np.zeros((spec.full_height, spec.full_width, pixels.shape[2]), np.float32)
    rows = slice(max(top, 0), max(min(top + spec.height, spec.full_height), 0))
    columns = slice(max(left, 0), max(min(left + spec.width, spec.full_width), 0))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return whole
    whole[rows, columns] = pixels[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    return whole
