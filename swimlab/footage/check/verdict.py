"""What was found of a motion, and how it is said."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from swimlab.footage.check.regions import Region
from swimlab.footage.check.repeats import repeats_said
from swimlab.footage.pattern import frame_range
from swimlab.runs.frames import FrameError

Verdict = Literal["verified", "partly", "wrong", "unchecked"]


@dataclass(frozen=True)
class Verification:
    """residuals: reading -> 0..1 and more; empty where nothing could be compared.

    error: why the motion is refused, and how to mend it. doubt: why it is neither refused nor verified. note: what else
    to say. scale: by which x and y are to be multiplied; None where that cannot be told. residual: rms that the motion
    leaves between neighbouring frames at the median, over that of unrelated pictures. frames: indices of those whose
    vectors do not fit. region: where the motion does not fit all along. jitter: px rms. cuts: indices of frames that
    begin a new shot. repeated: of those that show the one before again.
    """

    residuals: dict[str, float] = field(default_factory=dict)
    error: str = ""
    doubt: str = ""
    note: str = ""
    verdict: Verdict = "unchecked"
    scale: tuple[float | None, float | None] = (None, None)
    residual: float | None = None
    frames: tuple[int, ...] = ()
    region: Region | None = None
    jitter: float = 0.0
    cuts: tuple[int, ...] = ()
    repeated: tuple[int, ...] = ()

    def check(self) -> None:
        """Raise FrameError where the motion does not fit the frames."""
        if self.error:
            raise FrameError(f"--motion: {self.error}, or measure all the same with --motion-unverified")

    def entry(self, number: Callable[[int], int]) -> dict[str, Any]:
        """What scores.json holds of it. number: of a frame, by its index.

        unfit: blocks that do not fit as 1, a text a row; only where there are any.
        """
        return {
            "verdict": self.verdict,
            "scale": list(self.scale),
            "residual": self.residual,
            "frames": [number(index) for index in self.frames],
            "unfit_fraction": self.region.fraction if self.region else 0.0,
            **({"unfit": ["".join(map(str, row)) for row in self.region.blocks.astype(int)]} if self.region else {}),
            "jitter": self.jitter,
            "cuts": [number(index) for index in self.cuts],
            "repeated": [number(index) for index in self.repeated],
        }


def events_said(cuts: list[int], repeated: list[int], nth: int, number: Callable[[int], int]) -> str:
    """Cuts and repeated frames in words; empty without any. nth: every nth frame is repeated, 0: without order."""
    said = []
    if repeated:
        said.append(f"{repeats_said(repeated, nth, number)}: the motion was checked over the frames between")
    if cuts:
        said.append(f"a new shot begins with frame {frame_range([number(index) for index in cuts])}")
    return "; ".join(said)


def jumps_said(jumps: list[int], number: Callable[[int], int]) -> str:
    """Jumps of the reference in words; empty without any."""
    if not jumps:
        return ""
    named = frame_range([number(index) for index in jumps])
    frames = f"frame{'s' if len(jumps) > 1 else ''} {named}"
    return f"the reference jumps with {frames}: it changes there by far more than the motion tells, as in a loop"


def region_said(region: Region) -> str:
    """A region in words."""
    left, top, right, bottom = region.box
    moves = "{:.2g},{:.2g} px a frame".format(*(round(float(part), 3) + 0.0 for part in region.shift))
    why = f"it has no vectors there, while the picture moves by {moves}" if region.zero else f"it lacks {moves} there"
    mend = "Write vectors there" if region.zero else "Mend the vectors there"
    where = f"x {left}-{right - 1}, y {top}-{bottom - 1} ({region.fraction:.0%} of what is seen)"
    return f"does not fit at {where}: {why}. {mend}, or leave the place out with --mask"
