"""Frame files: RGBA pictures and geometry as EXR through OpenImageIO, and pictures to look at as PNG."""

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from metrics.memory import unset
from swimlab.runs.files import replacing

Image = NDArray[np.float32]

COLOUR = ("R", "G", "B", "A")
GEOMETRY = ("coverage", "motion.X", "motion.Y", "depth.Z")


STRIP = 64
"""Scanlines of an EXR read at a time, if a block of its compression is not larger."""

WRITTEN = "1970:01:01 00:00:00"
"""The date in every file, in place of the present one: the same picture is the same bytes. run.json has the date."""

AGAIN = "delete it and give the command that rendered it again"
"""How a picture of a run is mended."""


class FrameError(ValueError):
    """A frame file that cannot be read or is not what was asked for; the message names the file."""


@dataclass(frozen=True)
class Geometry:
    """What the camera sees in each pixel of a frame.

    coverage: [H, W], 0..1, the fraction of the pixel that the surface covers.
    motion: [H, W, 2], px, how far the surface seen here moved since the previous frame, +x right, +y down.
    depth: [H, W], m along the camera axis, 0 where there is no surface.
    """

    coverage: Image
    motion: Image
    depth: Image


def oiio_name(path: Path) -> str:
    """A file's name as OpenImageIO takes it, which is UTF-8 under every locale. Raises FrameError where it is not."""
    try:
        return os.fsencode(path).decode("utf-8")
    except UnicodeDecodeError:
        raise FrameError(f"{path}: has a name that is not UTF-8; rename it") from None


def frame_path(run: Path, folder: str, frame: int) -> Path:
    """The file of one frame of a technique (or of `geometry`) in a run folder."""
    return run / folder / f"{frame:04d}.exr"


def write_frame(path: Path, rgba: Image, *, half: bool, metadata: Mapping[str, str]) -> None:
    """Write a picture [H, W, 4] of linear premultiplied radiance."""
    write_channels(path, rgba, COLOUR, half=half, metadata=metadata)


def read_frame(path: Path, *, rows: tuple[int, int] | None = None) -> Image:
    """Read the channels R, G, B, A of a picture as [H, W, 4] linear premultiplied radiance.

    rows: read rows first..end-1 alone, counted from the top. Raises FrameError where the file is missing, broken or
    lacks a channel.
    """
    return read_channels(path, COLOUR, rows=rows)


def write_geometry(path: Path, geometry: Geometry, *, metadata: Mapping[str, str]) -> None:
    """Write coverage, motion and depth, always as 32-bit floats: a half loses .016 px at 64 px."""
    pixels = np.concatenate([geometry.coverage[..., None], geometry.motion, geometry.depth[..., None]], axis=2)
    write_channels(path, pixels, GEOMETRY, half=False, metadata=metadata)


def read_geometry(path: Path) -> Geometry:
    """Read coverage, motion and depth. Raises FrameError as `read_frame` does."""
    pixels = read_channels(path, GEOMETRY)
    return Geometry(coverage=pixels[..., 0], motion=pixels[..., 1:3], depth=pixels[..., 3])


def write_channels(
    path: Path, pixels: Image, channels: tuple[str, ...], *, half: bool, metadata: Mapping[str, str]
) -> None:
    """Write named channels [H, W, len(channels)] as a zip-compressed EXR: whole or not at all.

    Raises FrameError where the file cannot be written.
    """
    import OpenImageIO as oiio  # noqa: N813, heavy

    height, width, count = pixels.shape
    spec = oiio.ImageSpec(width, height, count, oiio.HALF if half else oiio.FLOAT)
    spec.channelnames = channels
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", WRITTEN)
    for key, value in metadata.items():
        spec.attribute(key, value)
    with replacing(path) as temporary:
        output: Any = oiio.ImageOutput.create("exr")
        written = (
            output.open(oiio_name(temporary), spec)
            and output.write_image(np.ascontiguousarray(pixels, np.float32))
            and output.close()
        )
        if not written:
            why = output.geterror().replace(oiio_name(temporary), str(path))
            raise FrameError(f"{path}: cannot be written: {why}")


