"""What is measured: opened frames, which of them are good, where they are covered, and how they move."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from metrics import Clip
from metrics.display import STANDARD, Display, Domain
from swimlab.footage.channels import find_pair
from swimlab.footage.check.picture import write_region
from swimlab.footage.check.still import verify_still
from swimlab.footage.check.verdict import Verification
from swimlab.footage.convention import PRESETS, Convention
from swimlab.footage.header import LOSSY
from swimlab.footage.motion import EstimatedMotion, FieldMotion, Motion, UniformMotion
from swimlab.footage.pattern import frame_range, is_video
from swimlab.footage.reader import Reader, open_frames
from swimlab.footage.source import Look, Mask, Source
from swimlab.footage.verify import verify
from swimlab.runs.frames import FrameError, Image

ESTIMATE = "estimate"
FPS = 60.0
PICTURE = "motion_check.png"

_VECTOR = re.compile(r"\s*([-+.\deE]+)\s*,\s*([-+.\deE]+)\s*")
_SAMPLED = 3


@dataclass(frozen=True, kw_only=True)
class Request:
    """What to measure, and how; names are patterns, folders or files.

    motion: "dx,dy" px a frame right and down, a name, "estimate", or None where nothing moves. fps: None: the file's
    own, else 60. mask: where to measure, one picture or one a frame. frames: range for names without one of their own.
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
    domain: Domain = "linear"
    display: Display = STANDARD
    skip_bad_frames: bool = False
    unverified: bool = False
    pixels_per_degree: float | None = None
    luminance: float | None = None


class Subject:
    """The opened inputs of a request: which frames are measured, and how they move."""

    def __init__(
        self,
        request: Request,
        say: Callable[[str], None],
        warn: Callable[[str], None],
        *,
        pictures: Path | None = None,
    ) -> None:
        """say, warn: called with what a reader of the scores should know, and with what may make them wrong.

        pictures: folder for a picture of where the motion does not fit, which is written before anything is raised.
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
        self.motion_kind, self.motion = self._open_motion()
        self.checked = self._verify(pictures)
        """How well the motion fits the frames."""

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
            cuts=tuple(kept.index(cut) for cut in self.checked.cuts),
        )

    def _coverage(self) -> Callable[[int], Image] | None:
        """Where frames are measured, by mask, test and reference."""
        givers = [each.coverage for each in (self.test, self.reference) if each and each.has_coverage]
        givers += [self.mask.coverage] if self.mask is not None else []
        if not givers:
            return None
        return lambda index: np.minimum.reduce([giver(index) for giver in givers])

    def _open_motion(self) -> tuple[str, Motion]:
        """What to call the motion, and the motion."""
        request = self.request
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

    def _open_fields(self, name: str) -> Motion:
        if is_video(name):
            raise FrameError(f"--motion {name}: a video holds no motion vectors; give EXR files")
        reader = open_frames(name, frames=self.request.frames)
        self._match(reader, "motion")
        convention = self.request.convention
        if convention == PRESETS["nuke"]:
            channels = {channel for part in reader.header.parts for channel in part.channels}
            if not any(channel.endswith("backward.u") for channel in channels):
                convention = PRESETS["nuke-forward"]
        part, channels_found = find_pair(reader.header, convention.channels, reader.name)
        self._say(
            f"motion from {','.join(channels_found)}: {convention.unit}, {convention.direction}, +y {convention.y}, "
            f"scale {convention.scale[0]:g},{convention.scale[1]:g}"
        )
        problems = reader.problems(part, channels_found)
        needed = range(self.kept[0], self.kept[-1] + 1)
        needed = needed[1:] if convention.direction == "backward" else needed[:-1]
        for index in needed:
            if index in problems:
                raise FrameError(f"{problems[index]} (motion vectors of skipped frames are needed too)")
        return FieldMotion(reader, part, channels_found, convention, self.request.look.crop)

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
            self.notes.append(f"motion not verified: {text}")
            self._warn(self.notes[-1])
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
