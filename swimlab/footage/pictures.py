"""A run folder's pictures, rendered or brought: one way to read both, by technique and frame number."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from threading import Lock
from typing import Protocol

import numpy as np

from swimlab.footage.brought import requests_of
from swimlab.footage.depth import Depth
from swimlab.footage.moving import open_motion
from swimlab.footage.reader import Reader, open_frames
from swimlab.footage.reference import open_reference
from swimlab.footage.request import Request
from swimlab.footage.source import Mask, Source, least
from swimlab.footage.sources import check_unchanged
from swimlab.runs.frames import FrameError, Image, frame_path, read_frame, read_geometry
from swimlab.runs.record import GEOMETRY, REFERENCE, Record

Moved = Callable[[int], Image]
"""Frame -> [H, W, 2] px right and down that the surface seen there moved since a frame before; NaN where unknown."""


class Pictures(Protocol):
    """The pictures of a run. called: what one of their kinds is called; kept: where they are, as a sentence's end."""

    called: str
    kept: str

    def read(self, technique: str, frame: int, *, rows: tuple[int, int] | None = None) -> Image:
        """[H, W, 4] linear premultiplied radiance and alpha, which is 0 where brought frames are not measured.

        rows: rows first..end-1 alone. Raises FrameError where the picture is gone, or is not what was measured.
        """

    def motion(self, frames: Sequence[int]) -> Moved:
        """How the surface moved from each of these frames to the next, without jitter that was estimated.

        Raises FrameError as `read` does.
        """

    def depth(self, frame: int) -> Image:
        """[H, W] m along the camera's axis, 0 where there is no surface. Raises FrameError as `read` does."""


def open_pictures(folder: Path, record: Record) -> Pictures:
    """The pictures of a run folder; nothing is read yet."""
    return BroughtPictures(record) if record.inputs else RenderedPictures(folder, record)


class RenderedPictures:
    """Pictures in the run folder itself."""

    called = "technique"
    kept = "rendered frames are in the run folder as EXR"

    def __init__(self, folder: Path, record: Record) -> None:
        self._folder = folder
        self._velocity = record.uniform_velocity
        self._size = record.sequence.get("size", (0, 0))

    def read(self, technique: str, frame: int, *, rows: tuple[int, int] | None = None) -> Image:
        path = frame_path(self._folder, technique, frame)
        if not path.is_file():
            raise FrameError(f"{path} is gone")
        return read_frame(path, rows=rows)

    def motion(self, frames: Sequence[int]) -> Moved:
        if self._velocity is not None:
            velocity, before = np.array(self._velocity, np.float32), dict(zip(frames[1:], frames, strict=False))
            shape = (*self._size[::-1], 2)
            return lambda frame: np.broadcast_to(velocity * (frame - before.get(frame, frame - 1)), shape)
        return lambda frame: read_geometry(frame_path(self._folder, GEOMETRY, frame)).motion

    def depth(self, frame: int) -> Image:
        return read_geometry(frame_path(self._folder, GEOMETRY, frame)).depth


Coverage = Callable[[int], Image]


class BroughtPictures:
    """Pictures that stay where they are."""

    called = "build"
    kept = "brought frames are where they were measured, in files that run.json names"

    def __init__(self, record: Record) -> None:
        self._inputs = record.inputs
        self._requests: Mapping[str, Request] = requests_of(record)
        self._opened: dict[str, Source] = {}
        self._own: dict[str, Coverage | None] = {}
        self._numbers: tuple[int, ...] = ()
        self._lock = Lock()

    def read(self, technique: str, frame: int, *, rows: tuple[int, int] | None = None) -> Image:
        with self._lock:
            source = self._source(technique)
            own = self._own[technique]
            source.measured = least([*filter(None, [own, *(self._coverage_of(each) for each in self._met(technique))])])
        if frame not in self._numbers:
            raise FrameError(f"{source.reader.name}: has no frame {frame} any more; measure the frames again")
        index = self._numbers.index(frame)
        wanted = slice(*(rows or (None,)))
        colour = source.picture(index, rows=wanted)
        coverage = np.ones(colour.shape[:2], np.float32) if own is None else own(index)[wanted]
        return np.dstack([colour, coverage]).astype(np.float32)

    def motion(self, frames: Sequence[int]) -> Moved:
        with self._lock:
            test = self._source(next(iter(self._requests)))
            reference = self._source(REFERENCE) if REFERENCE in self._inputs else None
        moving = ("motion", "motion mask", "motion jitter")
        check_unchanged({what: given for what, given in self._inputs.items() if what in moving})
        indices = [self._numbers.index(frame) for frame in frames]
        request = next(iter(self._requests.values()))
        pair = indices[:2]  # of all that there are only these are looked through ahead of need
        found = open_motion(request, test, reference, pair, match=_as_measured, note=_unheard, say=_unheard).motion

        def moved(frame: int) -> Image:
            place = frames.index(frame)
            pair = indices[place], indices[place - 1]
            known = found.known(*pair)
            field = found.moved(*pair)
            return field if known is None else np.where(known[..., None], field, np.float32(np.nan))

        return moved

    def depth(self, frame: int) -> Image:
        request = next(iter(self._requests.values()))
        if request.depth is None:
            raise FrameError("there is no depth")
        check_unchanged({what: given for what, given in self._inputs.items() if what == "depth"})
        with self._lock:
            self._source(next(iter(self._requests)))
        reader = open_frames(request.depth, frames=request.frames)
        return Depth(reader, request).distance(self._numbers.index(frame)).astype(np.float32)

    def _source(self, technique: str) -> Source:
        """The frames of a build or of the reference; each has its own reader."""
        if technique not in self._opened:
            if technique not in self._inputs:
                raise FrameError(f"there is no {technique}")
            check_unchanged({what: given for what, given in self._inputs.items() if what in (technique, "mask")})
            name = next(iter(self._requests)) if technique == REFERENCE else technique
            request = self._requests[name]
            source = Source(open_frames(request.test, frames=request.frames), request.look)
            self._numbers = source.reader.numbers
            if technique == REFERENCE and request.reference is not None:
                source = open_reference(
                    open_frames(request.reference, frames=request.frames), request.reference_look, source
                )
            self._own[technique] = _coverage(source, request)
            self._opened[technique] = source
        return self._opened[technique]

    def _met(self, technique: str) -> list[str]:
        """What a picture is measured against: where that is not measured, this need not be finite."""
        if technique != REFERENCE:
            return [REFERENCE] if REFERENCE in self._inputs else []
        return [name for name, request in self._requests.items() if request.look.alpha not in (None, "ignore")]

    def _coverage_of(self, technique: str) -> Coverage | None:
        self._source(technique)
        return self._own[technique]


def _as_measured(reader: Reader, what: str, *, still: bool = False) -> None:
    """Inputs that are as they were when they were measured fit together."""


def _unheard(text: str) -> None:
    """What there is to say was said when the frames were measured."""


def _coverage(source: Source, request: Request) -> Coverage | None:
    """Where mask and alpha let the pictures of a source be measured; None: everywhere."""
    givers = [source.coverage] if source.has_coverage else []
    if request.mask is not None:
        reader = open_frames(request.mask, frames=request.frames)
        mask = Mask(reader, request.look.crop, channel=request.mask_channels, part=request.mask_part)
        givers.append(mask.coverage)
    return least(givers)
