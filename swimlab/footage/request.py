"""What is asked for: which frames to measure, and what they and their motion mean."""

import re
from dataclasses import dataclass, field
from pathlib import Path

from metrics.display import STANDARD, Display, Domain
from swimlab.footage.convention import PRESETS, Convention
from swimlab.footage.jitter import Side
from swimlab.footage.pattern import parse_pattern
from swimlab.footage.source import Look
from swimlab.runs.frames import FrameError

ESTIMATE = "estimate"
"""As a motion, or its jitter: found from the frames."""

_VECTOR = re.compile(r"\s*([-+.\deE]+)\s*,\s*([-+.\deE]+)\s*")

_NUMBERS = re.compile(r"\s*([-+]?(\d*\.?\d+|\d+\.|nan|inf)\s*,?\s*)+", re.IGNORECASE)
"""What is meant as a vector, and is none."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """What to measure, and how; names are patterns, folders or files.

    motion: "dx,dy" px a frame right and down, a name, "estimate", or None where nothing moves. fps: None: the file's
    own, else 60. mask: where to measure, one picture or one a frame; motion_mask: where the motion vectors are valid;
    both with their channel (None: the first) and part.
    motion_jitter: text file of the frames' jitter, px, of the vectors where there are any, or "estimate"; it is in the
    vectors alone or in the frames alone, as motion_jitter_in says. look: how the test is read, and the reference where
    neither reference_look nor its files say otherwise; its crop is of all. motion_part: of the files of vectors.
    depth: files of depth, m, with their channel (None: found) and part.
    frames: range for names without one of their own. skip_bad_frames: leave out what cannot be measured. left_out:
    other builds of the shot, each with the numbers of the frames that are bad in it and are left out here, too.
    unverified: measure though the motion does not fit the frames.
    """

    test: str
    reference: str | None = None
    motion: str | None = None
    mask: str | None = None
    mask_channels: str | None = None
    mask_part: str | None = None
    fps: float | None = None
    frames: str | None = None
    look: Look = field(default_factory=Look)
    reference_look: Look = field(default_factory=Look)
    motion_part: str | None = None
    depth: str | None = None
    depth_channels: str | None = None
    depth_part: str | None = None
    convention: Convention = PRESETS["own"]
    motion_mask: str | None = None
    motion_mask_channels: str | None = None
    motion_mask_part: str | None = None
    motion_jitter: str | None = None
    motion_jitter_in: Side = "vectors"
    domain: Domain = "linear"
    display: Display = STANDARD
    skip_bad_frames: bool = False
    left_out: tuple[tuple[str, tuple[int, ...]], ...] = ()
    unverified: bool = False
    pixels_per_degree: float | None = None
    luminance: float | None = None

    @property
    def name(self) -> str:
        """What to call the sequence: the pattern's name without the place of its number, else the folder's."""
        path = Path(self.test)
        pattern = parse_pattern(path)
        bare = path.stem if pattern is None else pattern.before.rstrip("-._") + Path(f"_{pattern.after}").stem[1:]
        return bare or path.absolute().parent.name or "frames"

    @property
    def velocity(self) -> tuple[float, float] | None:
        """The motion as px a frame, where it is one vector for all. Raises FrameError where that cannot be read."""
        vector = None if self.motion is None else _VECTOR.fullmatch(self.motion)
        if vector is None:
            if self.motion is not None and _NUMBERS.fullmatch(self.motion) and not Path(self.motion).exists():
                raise FrameError(f"--motion {self.motion}: give dx,dy in px a frame, as 0.5,-0.25, or name files")
            return None
        try:
            return float(vector[1]), float(vector[2])
        except ValueError as error:
            raise FrameError(f"--motion {vector[0]}: give dx,dy in px a frame, as 0.5,-0.25") from error
