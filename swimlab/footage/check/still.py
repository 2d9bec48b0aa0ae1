"""Frames without a motion: whether their content moves all the same."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from swimlab.footage.check.events import find_cuts
from swimlab.footage.check.grey import Frames
from swimlab.footage.check.pairs import PairFit, fit_pairs
from swimlab.footage.check.repeats import every_nth, held_frames
from swimlab.footage.check.verdict import Verification, events_said
from swimlab.footage.check.weighing import POOR
from swimlab.footage.motion import EstimatedMotion, UniformMotion
from swimlab.footage.warping import mean_square
from swimlab.runs.frames import Image

MOVES = 0.5
"""Content moves if optical flow leaves less than this share of what changes, rms, in every pair that is looked at."""
AGREED = 0.8
"""... or less than this, if it finds the same in all of them to a quarter: what flickers much moves all the same."""
FAR = 0.3
"""... and if it leaves less than this, a reference moves. Flow fits smooth noise too: of that it leaves .4 to .7."""
LEAST = 0.05
"""Content that moves less than this stands still, px a frame: a quarter of the points at least is to go so far."""

_FLOWS = 5
_AGREE = 0.25
_CALM = 1e-4
_REACH = 0.75


@dataclass(frozen=True)
class Moving:
    """How the content moves: (dx, dy) px a frame at the median; share: rms that is left of the change."""

    velocity: tuple[float, float]
    share: float
    uniform: bool


def verify_still(
    picture: Callable[[int], Image],
    coverage: Callable[[int], Image] | None,
    frames: list[int],
    *,
    clean: bool = False,
    given: bool = True,
    numbers: Sequence[int] | None = None,
) -> Verification:
    """Whether frames stand still, as they must where no motion is given; the rest as of `verify`.

    given: False: the motion is estimated, so that cuts and repeated frames alone are looked for.
    """

    def number(index: int) -> int:
        return index if numbers is None else numbers[index]

    grey = Frames(picture, coverage, frames)
    still = UniformMotion((0.0, 0.0), grey.shape)
    pairs = fit_pairs(still, grey, frames)
    cuts = find_cuts(pairs, grey, moving=True)
    pairs = [pair for pair in pairs if pair.late not in cuts]
    repeated, moving = held_frames(pairs), None
    if repeated:
        shown = [index for index in frames if index not in {*repeated}]
        new = [pair for pair in fit_pairs(still, grey, shown) if pair.late not in cuts]
        moving = _judge(grey, new, number)
        repeated, pairs = (repeated, new) if moving else ([], pairs)
    if moving is None and given:
        moving = _judge(grey, pairs, number)
    said = events_said(cuts, repeated, every_nth(repeated, frames), number)
    residual = float(np.median([pair.given for pair in pairs])) if pairs and given else None
    found = Verification(residual=residual, cuts=tuple(cuts), repeated=tuple(repeated))
    if moving is None:
        calm = residual is not None and residual <= POOR
        return replace(found, verdict="verified" if calm else "unchecked", note=said)
    if not given:
        return replace(found, verdict="partly", doubt=said)
    velocity = "{:.2g},{:.2g}".format(*(round(part, 2) + 0.0 for part in moving.velocity))
    mend = f"give --motion {velocity} or estimate" if moving.uniform else "give its vectors, or --motion estimate"
    text = f"content moves by about {velocity} px a frame: {mend}"
    if clean and moving.share < FAR:
        return replace(found, verdict="wrong", error=f"is not given, but {text}", note=said)
    if repeated:
        return replace(found, verdict="partly", doubt=f"{said}; {text}")
    return replace(found, verdict="partly", doubt=text, note=said)


def _judge(frames: Frames, pairs: list[PairFit], number: Callable[[int], int]) -> Moving | None:
    """What optical flow finds in a few pairs that were taken to stand still; None where nothing moves.

    number: of a frame, by its index.
    """
    changing = [pair for pair in pairs if pair.change > _CALM]
    if not changing or len(changing) < len(pairs) / 2:
        return None
    flow = EstimatedMotion(frames.picture)
    shares, moved = [], []
    for k in sorted({int(k) for k in np.linspace(0, len(changing) - 1, _FLOWS)}):
        pair = changing[k]
        points = frames.points(pair.late)
        places = flow.back(points, pair.late, pair.early)
        seen = frames.seen(places, pair.early)
        points, places = points[:, seen], places[:, seen]
        target = frames.grey(pair.late).codes[tuple(points.astype(np.intp))]
        still, flowed = (mean_square(frames.grey(pair.early).at(each) - target) for each in (points, places))
        shares.append(np.sqrt(flowed / still) if still > 0 else 1.0)
        moved.append((points - places)[::-1] / (number(pair.late) - number(pair.early)))
    reach = min(float(np.quantile(np.hypot(*each), _REACH)) for each in moved)
    velocities = np.array([np.median(each, axis=1) for each in moved])
    strays = np.hypot(*(velocities - velocities.mean(axis=0)).T)
    agree = len(moved) > 1 and strays.max() < _AGREE * np.hypot(*velocities.mean(axis=0))
    if reach < LEAST or max(shares) > (AGREED if agree else MOVES):
        return None
    every = np.concatenate(moved, axis=1)
    velocity = np.median(every, axis=1)
    spread = np.median(np.hypot(*(every - velocity[:, None])))
    return Moving(
        (float(velocity[0]), float(velocity[1])), max(shares), bool(spread < 0.1 * np.hypot(*velocity) + 0.05)
    )
