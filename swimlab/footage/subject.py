"""What is measured: opened frames, which of them are good, where they are covered, and how they move."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from metrics import Clip
from swimlab.footage.check.jitter import estimate_jitter
from swimlab.footage.check.picture import write_region
from swimlab.footage.check.still import verify_still
from swimlab.footage.check.verdict import Verification
from swimlab.footage.depth import Depth
from swimlab.footage.header import LOSSY
from swimlab.footage.jitter import JitteredMotion
from swimlab.footage.motion import Motion, UniformMotion
from swimlab.footage.moving import open_motion
from swimlab.footage.pattern import frame_range
from swimlab.footage.reader import Reader, open_frames
from swimlab.footage.reference import check_alpha, curve_between, open_reference, passed_over
from swimlab.footage.request import ESTIMATE, Request
from swimlab.footage.source import Look, Mask, Source, least
from swimlab.footage.verify import verify
from swimlab.runs.frames import FrameError, Image

FPS = 60.0
PICTURE = "motion_check.png"

_SAMPLED = 3


def _to_nobody(_: str) -> None:
    """Say nothing."""


class Subject:
    """The opened inputs of a request: which frames are measured, and how they move.

    It can be pickled, for others to measure some of its frames: what was found once is not found again.
    """

    def __init__(
        self,
        request: Request,
        say: Callable[[str], None],
        warn: Callable[[str], None],
        *,
        pictures: Path | None = None,
        like: "Subject | None" = None,
    ) -> None:
        """say, warn: called with what a reader of the scores should know, and with what may make them wrong.

        like: another build of the same shot, of the same reference, motion and mask: what is known of it is not found
        again.
        pictures: folder for a picture of where the motion does not fit, which is written before anything is raised.
        Raises FrameError where inputs do not fit together, a frame is bad or the motion does not fit the frames.
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
        self.kept = self._good_frames()
        if len(self.kept) < 2:
            raise FrameError(f"{request.test}: has {len(self.kept)} frame to measure; change in time needs at least 2")
        self._check_measured()
        self.like = like if like is not None and self._moves_as(like) else self
        """The first build whose motion, coverage and reference are this one's."""
        if self.like is self:
            self._find_motion(pictures)
        else:
            self._take_motion(self.like)
        self._compare_curves()

    def _find_motion(self, pictures: Path | None) -> None:
        noted = len(self.notes)
        moving = open_motion(
            self.request, self.test, self.reference, self.kept, match=self._match_count, note=self.note, say=self._say
        )
        self.motion_kind, self.motion, self.motion_size = moving
        if self.request.motion_jitter == ESTIMATE:
            self.motion = self._without_estimated_jitter()
        self.checked = self._verify(pictures)
        """How well the motion fits the frames."""
        self._of_motion = self.notes[noted:]

    def _take_motion(self, other: "Subject") -> None:
        self.motion_kind, self.motion, self.motion_size = other.motion_kind, other.motion, other.motion_size
        self.checked = other.checked
        self.notes += other._of_motion

    def _moves_as(self, other: "Subject") -> bool:
        """Whether motion, coverage and reference are those of another build: no part of them is of the tests."""
        if self.reference is None or other.reference is None or self.test.has_coverage or other.test.has_coverage:
            return False
        mine, others = (replace(each.request, test="", look=Look()) for each in (self, other))
        return (
            mine == others
            and self.reference.reading == other.reference.reading
            and self.kept == other.kept
            and self.test.shape == other.test.shape
        )

    def __getstate__(self) -> dict[str, Any]:
        """All but whom it speaks to."""
        return vars(self) | {"_say": _to_nobody, "_warn": _to_nobody}

    def clips(self) -> tuple[Clip, Clip | None]:
        """The test and the reference, of the frames that are kept."""
        reference = None if self.reference is None else self._clip(self.reference, moving=False)
        return self._clip(self.test, moving=True), reference

    def sampled(self) -> list[int]:
        """A few of the frames, spread over the clip."""
        chosen = np.linspace(0, len(self.kept) - 1, _SAMPLED).round().astype(int)
        return sorted({self.kept[index] for index in chosen})

    @property
    def fps(self) -> float:
        """Frames a second: as given, else the file's own, else 60."""
        return self.request.fps or self.test.reader.header.fps or FPS

    def _clip(self, source: Source, *, moving: bool) -> Clip:
        kept, motion, depth = self.kept, self.motion, self.depth

        def moved(t: int) -> Image:
            if t == 0:
                return np.zeros((*source.shape, 2), np.float32)
            return motion.moved(kept[t], kept[t - 1])

        whole = self.kept == list(range(self.kept[0], self.kept[-1] + 1))
        uniform = motion.velocity if isinstance(motion, UniformMotion) and whole else None
        coverage = self._coverage()
        return Clip(
            frame=lambda t: source.picture(kept[t]),
            count=len(kept),
            fps=self.fps,
            motion=(uniform or moved) if moving else (0.0, 0.0),
            coverage=None if coverage is None else lambda t: coverage(kept[t]),
            depth=None if depth is None else lambda t: depth.distance(kept[t]),
            pixels_per_degree=self.request.pixels_per_degree,
            luminance=self.request.luminance,
            cuts=tuple(kept.index(cut) for cut in self.checked.cuts),
        )

    def _stated_coverage(self) -> Callable[[int], Image] | None:
        """Where frames are measured, by mask, test and reference."""
        givers = [each.coverage for each in (self.test, self.reference) if each and each.has_coverage]
        givers += [self.mask.coverage] if self.mask is not None else []
        return least(givers)

    def _coverage(self) -> Callable[[int], Image] | None:
        """Where frames are measured: that, and where their motion is known."""
        stated = self._stated_coverage()
        known = self.motion.known(self.kept[1], self.kept[0]) is not None
        return least([*filter(None, [stated]), *([self._known] if known else [])])

    def _check_measured(self) -> None:
        """Raise FrameError where mask and alpha leave nothing to measure."""
        coverage = self._stated_coverage()
        if coverage is not None and not any(coverage(index).any() for index in self.sampled()):
            raise FrameError(
                f"{self.test.reader.name}: no pixel is to be measured: the mask is nowhere above 0.5 or the alpha "
                "nowhere 1; mend it, or leave out --mask and --alpha"
            )

    def _compare_curves(self) -> None:
        """Warn where test and reference differ by a transfer curve."""
        if self.reference is not None:
            index, coverage = self.kept[len(self.kept) // 2], self._coverage()
            text = curve_between(self.test, self.reference, index, None if coverage is None else coverage(index))
            if text:
                self._beware(text)

    def _known(self, index: int) -> Image:
        """[H, W], 1 where it is known how a kept frame's surface moved since the kept one before, else 0."""
        place = self.kept.index(index)
        known = self.motion.known(index, self.kept[place - 1]) if place else None
        return np.ones(self.test.shape, np.float32) if known is None else known.astype(np.float32)

    def _without_estimated_jitter(self) -> Motion:
        """The motion, with the jitter taken out, or put in, that the frames tell of."""
        picture, count = (self.reference or self.test).picture, len(self.test.reader.numbers)
        excess = estimate_jitter(self.motion, picture, self._coverage(), self.kept, count)
        rms = float(np.sqrt(np.square(excess).mean()))
        self.note(
            f"jitter of {rms:.2g} px rms is estimated from the frames; with it goes all that shifts the whole picture, "
            "flicker and swimming among it"
        )
        side = self.request.motion_jitter_in
        return JitteredMotion(self.motion, excess if side == "vectors" else -excess, side)

    def _verify(self, pictures: Path | None) -> Verification:
        """Hold the motion against the frames. Raises FrameError where it is wrong, unless that is asked for."""
        source, clean = self.reference or self.test, self.reference is not None
        coverage, numbers = self._coverage(), self.test.reader.numbers
        if self.motion_kind in ("uniform", "fields"):
            found = verify(self.motion, source.picture, coverage, self.kept, clean=clean, numbers=numbers)
        else:
            given = self.motion_kind == "none"
            found = verify_still(source.picture, coverage, self.kept, clean=clean, given=given, numbers=numbers)
        if pictures is not None and found.region is not None:
            path = pictures / PICTURE
            write_region(path, source.picture(self.kept[len(self.kept) // 2]), found.region)
            self._say(f"{path}: where the motion does not fit")
        if not self.request.unverified:
            found.check()
        if found.note:
            self.note(found.note)
        for text in filter(None, (found.error, found.doubt)):
            self._beware(f"motion not verified: {text}")
        if clean and found.verdict in ("partly", "wrong"):
            self.note(
                "residual.flicker.reference is what the motion makes of the reference, whose flicker is its fault"
            )
        return found

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
        skipped = [self.test.reader.numbers[index] for index in sorted(problems)]
        if skipped:
            self.note(f"{len(skipped)} bad frames are left out: {frame_range(skipped)}")
        return [index for index in there if index not in problems]

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
            has = f"--{what} {reader.name}: has {count} frames ({frame_range(reader.numbers)}), the test "
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
