"""Opened inputs of a request: frames that fit together, which of them are good, and where they are covered."""

from collections.abc import Callable, Collection
from typing import Any

import numpy as np

from swimlab.footage.depth import Depth
from swimlab.footage.header import LOSSY
from swimlab.footage.pattern import frame_range
from swimlab.footage.reader import Reader, open_frames
from swimlab.footage.reference import check_alpha, open_reference, passed_over
from swimlab.footage.request import Request
from swimlab.footage.source import Mask, Source, least
from swimlab.runs.counting import counted
from swimlab.runs.frames import FrameError, Image

FPS = 60.0

_SAMPLED = 3


def _to_nobody(_: str) -> None:
    """Say nothing."""


def _left_out(numbers: Collection[int], why: str = "") -> str:
    """That frames are left out."""
    many = len(numbers) > 1
    return f"{len(numbers)} bad frame{'s are' if many else ' is'} left out{why}: {frame_range(sorted(numbers))}"


class Opened:
    """The opened inputs of a request, and which frames of them are measured."""

    def __init__(self, request: Request, say: Callable[[str], None], warn: Callable[[str], None]) -> None:
        """say, warn: called with what a reader of the scores should know, and with what may make them wrong.

        Raises FrameError where inputs do not fit together or a frame is bad.
        """
        self.notes: list[str] = []
        self.warnings: list[str] = []
        """Those of the notes that may make the scores wrong."""
        self.request = request
        self._say = say
        self._warn = warn
        look = request.look
        self.test = Source(open_frames(request.test, frames=request.frames), look)
        self.reference = None
        if request.reference is not None:
            reader = open_frames(request.reference, frames=request.frames)
            self._match(reader, "reference")
            self.reference = open_reference(reader, request.reference_look, self.test)
            if self.reference.space != self.test.space:
                say(f"the test is taken as {self.test.space}, the reference as {self.reference.space}")
        for text in passed_over(self.test, self.reference):
            self.note(text)
        check_alpha(request, self.test, self.reference)
        self.mask = None
        if request.mask is not None:
            reader = open_frames(request.mask, frames=request.frames)
            self._match(reader, "mask", still=True)
            self.mask = Mask(reader, look.crop, channel=request.mask_channels, part=request.mask_part)
        self.depth = None
        if request.depth is not None:
            self.depth = Depth(open_frames(request.depth, frames=request.frames), request)
            self._match(self.depth.reader, "depth")
        self._tell_of_files()
        for source in filter(None, (self.test, self.reference)):
            source.measured = self._stated_coverage()
        self.bad: frozenset[int] = frozenset()
        """Numbers of frames that cannot be measured and are left out."""
        self.kept = self._good_frames()
        if len(self.kept) < 2:
            raise FrameError(f"{request.test}: has {len(self.kept)} frame to measure; change in time needs at least 2")
        self._check_measured()

    def __getstate__(self) -> dict[str, Any]:
        """All but whom it speaks to."""
        return vars(self) | {"_say": _to_nobody, "_warn": _to_nobody}

    def sampled(self) -> list[int]:
        """A few of the frames, spread over the clip."""
        chosen = np.linspace(0, len(self.kept) - 1, _SAMPLED).round().astype(int)
        return sorted({self.kept[index] for index in chosen})

    @property
    def fps(self) -> float:
        """Frames a second: as given, else the file's own, else 60."""
        return self.request.fps or self.test.reader.header.fps or FPS

    def _stated_coverage(self) -> Callable[[int], Image] | None:
        """Where frames are measured, by mask, test and reference."""
        givers = [each.coverage for each in (self.test, self.reference) if each and each.has_coverage]
        givers += [self.mask.coverage] if self.mask is not None else []
        return least(givers)

    def _check_measured(self) -> None:
        """Raise FrameError where mask and alpha leave nothing to measure."""
        coverage = self._stated_coverage()
        if coverage is not None and not any(coverage(index).any() for index in self.sampled()):
            raise FrameError(
                f"{self.test.reader.name}: no pixel is to be measured: the mask is nowhere above 0.5 or the alpha "
                "nowhere 1; mend it, or leave out --mask and --alpha"
            )

    def _good_frames(self) -> list[int]:
        """Indices of the frames to measure. Raises FrameError for the first bad one, unless bad ones are skipped."""
        problems: dict[int, str] = {}
        for source in (self.test, self.reference):
            problems = (source.problems() if source is not None else {}) | problems
        problems |= self.depth.problems() if self.depth is not None else {}
        if self.mask is not None and len(self.mask.reader.numbers) > 1:
            problems |= self.mask.problems()
        there = self._times()
        if not self.request.skip_bad_frames:
            if problems:
                raise FrameError(problems[min(problems)])
            return there
        for index in there:
            for source in (self.test, self.reference):
                if source is not None and index not in problems:
                    try:
                        source.picture(index)
                    except FrameError as error:
                        problems[index] = str(error)
        numbers = self.test.reader.numbers
        self.bad = frozenset(numbers[index] for index in problems)
        if self.bad:
            self.note(_left_out(self.bad))
        for build, theirs in self.request.left_out:
            self.note(_left_out(theirs, f", as in {build}"))
        out = self.bad.union(*(theirs for _, theirs in self.request.left_out))
        return [index for index in there if numbers[index] not in out]

    def _times(self) -> list[int]:
        """Indices at which all inputs have a frame: a video's time stamps may leave some out."""
        readers = [source.reader for source in (self.test, self.reference, self.mask) if source is not None]
        gaps: frozenset[int] = frozenset().union(*(reader.gaps for reader in readers))
        count = len(self.test.reader.numbers)
        if gaps:
            self.note(
                f"frames are shown at uneven times: {count - len(gaps)} of {count} times at {self.fps:g} frames a "
                "second have one; the motion is that of such a time"
            )
        return [index for index in range(count) if index not in gaps]

    def _match(self, reader: Reader, what: str, *, still: bool = False) -> None:
        """Raise FrameError where an input has another size or number of frames than the test."""
        test = self.test.reader
        if reader.header.size != test.header.size:
            mine, other = ("{}x{} px".format(*each.header.size) for each in (test, reader))
            raise FrameError(f"{test.name}: is {mine}, the {what} {reader.name} {other}; they must match")
        self._match_count(reader, what, still=still)

    def _match_count(self, reader: Reader, what: str, *, still: bool = False) -> None:
        """Raise FrameError where an input has another number of frames than the test."""
        test = self.test.reader
        if still and len(reader.numbers) == 1:
            return
        count, times = len(reader.numbers), len(test.numbers)
        if count != times:
            has = f"--{what} {reader.name}: has {counted(count, 'frame')} ({frame_range(reader.numbers)}), the test "
            if test.gaps and count == times - len(test.gaps):
                raise FrameError(
                    f"{has}as many, at uneven times, which number them to {test.numbers[-1]}: give one a time, those "
                    "without a frame too, or write the test at a constant rate"
                )
            shared = sorted({*reader.numbers} & {*test.numbers})
            mend = f": measure those that both have with --frames {frame_range(shared)}" if len(shared) > 1 else ""
            raise FrameError(f"{has}{times} ({frame_range(test.numbers)}); they must match{mend}")
        if reader.numbers != test.numbers:
            self.note(
                f"{what} frames {frame_range(reader.numbers)} go with test frames {frame_range(test.numbers)}, in order"
            )

    def _tell_of_files(self) -> None:
        """Say what files do to their frames. Raises FrameError where that leaves a request without meaning."""
        for source in filter(None, (self.test, self.reference)):
            header, name = source.reader.header, source.reader.name
            if header.compression in LOSSY:
                self.note(f"{name}: {header.compression} compression is lossy and itself makes flicker")
            if header.oblong and self.request.pixels_per_degree is not None:
                raise FrameError(
                    f"--pixels-per-degree: {name} has pixels {header.oblong}, so that no one number holds for both "
                    "directions; write its frames with square pixels"
                )
            if header.oblong:
                self.note(f"{name}: its pixels are {header.oblong}; lengths and frequencies are in its own px")

    def _beware(self, text: str) -> None:
        """Keep what may make the scores wrong, and warn of it."""
        self.notes.append(text)
        self.warnings.append(text)
        self._warn(text)

    def note(self, text: str) -> None:
        """Keep what a reader should know for the scores, and say it."""
        self.notes.append(text)
        self._say(text)
