"""What is measured: opened frames, which of them are good, where they are covered, and how they move."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from metrics import Clip
from metrics.display import STANDARD, Display, Domain
from swimlab.footage.convention import PRESETS, Convention
from swimlab.footage.fields import open_fields
from swimlab.footage.header import LOSSY
from swimlab.footage.jitter import Side, with_jitter_of_file
from swimlab.footage.motion import EstimatedMotion, Motion, UniformMotion
from swimlab.footage.pattern import frame_range, is_video
from swimlab.footage.reader import Reader, open_frames
from swimlab.footage.source import Look, Mask, Source
from swimlab.footage.verify import verify
from swimlab.runs.frames import FrameError, Image

ESTIMATE = "estimate"
FPS = 60.0

_VECTOR = re.compile(r"\s*([-+.\deE]+)\s*,\s*([-+.\deE]+)\s*")
_SAMPLED = 3


@dataclass(frozen=True, kw_only=True)
class Request:
    """What to measure, and how; names are patterns, folders or files.

    motion: "dx,dy" px a frame right and down, a name, "estimate", or None where nothing moves. fps: None: the file's
    own, else 60. mask: where to measure, one picture or one a frame; motion_mask: where the motion vectors are valid.
    motion_jitter: text file of the frames' jitter, which is in the vectors alone or in the frames alone, as
    motion_jitter_in says; px, of the vectors where there are any. frames: range for names without one of their own.
    skip_bad_frames: leave out what cannot be measured. unverified: measure though the motion does not fit the frames.
    """

    test: str
    reference: str | None = None
    motion: str | None = None
    mask: str | None = None
    fps: float | None = None
    frames: str | None = None
    look: Look = field(default_factory=Look)
    convention: Convention = PRESETS["own"]
    motion_mask: str | None = None
    motion_jitter: str | None = None
    motion_jitter_in: Side = "vectors"
    domain: Domain = "linear"
    display: Display = STANDARD
    skip_bad_frames: bool = False
    unverified: bool = False
    pixels_per_degree: float | None = None
    luminance: float | None = None


class Subject:
    """The opened inputs of a request: which frames are measured, and how they move."""

    def __init__(self, request: Request, say: Callable[[str], None], warn: Callable[[str], None]) -> None:
        """say, warn: called with what a reader of the scores should know, and with what may make them wrong.

        Raises FrameError where inputs do not fit together, a frame is bad or the motion does not fit the frames.
        """
        self.notes: list[str] = []
        self.request = request
        self._say = say
        self._warn = warn
        look = request.look
        self.test = Source(open_frames(request.test, frames=request.frames), look)
        self.reference = None
        if request.reference is not None:
            self.reference = Source(open_frames(request.reference, frames=request.frames), look)
            self._match(self.reference.reader, "reference")
        if look.alpha != "ignore" and not any(source and source.has_coverage for source in (self.test, self.reference)):
            raise FrameError(f"--alpha {look.alpha}: {self.test.reader.name} has no alpha")
        self.mask = None
        if request.mask is not None:
            self.mask = Mask(open_frames(request.mask, frames=request.frames), look.crop)
            self._match(self.mask.reader, "mask", still=True)
        self._warn_of_loss()
        self.kept = self._good_frames()
        if len(self.kept) < 2:
            raise FrameError(f"{request.test}: has {len(self.kept)} frame to measure; change in time needs at least 2")
        self.motion_size: list[int] | None = None
        """Width and height of the files of motion vectors, if there are any."""
        self.motion_kind, self.motion = self._open_motion()
        if request.motion_jitter is not None:
            side, numbers = request.motion_jitter_in, self.test.reader.numbers
            self.motion = with_jitter_of_file(self.motion, Path(request.motion_jitter), side, numbers, self.note)
        if not request.unverified:
            self._verify()

    def clips(self) -> tuple[Clip, Clip | None]:
        """The test and the reference, of the frames that are kept."""
        reference = None if self.reference is None else self._clip(self.reference, moving=False)
        return self._clip(self.test, moving=True), reference

    def sampled(self) -> list[int]:
        """A few of the frames, spread over the clip."""
        chosen = np.linspace(0, len(self.kept) - 1, _SAMPLED).round().astype(int)
        return sorted({self.kept[index] for index in chosen})

    @property
    def name(self) -> str:
        """What to call the sequence: the pattern's name without the place of its number, else the folder's."""
        path = Path(self.request.test)
        bare = re.sub(r"[-._]*(?:[-\d,x:]*-[-\d,x:]*)?(?:#+|%0?\d*d)", "", path.stem)
        return bare or path.absolute().parent.name or "frames"

    @property
    def fps(self) -> float:
        """Frames a second: as given, else the file's own, else 60."""
        return self.request.fps or self.test.reader.header.fps or FPS

    def _clip(self, source: Source, *, moving: bool) -> Clip:
        kept, motion = self.kept, self.motion

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
            pixels_per_degree=self.request.pixels_per_degree,
            luminance=self.request.luminance,
        )

    def _coverage(self) -> Callable[[int], Image] | None:
        """Where frames are measured, by mask, test and reference."""
        givers = [each.coverage for each in (self.test, self.reference) if each and each.has_coverage]
        givers += [self.mask.coverage] if self.mask is not None else []
        if self.motion.known(self.kept[1], self.kept[0]) is not None:
            givers.append(self._known)
        if not givers:
            return None
        return lambda index: np.minimum.reduce([giver(index) for giver in givers])

    def _known(self, index: int) -> Image:
        """[H, W], 1 where it is known how a kept frame's surface moved since the kept one before, else 0."""
        place = self.kept.index(index)
        known = self.motion.known(index, self.kept[place - 1]) if place else None
        return np.ones(self.test.shape, np.float32) if known is None else known.astype(np.float32)

    def _open_motion(self) -> tuple[str, Motion]:
        """What to call the motion, and the motion."""
        request = self.request
        self._refuse_parts_of_files()
        if request.motion is None:
            self.note(
                "no motion given: nothing is taken to move; if the camera moves, give --motion or --motion estimate"
            )
            return "none", UniformMotion((0.0, 0.0), self.test.shape)
        if request.motion == ESTIMATE:
            self.note("the motion is estimated from the frames, which hides part of their flicker and swimming")
            source = self.reference or self.test
            return "estimated", EstimatedMotion(source.picture)
        vector = _VECTOR.fullmatch(request.motion)
        if vector is not None:
            return "uniform", UniformMotion(_velocity(vector), self.test.shape)
        return "fields", self._open_fields(request.motion)

    def _refuse_parts_of_files(self) -> None:
        """Raise FrameError where options of motion vectors come with a motion that has none, or without one another."""
        motion, mask, jitter = self.request.motion, self.request.motion_mask, self.request.motion_jitter
        if motion in (None, ESTIMATE) and (mask or jitter):
            option = "--motion-mask" if mask else "--motion-jitter"
            raise FrameError(f"{option}: is for a motion that is given; give --motion, or leave it out")
        if jitter is None and self.request.motion_jitter_in != "vectors":
            raise FrameError("--motion-jitter-in: says whose jitter a file holds; give --motion-jitter FILE too")
        if motion is not None and mask and _VECTOR.fullmatch(motion):
            raise FrameError(f"--motion-mask {mask}: is for files of motion vectors, not for one vector; leave it out")

    def _open_fields(self, name: str) -> Motion:
        if is_video(name):
            raise FrameError(f"--motion {name}: a video holds no motion vectors; give EXR files")
        request = self.request
        reader = open_frames(name, frames=request.frames)
        self._match_count(reader, "motion")
        self.motion_size = list(reader.header.size)
        mask = None
        if request.motion_mask is not None:
            mask = Mask(open_frames(request.motion_mask, frames=request.frames), None)
            self._match_count(mask.reader, "motion-mask", still=True)
        return open_fields(
            reader,
            request.convention,
            size=self.test.reader.header.size,
            kept=self.kept,
            crop=request.look.crop,
            mask=mask,
            note=self.note,
            say=self._say,
        )

    def _verify(self) -> None:
        if self.motion_kind not in ("uniform", "fields"):
            return
        source = self.reference or self.test
        clean = self.reference is not None
        checked = verify(self.motion, source.picture, self._coverage(), self.kept, clean=clean)
        checked.check()
        if checked.note:
            self.note(checked.note)
        if checked.doubt:
            self.notes.append(f"motion not verified: {checked.doubt}")
            self._warn(self.notes[-1])

    def _good_frames(self) -> list[int]:
        """Indices of the frames to measure. Raises FrameError for the first bad one, unless bad ones are skipped."""
        problems: dict[int, str] = {}
        for source in (self.test, self.reference):
            problems = (source.problems() if source is not None else {}) | problems
        if self.mask is not None and len(self.mask.reader.numbers) > 1:
            problems |= self.mask.reader.problems(0, self.mask.reader.header.parts[0].channels[:1])
        count = len(self.test.reader.numbers)
        if not self.request.skip_bad_frames:
            if problems:
                raise FrameError(problems[min(problems)])
            return list(range(count))
        for index in range(count):
            for source in (self.test, self.reference):
                if source is not None and index not in problems:
                    try:
                        source.picture(index)
                    except FrameError as error:
                        problems[index] = str(error)
        skipped = [self.test.reader.numbers[index] for index in sorted(problems)]
        if skipped:
            self.note(f"{len(skipped)} bad frames are left out: {frame_range(skipped)}")
        return [index for index in range(count) if index not in problems]

    def _match(self, reader: Reader, what: str, *, still: bool = False) -> None:
        """Raise FrameError where an input has another size or number of frames than the test."""
        test = self.test.reader
        if reader.header.size != test.header.size:
            sizes = "{}x{} px, the test {}x{} px".format(*reader.header.size, *test.header.size)
            raise FrameError(f"--{what} {reader.name}: is {sizes}; they must match")
        self._match_count(reader, what, still=still)

    def _match_count(self, reader: Reader, what: str, *, still: bool = False) -> None:
        """Raise FrameError where an input has another number of frames than the test."""
        test = self.test.reader
        if still and len(reader.numbers) == 1:
            return
        if len(reader.numbers) != len(test.numbers):
            raise FrameError(
                f"--{what} {reader.name}: has {len(reader.numbers)} frames ({frame_range(reader.numbers)}), the test "
                f"{len(test.numbers)} ({frame_range(test.numbers)}); they must match"
            )
        if reader.numbers != test.numbers:
            self.note(
                f"{what} frames {frame_range(reader.numbers)} go with test frames {frame_range(test.numbers)}, in order"
            )

    def _warn_of_loss(self) -> None:
        for source in (self.test, self.reference):
            if source is not None and source.reader.header.compression in LOSSY:
                compression = source.reader.header.compression
                self.note(f"{source.reader.name}: {compression} compression is lossy and itself makes flicker")

    def note(self, text: str) -> None:
        """Keep what a reader should know for the scores, and say it."""
        self.notes.append(text)
        self._say(text)


def _velocity(vector: re.Match[str]) -> tuple[float, float]:
    try:
        x, y = float(vector[1]), float(vector[2])
    except ValueError as error:
        raise FrameError(f"--motion {vector[0]}: give dx,dy in px a frame, as 0.5,-0.25") from error
    return x, y
