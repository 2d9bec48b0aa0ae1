"""Motion verified by warping: the right motion brings every frame onto the next, and stays right over many frames.

First what happens in the clip: frames shown twice, cuts, frames whose vectors are wrong, jitter in all of them. Then
the longest run without any is taken: the factors that fit over as long a baseline as the surface stays in view, and all
other readings of the same numbers. Last the regions. Motion is wrong where what it leaves is explained by another
motion; what no motion explains is flicker, which is what there is to measure. A pattern that swims is explained by its
own motion, though: where most of the change between frames is unexplained, motion is refused only for a reference,
since references follow their surface.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from swimlab.footage.check import factor
from swimlab.footage.check.baseline import Scale, fit_scale
from swimlab.footage.check.events import find_cuts, find_jumps, find_strays
from swimlab.footage.check.grey import Frames
from swimlab.footage.check.lucas_kanade import Values
from swimlab.footage.check.misfit import frames_said, jitter_of, misfit_of, most_said
from swimlab.footage.check.pairs import PairFit, fit_pairs
from swimlab.footage.check.regions import find_region
from swimlab.footage.check.repeats import every_nth, repeated_frames
from swimlab.footage.check.verdict import Verification, events_said, jumps_said, region_said
from swimlab.footage.check.weighing import CLEAR, LEAST, POOR, Weighing, against_flow, weigh
from swimlab.footage.motion import Motion
from swimlab.footage.warping import GIVEN, IDENTITY
from swimlab.runs.frames import Image

FLOW = 0.3
"""Optical flow explains frames that the motion does not where it leaves less than this share. It fits noise to noise
too: of white noise it leaves 0.9, of smooth noise 0.4 to 0.7."""

WHOLE_REGION = 0.5
"""A region of more than this share of the picture is wrong motion."""
ZERO_REGION = 0.05
"""... as is one without vectors, where the rest moves, of more than this."""
SLIGHT = 0.1
"""Frames whose vectors are off by less than this do not refuse the motion, px."""
_STEADY = 0.5
"""Vectors whose mean is under this share of their rms shake: they may be jitter and nothing else."""
_EVEN = 0.1
"""The picture moves as far in every pair if the deviation is less than this share of the mean."""
_AS_GOOD = 1.2
"""A reading explains jitter if it leaves this many times what shifts of each frame leave at most."""


def verify(
    motion: Motion,
    picture: Callable[[int], Image],
    coverage: Callable[[int], Image] | None,
    frames: list[int],
    *,
    clean: bool = False,
    numbers: Sequence[int] | None = None,
) -> Verification:
    """Hold a motion against frames.

    picture: index -> [H, W, 3] radiance, of the reference where there is one. coverage: index -> [H, W], compared where
    it is 1. frames: the indices that are measured, in order. clean: pictures follow their surface, as references do.
    numbers: of all frames, by index, as in the names of their files.
    """

    def number(index: int) -> int:
        return index if numbers is None else numbers[index]

    grey = Frames(picture, coverage, frames)
    pairs = fit_pairs(motion, grey, frames)
    repeated = repeated_frames(pairs)
    shown = [index for index in frames if index not in set(repeated)]
    if repeated:
        pairs = fit_pairs(motion, grey, shown)
    cuts = find_cuts(pairs, grey)
    pairs = [pair for pair in pairs if pair.late not in cuts]
    strays = find_strays(pairs, grey)
    misfit = misfit_of(strays, pairs)
    astray = [stray.late for stray in strays] if misfit == "frames" else []
    run = _longest_run(shown, {*cuts, *astray})
    if len(run) < 2:
        said = events_said(cuts, repeated, 0, number)
        return _doubt(Verification(cuts=tuple(cuts), repeated=tuple(repeated)), "no two frames belong together", said)
    scale = fit_scale(motion, grey, run)
    others = factor.fitted(motion, scale)
    others |= factor.per_new_frame(motion, len(shown) / len(frames)) if repeated else {}
    weighing = weigh(motion, picture, coverage, run, others)
    found = Verification(
        residuals=weighing.residuals,
        residual=float(np.median([pair.given for pair in pairs])) if pairs else None,
        scale=factor.told(scale),
        frames=tuple(astray),
        jitter=jitter_of(pairs) if misfit == "jitter" else 0.0,
        cuts=tuple(cuts),
        repeated=tuple(repeated),
    )
    jumps = [index for index in find_jumps(pairs) if index not in astray] if clean else []
    said = "; ".join(
        filter(None, (events_said(cuts, repeated, every_nth(repeated, frames), number), jumps_said(jumps, number)))
    )
    refused = weighing.error()
    if refused and not (found.jitter and _shakes(weighing, pairs)):
        return _refuse(found, refused, said)
    if found.jitter and repeated and _steps_evenly(pairs):
        step = "{:.2g},{:.2g}".format(*(np.median(_moved(pairs), axis=0).round(3) + 0.0))
        text = f"{said}; the picture moves by {step} px with each new frame, however long the one before was shown"
        return _doubt(replace(found, verdict="partly", jitter=0.0), text, "")
    if found.jitter:
        text = (
            f"has a jitter of {found.jitter:.2g} px rms that the frames do not have, or the other way round: with each "
            f"frame shifted {np.median([pair.rigid for pair in pairs]):.3f} of the change between frames is left, as "
            f"given {found.residual:.3f}. Take it out with --motion-jitter FILE, or estimate"
        )
        return _refuse(found, text, said)
    if misfit == "most":
        return _refuse(found, most_said(strays, pairs), said)
    if strays:
        text = frames_said(strays, number)
        if max(stray.length for stray in strays) >= SLIGHT:
            return _refuse(found, text, said)
        return _doubt(replace(found, verdict="partly"), text, said)
    if GIVEN not in weighing.rivals:
        return _doubt(found, "the picture is flat, or leaves the frame under this motion", said)
    region = find_region(motion, grey, pairs)
    part = region is not None and region.fraction <= WHOLE_REGION
    if found.residuals[GIVEN] > POOR and not part:
        return _judge_poor(found, scale, motion, grey, run, said, clean=clean)
    if weighing.pace.travel < LEAST and region is None:
        short = f"the picture travels by {weighing.pace.travel:.2g} px in {weighing.pace.apart} frames only"
        note = f"motion not verified: {short}, while {found.residuals[GIVEN]:.3f} of it changes"
        return replace(found, note="; ".join(filter(None, (note, said))))
    return _judge_rest(replace(found, region=region), weighing, motion, scale, said)


def _judge_rest(
    found: Verification,
    weighing: Weighing,
    motion: Motion,
    scale: Scale | None,
    said: str,
) -> Verification:
    """Of motion that no other reading beats: its factors, regions, and the frames that are there twice."""
    fitted = factor.fitted(motion, scale)
    if scale is not None and fitted:
        setting = next(setting for setting, _ in fitted.values())
        text = f"is too short or long: {factor.said(scale)}, which explains {scale.explained:.0%} of what it leaves"
        if scale.explained > 1 - CLEAR**2:
            return _refuse(found, f"{text}. Use {setting}", said)
        return _doubt(replace(found, verdict="partly"), f"{text}; {setting} may fit better", said)
    region = found.region
    if region is not None:
        wrong = region.fraction > WHOLE_REGION or (region.zero and region.fraction > ZERO_REGION)
        if wrong:
            return _refuse(found, region_said(region), said)
        return _doubt(replace(found, verdict="partly"), region_said(region), said)
    parts = (f"residuals: {weighing.worth_naming()}", factor.said(scale) if scale else "", weighing.undecided())
    known = "; ".join(filter(None, parts))
    if found.repeated:
        return _doubt(replace(found, verdict="partly"), f"{said}; {known}", "")
    if not factor.known(scale):
        note = f"motion explains the frames in part (they flicker too much to tell its factor), {known}"
        return replace(found, verdict="partly", note="; ".join(filter(None, (note, said))))
    return replace(
        found, verdict="verified", note="; ".join(filter(None, (f"motion verified by warping, {known}", said)))
    )


def _judge_poor(
    found: Verification, scale: Scale | None, motion: Motion, grey: Frames, run: list[int], said: str, *, clean: bool
) -> Verification:
    """Refuse motion that explains little of a reference, where there is motion that does; else doubt it."""
    residuals = found.residuals
    left = f"leaves {residuals[GIVEN]:.3f} of the change between frames"
    flow = against_flow(motion, grey.picture, grey.coverage, run)
    if flow is None or flow.ratio >= FLOW:
        if factor.right(scale) and residuals[GIVEN] <= CLEAR * residuals[IDENTITY]:
            text = f"motion verified by warping, though the frames flicker much: it {left}; {factor.said(scale)}"
            return replace(found, verdict="verified", note="; ".join(filter(None, (text, said))))
        best = min(residuals, key=lambda name: residuals[name])
        least = f"(least: {best} {residuals[best]:.3f})"
        return _doubt(found, f"it {left}, as all readings do {least}: the frames flicker much, or it is wrong", said)
    other = f"{left}, while optical flow finds a motion that leaves {flow.residual:.3f}"
    if clean:
        return _refuse(found, f"does not fit the frames: it {other}. Check its channels, unit and scale", said)
    return _doubt(found, f"it {other}: the pattern swims, or the motion is wrong", said)


def _refuse(found: Verification, text: str, said: str) -> Verification:
    return replace(found, verdict="wrong", error="; ".join(filter(None, (said, text))))


def _doubt(found: Verification, text: str, said: str) -> Verification:
    return replace(found, doubt="; ".join(filter(None, (text, said))))


def _moved(pairs: list[PairFit]) -> Values:
    """[n, 2] (x, y) px that the picture moves in each pair."""
    return np.array([pair.travel + pair.shift for pair in pairs])


def _steps_evenly(pairs: list[PairFit]) -> bool:
    """Whether the picture moves as far in every pair, as film shown at a video's rate does."""
    moved = _moved(pairs)
    return bool(np.hypot(*moved.std(axis=0)) < _EVEN * np.hypot(*moved.mean(axis=0)))


def _shakes(weighing: Weighing, pairs: list[PairFit]) -> bool:
    """Whether a shift of each frame explains what another reading explains too, as jitter does by chance."""
    rigid = float(np.median([pair.rigid for pair in pairs]))
    if weighing.best == IDENTITY:
        travel = np.array([pair.travel for pair in pairs])
        return bool(np.hypot(*travel.mean(axis=0)) < _STEADY * np.sqrt((travel**2).sum(axis=1).mean()))
    return weighing.residuals[weighing.best] > _AS_GOOD * rigid + 1e-3 if weighing.best else True


def _longest_run(frames: list[int], breaks: set[int]) -> list[int]:
    """The most frames in a row of which none but the first is a break."""
    runs = [frames[:1]]
    for _, late in pairwise(frames):
        if late in breaks:
            runs.append([])
        runs[-1].append(late)
    return max(runs, key=len)
