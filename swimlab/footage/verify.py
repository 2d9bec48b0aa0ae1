"""Motion verified by warping: the right reading of the vectors brings an earlier frame onto a later one.

For a few pairs of frames the later one is compared with the earlier one taken from where the motion says; so for every
other sign, direction, unit and length, and for no motion at all. Residuals are rms differences, but for the tenth of
the points that differ most, since what comes into view was nowhere before; over those of points paired at random: 0 for
a perfect match, 1 for pictures that have nothing to do with each other. Frames of which no reading explains much may be
noise, or a pattern that swims, which is what there is to measure: then the motion is refused only where it is a
reference that optical flow explains far better, since references follow their surface.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from swimlab.footage.motion import EstimatedMotion, Motion, Points
from swimlab.footage.warping import GIVEN, IDENTITY, WHOLE, Pair, Rival, grid, residuals_of
from swimlab.runs.frames import FrameError, Image

FLOWING = "optical flow"

CLEAR = 0.8
"""A reading wins clearly where its residual is under this share of the given one's: two thirds of the energy."""

LOW = 0.3
"""Residual up to which motion is verified: it explains nine tenths of the energy."""
POOR = 0.5
"""Residual from which on motion does not explain the frames, unless they are noise: noise makes this residual where its
rms is 0.58 of the picture's own. A reading that leaves more refuses no other: smooth noise may look the same by
chance."""
FLOW = 0.3
"""Optical flow explains frames that the motion does not where it leaves less than this share. It fits noise to noise
too: of white noise it leaves 0.9, of smooth noise 0.4 to 0.7."""

TRAVEL = 1.5
"""Frames are compared so far apart that a quarter of the covered points travels this far, px: the rest may be sky."""
APART = 16
"""... but no more frames apart than this."""
LEAST = 0.2
"""Less travel than this cannot be distinguished from none, px."""

_PAIRS = 3
_ALIKE = 0.01
"""Residuals nearer to each other than this count as equal."""
_PACED = 2_000
"""Points that say how fast a reading is."""
_MOVING = 0.75


@dataclass(frozen=True)
class Verification:
    """residuals: reading -> 0..1 and more; empty where nothing could be compared.

    error: why the motion is refused, and how to mend it. doubt: why it is neither refused nor verified. note: what else
    to say.
    """

    residuals: dict[str, float] = field(default_factory=dict)
    error: str = ""
    doubt: str = ""
    note: str = ""

    def check(self) -> None:
        """Raise FrameError where the motion does not fit the frames."""
        if self.error:
            raise FrameError(f"--motion: {self.error}, or measure all the same with --motion-unverified")


@dataclass(frozen=True)
class _Pace:
    """How far a quarter of the covered points travels at least, px: in one frame, and in so many frames apart."""

    apart: int
    step: float
    travel: float


