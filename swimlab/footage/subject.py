"""What is measured: opened frames, where they are covered, and how they move."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from metrics import Clip
from swimlab.footage.check.grey import Frames
from swimlab.footage.check.jitter import estimate_jitter
from swimlab.footage.check.picture import write_region
from swimlab.footage.check.placing import misplaced
from swimlab.footage.check.repeats import every_nth, repeated_in, repeats_said
from swimlab.footage.check.still import verify_still
from swimlab.footage.check.verdict import Verification
from swimlab.footage.jitter import JitteredMotion
from swimlab.footage.motion import Motion, UniformMotion
from swimlab.footage.moving import open_motion
from swimlab.footage.opened import Opened
from swimlab.footage.pattern import frame_range
from swimlab.footage.reference import curve_between
from swimlab.footage.request import ESTIMATE, Request
from swimlab.footage.source import Look, Source, least
from swimlab.footage.verify import verify
from swimlab.runs.frames import FrameError, Image

PICTURE = "motion_check.png"


class Subject(Opened):
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
        super().__init__(request, say, warn)
        self.like = like if like is not None and self._moves_as(like) else self
        """The first build whose motion, coverage and reference are this one's."""
        self._misplaced = self._compare_places()
        """How the reference stands otherwise than the test, in words; empty where it does not."""
        if self.like is self:
            self._find_motion(pictures)
        else:
            self._take_motion(self.like)
        if self._misplaced:
            self._beware(self._misplaced)
        self._compare_curves()
        self._look_for_repeats()

    def _find_motion(self, pictures: Path | None) -> None:
        noted = len(self.notes)
        moving = open_motion(
            self.request, self.test, self.reference, self.kept, match=self._match_count, note=self.note, say=self._say
        )
        self.motion_kind, self.motion, self.motion_size, lacking = moving
        if self.request.motion_jitter == ESTIMATE:
            self.motion = self._without_estimated_jitter()
        self.checked = self._verify(pictures, lacking)
        """How well the motion fits the frames."""
        self._of_motion = self.notes[noted:]

    def _take_motion(self, other: "Subject") -> None:
        self.motion_kind, self.motion, self.motion_size = other.motion_kind, other.motion, other.motion_size
        self.checked = other.checked
        self.notes += other._of_motion
        self.warnings += [text for text in other.warnings if text in other._of_motion]

    def _moves_as(self, other: "Subject") -> bool:
        """Whether motion, coverage and reference are those of another build: no part of them is of the tests."""
        if self.reference is None or other.reference is None or self.test.has_coverage or other.test.has_coverage:
            return False
        mine, others = (replace(each.request, test="", look=Look(), left_out=()) for each in (self, other))
        return (
            mine == others
            and self.reference.reading == other.reference.reading
            and self.kept == other.kept
            and self.test.shape == other.test.shape
        )

    def clips(self) -> tuple[Clip, Clip | None]:
        """The test and the reference, of the frames that are kept."""
        reference = None if self.reference is None else self._clip(self.reference, moving=False)
        return self._clip(self.test, moving=True), reference

    def _clip(self, source: Source, *, moving: bool) -> Clip:
        kept, motion, depth = self.kept, self.motion, self.depth

        def moved(t: int) -> Image:
            if t == 0:
                return np.zeros((*source.shape, 2), np.float32)
            return motion.moved(kept[t], kept[t - 1])

        whole = self.kept == list(range(self.kept[0], self.kept[-1] + 1))
        uniform = motion.step(kept) if isinstance(motion, UniformMotion) and whole else None
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

    def _coverage(self) -> Callable[[int], Image] | None:
        """Where frames are measured: that, and where their motion is known."""
        stated = self._stated_coverage()
        known = self.motion.known(self.kept[1], self.kept[0]) is not None
        return least([*filter(None, [stated]), *([self._known] if known else [])])

    def _compare_places(self) -> str:
        if self.reference is None:
            return ""
        return misplaced(self.test.picture, self.reference.picture, self._stated_coverage(), self.kept)

    def _compare_curves(self) -> None:
        """Warn where test and reference differ by a transfer curve."""
        if self.reference is not None:
            index, coverage = self.kept[len(self.kept) // 2], self._coverage()
            text = curve_between(self.test, self.reference, index, None if coverage is None else coverage(index))
            if text:
                self._beware(text)

    def _look_for_repeats(self) -> None:
        """Warn of frames that the test shows again, and the reference, whose own are known by now, does not."""
        if self.reference is None:
            return
        found = repeated_in(Frames(self.test.picture, self._coverage(), self.kept), self.kept, self.motion)
        repeated = [index for index in found if index not in self.checked.repeated]
        if repeated:
            numbers = self.test.reader.numbers
            new = frame_range([numbers[index] for index in self.kept if index not in repeated])
            said = repeats_said(repeated, every_nth(repeated, self.kept), numbers.__getitem__, of=" of the test")
            self._beware(
                f"{said}, while the reference moves on: what it lags behind is measured as error and flicker; give "
                f"each frame once, or measure the new ones with --frames {new}"
            )

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

    def _verify(self, pictures: Path | None, lacking: str) -> Verification:
        """Hold the motion against the frames. Raises FrameError where it is wrong, unless that is asked for.

        lacking: what may be why.
        """
        source, clean = self.reference or self.test, self.reference is not None
        coverage, numbers = self._coverage(), self.test.reader.numbers
        if self.motion_kind in ("uniform", "fields"):
            found = verify(self.motion, source.picture, coverage, self.kept, clean=clean, numbers=numbers)
        else:
            given = self.motion_kind == "none"
            found = verify_still(source.picture, coverage, self.kept, clean=clean, given=given, numbers=numbers)
        if found.error and lacking:
            found = replace(found, error=f"{found.error}; but {lacking}")
        if pictures is not None and found.region is not None:
            path = pictures / PICTURE
            write_region(path, source.picture(self.kept[len(self.kept) // 2]), found.region)
            self._say(f"{path}: where the motion does not fit")
        if not self.request.unverified:
            if found.error and self._misplaced:
                raise FrameError(
                    f"--reference {source.reader.name}: {self._misplaced}. The motion does not fit it either: mend the "
                    "reference first, or measure all the same with --motion-unverified"
                )
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