def read_channels(path: Path, channels: tuple[str, ...], *, rows: tuple[int, int] | None = None) -> Image:
    """Read named channels of an image file, or of some of its rows, as float32 [H, W, len(channels)].

    Raises FrameError.
    """
    import OpenImageIO as oiio  # noqa: N813, heavy

    source = oiio.ImageInput.open(oiio_name(path))
    if source is None:
        raise FrameError(f"{path}: cannot be opened: {oiio.geterror()}; {AGAIN}")
    names = list(source.spec().channelnames)
    missing = [name for name in channels if name not in names]
    if missing:
        raise FrameError(f"{path}: has no channel {', '.join(missing)}; it has {', '.join(names)}")
    wanted = [names.index(name) for name in channels]
    top = source.spec().y
    pixels = read_pixels(source, wanted, rows=None if rows is None else (top + rows[0], top + rows[1]))
    source.close()
    if pixels is None:
        raise FrameError(f"{path}: is damaged: {source.geterror()}; {AGAIN}")
    return pixels


def read_pixels(
    source: Any, wanted: Sequence[int], *, part: int = 0, rows: tuple[int, int] | None = None
) -> Image | None:
    """Channels by their numbers of an open file's part [H, W, len(wanted)], float32; None if it cannot be read.

    rows: rows first..end-1 alone, as the file counts them. In memory a pair of channels lies side by side, as vectors
    do, and more one after the other, as pictures are measured. The scanlines of an EXR come in strips that stay in the
    cache, and halves as halves: all in one piece they take a third longer.
    """
    spec = source.spec()
    top, bottom = rows or (spec.y, spec.y + spec.height)
    shape = (bottom - top, spec.width)
    if len(wanted) == 2:
        found = unset((*shape, 2), np.float32)
    else:
        found = np.moveaxis(unset((len(wanted), *shape), np.float32), 0, 2)
    block = spec.get_int_attribute("oiio:RowsPerChunk", 0)
    step = max(1, STRIP // block) * block if block and not spec.tile_width else bottom - top
    # While a strip is read, a thread lays out the one before; a file of one strip needs none.
    with ThreadPoolExecutor(1) as layer:
        before: Future[None] | None = None
        for row in range(top, bottom, max(1, step)):
            end = min(row + step, bottom)
            strip = _read_strip(source, spec, part, wanted, row, end)
            if strip is None:
                return None
            if before is not None:
                before.result()
            place = found[row - top : end - top]
            if end < bottom:
                before = layer.submit(np.copyto, place, strip)
            else:
                np.copyto(place, strip)
    return found


def _read_strip(source: Any, spec: Any, part: int, wanted: Sequence[int], top: int, bottom: int) -> Any:
    """Rows of channels by their numbers, halves where all are."""
    import OpenImageIO as oiio  # noqa: N813, heavy

    first, stop = min(wanted), max(wanted) + 1
    kinds = list(spec.channelformats) or [spec.format] * spec.nchannels
    kind = oiio.HALF if all(each == oiio.HALF for each in kinds[first:stop]) else oiio.FLOAT
    if (top, bottom) == (spec.y, spec.y + spec.height):
        strip = source.read_image(part, 0, first, stop, kind)
    else:
        strip = source.read_scanlines(part, 0, top, bottom, 0, first, stop, kind)
    if strip is None or list(wanted) == list(range(first, stop)):
        return strip
    return strip[..., [each - first for each in wanted]]


COMPRESSION = 6


def png(codes: NDArray[np.uint8]) -> bytes:
    """The bytes of a PNG file of codes [H, W, 3], red first."""
    bgr = np.ascontiguousarray(codes[..., ::-1])
    encoded: NDArray[np.uint8] = cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, COMPRESSION])[1]
    return encoded.tobytes()