def verify(
    motion: Motion,
    picture: Callable[[int], Image],
    coverage: Callable[[int], Image] | None,
    frames: list[int],
    *,
    clean: bool = False,
) -> Verification:
    """Compare frames under every reading of the motion, each so far apart that it moves far enough.

    picture: index -> [H, W, 3] radiance, of the reference where there is one. coverage: index -> [H, W], compared where
    it is 1. frames: the indices that are measured, in order. clean: pictures follow their surface, as references do.
    """
    shape = picture(frames[0]).shape[:2]
    variants = motion.variants()
    readings = {GIVEN: motion} | {name: other for name, (_, other) in variants.items()}
    points = _covered(shape, coverage, frames[len(frames) // 2])
    paces = _paces(readings, points, frames)
    sane = {name: pace for name, pace in paces.items() if pace.step <= max(shape)}
    apart = paces[GIVEN].apart
    rivals: dict[str, Rival] = {}
    moving = [name for name, pace in sane.items() if pace.travel >= LEAST]
    for distance in sorted({sane[name].apart for name in moving} | {apart}, key=lambda distance: distance != apart):
        own = distance == apart
        chosen = [name for name in moving if own or sane[name].apart == distance]
        compared = {name: readings[name] for name in (GIVEN, *chosen) if name in sane}
        pairs = [Pair(picture, coverage, *ends) for ends in _ends(frames, distance, _PAIRS if own else 1)]
        for name, rival in residuals_of(compared, pairs).items():
            # The given reading, and none, count over the given one's distance, others where they do best against it.
            if name not in rivals or (name not in (GIVEN, IDENTITY) and rival.ratio < rivals[name].ratio):
                rivals[name] = rival
    settings = {name: setting for name, (setting, _) in variants.items()}
    refused = _find_error(rivals, settings, paces[GIVEN], shape)
    residuals = {name: rival.residual for name, rival in rivals.items()}
    if refused:
        return Verification(residuals, error=refused)
    if GIVEN not in rivals:
        return Verification(residuals, doubt="the picture is flat, or leaves the frame under this motion")
    given = residuals[GIVEN]
    if given > POOR:
        return _judge_poor(residuals, _against_flow(motion, picture, coverage, frames), clean=clean)
    if paces[GIVEN].travel < LEAST:
        short = f"the picture travels by {paces[GIVEN].travel:.2g} px in {apart} frames only"
        return Verification(residuals, note=f"motion not verified: {short}, while {given:.3f} of it changes")
    named = ", ".join(f"{name} {residuals[name]:.3f}" for name in _worth_naming(residuals))
    low = given <= LOW and given <= CLEAR * residuals[IDENTITY]
    how = "verified by warping" if low else "explains the frames in part (they flicker, or its scale is off)"
    return Verification(residuals, note=f"motion {how}, residuals: {named}")


def _find_error(rivals: dict[str, Rival], settings: dict[str, str], pace: _Pace, shape: tuple[int, ...]) -> str:
    """What to say where another reading or none fits clearly better, or the given one is beyond belief; else empty."""
    winners = [name for name, rival in rivals.items() if rival.ratio < CLEAR and rival.residual <= POOR]
    least = min((rivals[name].residual for name in winners), default=0.0)
    # Of readings that fit equally well, as directions do where the motion is steady, the one that changes least.
    best = next(
        (name for name in [*settings, IDENTITY] if name in winners and rivals[name].residual < least + _ALIKE), ""
    )
    named = "no motion at all" if best == IDENTITY else best
    found = f"{named} leaves {rivals[best].residual:.3f} of the change between frames" if best else ""
    if pace.step > max(shape):
        mend = "check --motion-convention, --motion-unit and --motion-scale"
        mend = f"{found}. Use {settings[best]}" if best in settings else mend
        size = f"{shape[1]}x{shape[0]} px"
        return f"moves {pace.step:.0f} px a frame in a picture of {size}: is its unit right? {mend}"
    if not best:
        return ""
    rest = f", the motion as given {rivals[best].given:.3f}" if GIVEN in rivals else ""
    mend = f"Use {settings[best]}" if best in settings else "Check its channels, unit and scale"
    return f"does not fit the frames: {found}{rest}. {mend}"


def _against_flow(
    motion: Motion, picture: Callable[[int], Image], coverage: Callable[[int], Image] | None, frames: list[int]
) -> dict[str, Rival]:
    """The residual of optical flow from one frame to the next; none where every other one is left out."""
    neighbours = [(late, early) for early, late in pairwise(frames) if late == early + 1]
    if not neighbours:
        return {}
    pair = Pair(picture, coverage, *neighbours[len(neighbours) // 2])
    return residuals_of({GIVEN: motion, FLOWING: EstimatedMotion(picture)}, [pair])


def _judge_poor(residuals: dict[str, float], flow: dict[str, Rival], *, clean: bool) -> Verification:
    """Refuse motion that explains little of a reference, where there is motion that does; else doubt it."""
    left = f"leaves {residuals[GIVEN]:.3f} of the change between frames"
    if FLOWING not in flow or flow[FLOWING].ratio >= FLOW:
        best = min(residuals, key=lambda name: residuals[name])
        least = f"(least: {best} {residuals[best]:.3f})"
        return Verification(
            residuals, doubt=f"it {left}, as all readings do {least}: the frames flicker much, or it is wrong"
        )
    found = f"{left}, while optical flow finds a motion that leaves {flow[FLOWING].residual:.3f}"
    if clean:
        return Verification(residuals, error=f"does not fit the frames: it {found}. Check its channels, unit and scale")
    return Verification(residuals, doubt=f"it {found}: the pattern swims, or the motion is wrong")


def _worth_naming(residuals: dict[str, float]) -> list[str]:
    """The given reading, none, and the best of the others."""
    named = [GIVEN, *({IDENTITY} & residuals.keys())]
    others = residuals.keys() - named
    return [*named, min(others, key=lambda name: residuals[name])] if others else named


def _ends(frames: list[int], apart: int, count: int) -> list[tuple[int, int]]:
    """Later and earlier frames, spread over the clip, or in its middle."""
    last = len(frames) - 1
    ends = {apart, (apart + last) // 2, last} if count > 1 else {(apart + last) // 2}
    return [(frames[end], frames[end - apart]) for end in sorted(ends)]


def _paces(readings: dict[str, Motion], points: Points, frames: list[int]) -> dict[str, _Pace]:
    """How far each reading goes, until it goes far enough; frame by frame, so that files are read once for all."""
    end = len(frames) // 2
    paces: dict[str, _Pace] = {}
    places = dict.fromkeys(readings, points)
    for apart in range(1, min(APART, end) + 1):
        late, early = frames[end - apart + 1], frames[end - apart]
        for name in [name for name in readings if name not in paces or paces[name].travel < TRAVEL]:
            places[name] = readings[name].back(places[name], late, early)
            travel = float(np.quantile(np.hypot(*(places[name] - points)), _MOVING))
            paces[name] = _Pace(apart, paces[name].step if name in paces else travel, travel)
    return paces


def _covered(shape: tuple[int, ...], coverage: Callable[[int], Image] | None, frame: int) -> Points:
    """A few points, of the covered ones if there are any."""
    points = grid(shape, _PACED)
    if coverage is not None:
        covered = coverage(frame)[tuple(points.astype(np.intp))] >= WHOLE
        points = points[:, covered] if covered.any() else points
    return points
