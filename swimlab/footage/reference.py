"""The reference beside the test: how the files of both are read, and whether they are in one colour space."""

import cv2
import numpy as np
from numpy.typing import NDArray

from swimlab.footage.channels import find_colour, other_colours
from swimlab.footage.colour import AUTO, FLOATS, SRGB, decode
from swimlab.footage.reader import Reader
from swimlab.footage.request import Request
from swimlab.footage.source import Look, Source
from swimlab.runs.frames import FrameError, Image

_PREFIX = "reference-"

_BLOCKS, _BLOCK = 24, 8
"""Means of so many blocks a side are compared, of so many px a side at least: a test's noise is small in them."""
_APART = 0.03
"""Relative rms of the blocks' differences that is worth a word."""
_EXPLAINED = 0.25
"""Share of the differences that a curve may leave where it is the explanation."""


def open_reference(reader: Reader, given: Look, test: Source) -> Source:
    """The reference's frames, by its own options, else what its files say, else the test's options.

    What the test's options name and the reference's files lack is not asked of it; the test's colour space counts
    where both are floats or both integers, and the reference's files do not say. Raises FrameError.
    """
    header, look = reader.header, test.look
    part = given.part if given.part is not None else _if_there(reader, look.channels, look.part)
    channels = given.channels
    if channels is None and look.channels is not None:
        try:
            find_colour(header, look.channels, reader.name, part=part, prefix=_PREFIX)
            channels = look.channels
        except FrameError:
            channels = None
    index, found = find_colour(header, channels, reader.name, part=part, prefix=_PREFIX)
    own = header.parts[index]
    stored_as = own.types[own.channels.index(found[0])]
    alike = (stored_as in FLOATS) == (test.stored_as in FLOATS)
    space = given.colour_space
    if space is None:
        space = look.colour_space if own.colour_space is None and alike else AUTO
    return Source(
        reader,
        Look(channels=channels, colour_space=space, alpha=given.alpha or look.alpha, part=part, crop=look.crop),
        prefix=_PREFIX,
    )


def _if_there(reader: Reader, channels: str | None, part: str | None) -> str | None:
    """The test's part, if the reference has a part of that name too."""
    try:
        find_colour(reader.header, None if part is None else channels, reader.name, part=part, prefix=_PREFIX)
    except FrameError:
        return None
    return part


def check_alpha(request: Request, test: Source, reference: Source | None) -> None:
    """Raise FrameError where alpha is to be used and there is none."""
    asked, own = request.look.alpha, request.reference_look.alpha
    if asked not in (None, "ignore") and not any(source and source.has_coverage for source in (test, reference)):
        raise FrameError(f"--alpha {asked}: {test.reader.name} has no alpha")
    if own not in (None, "ignore") and reference is not None and not reference.has_coverage:
        raise FrameError(f"--{_PREFIX}alpha {own}: {reference.reader.name} has no alpha")


def passed_over(test: Source, reference: Source | None) -> list[str]:
    """What to say where files have the channels of the colour more than once and nobody chose."""
    said = []
    for source, prefix in ((test, ""), (reference, _PREFIX)):
        if source is not None and source.look.part is None and source.look.channels is None:
            header, name = source.reader.header, source.reader.name
            others = other_colours(header, source.part)
            if others:
                taken = header.parts[source.part].name or str(source.part)
                other = ", ".join(others)
                said.append(
                    f"{name}: its part {taken} is measured; {other} have a colour too, which --{prefix}part chooses"
                )
    return said


def curve_between(test: Source, reference: Source, index: int, coverage: Image | None) -> str:
    """What to say where one of the two looks as the other does through sRGB's curve; empty where none does."""
    shown, true = test.picture(index), reference.picture(index)
    weight = np.ones(shown.shape[:2], np.float32) if coverage is None else coverage
    apart = _distance(shown, true, weight)
    if apart < _APART:
        return ""
    forms = (
        (test, "test", "", _distance(_decoded(shown), true, weight)),
        (reference, "reference", _PREFIX, _distance(shown, _decoded(true), weight)),
    )
    source, name, prefix, left = min(forms, key=lambda form: form[3])
    if left > _EXPLAINED * apart:
        return ""
    other = reference if source is test else test
    return (
        f"test and reference differ as sRGB codes differ from light: the {name} was taken as {source.space}, the other "
        f"as {other.space}; if that is wrong, give --{prefix}colorspace {SRGB}, or what it is in"
    )


def _decoded(picture: Image) -> NDArray[np.float64]:
    return np.asarray(decode(np.clip(picture.astype(np.float64), 0, 1), SRGB))


def _distance(a: NDArray[np.floating], b: NDArray[np.floating], weight: Image) -> float:
    """Rms difference of block means, relative to the rms of the second picture's."""
    first, second = (_blocks(picture, weight) for picture in (a, b))
    scale = float(np.sqrt(np.mean(second**2)))
    return float(np.sqrt(np.mean((first - second) ** 2))) / scale if scale > 0 else 0.0


def _blocks(picture: NDArray[np.floating], weight: Image) -> NDArray[np.float64]:
    height, width = weight.shape
    size = tuple(min(_BLOCKS, max(side // _BLOCK, 1)) for side in (width, height))
    weighted = picture.mean(axis=2) * weight
    return np.asarray(cv2.resize(weighted.astype(np.float64), size, interpolation=cv2.INTER_AREA))
