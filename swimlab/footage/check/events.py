"""What happens in a clip: cuts, frames whose vectors are wrong."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from swimlab.footage.check.grey import Frames
from swimlab.footage.check.lucas_kanade import Values
from swimlab.footage.check.pairs import PairFit
from swimlab.footage.motion import EstimatedMotion, Points
from swimlab.footage.warping import mean_square

_UNLIKE = 0.5
"""Correlation under which two pictures have nothing to do with each other."""
_TRIED = 8
_LEAP = 2.0
"""A cut leaves this many times what its clip's pairs leave at the median."""

_JUMP = 3.0
"""The picture of a reference jumps where its motion leaves this many times what it leaves at the median of pairs,"""
_JUMPED = 0.1
"""... and this share of the change that unlike pictures have."""

STRAY = 0.03
"""Shifts of the whole picture shorter than this are no fault of vectors, px."""
SURE = 6.0
"""... nor those of fewer standard errors."""
MENDED = 0.5
"""A shift is the vectors' fault if it takes away this share of the energy that a pair leaves."""
_WORTH = 0.05
_FLOWN = 0.3
"""... and optical flow, which fits noise too, if it leaves this share of what the motion leaves, rms."""
MOST = 0.6
"""... and if this share of the points fits better with it: half do by chance, or where a few points rule."""
FEW = 0.34
"""Up to this share of pairs that stray is a fault of single frames."""
_SMOOTH = 9
"""Pairs over which a camera's own motion changes little."""


def find_cuts(pairs: list[PairFit], frames: Frames, *, moving: bool = False) -> list[int]:
    """Indices of frames that begin a new shot: no motion explains their change, which is far above that of most.

    moving: the content may move otherwise than the pairs say, so that optical flow alone tells what leaps.
    """
    usual = float(np.median([pair.given for pair in pairs])) if pairs else 0.0
    leaps = [pair for pair in pairs if pair.likeness < _UNLIKE and (moving or pair.given > _LEAP * usual)]
    if len(leaps) > FEW * len(pairs):
        # Noise leaps everywhere: a few pairs tell.
        tried = leaps[:: max(1, len(leaps) // _TRIED)]
        if sum(not _alike(frames, pair.late, pair.early) for pair in tried) > FEW * len(tried):
            return []
    unlike = [pair for pair in leaps if not _alike(frames, pair.late, pair.early)]
    cuts = {pair.late for pair in unlike}
    for first, second in pairwise(unlike):
        # One strange frame after which all is as before is no shot: it is flicker.
        if second.early == first.late and _alike(frames, second.late, first.early):
            cuts -= {first.late, second.late}
    return sorted(cuts)


def find_jumps(pairs: list[PairFit]) -> list[int]:
    """Indices of frames before which the picture jumps: the motion leaves far more of the change than in most pairs."""
    usual = float(np.median([pair.given for pair in pairs])) if pairs else 0.0
    jumps = [pair.late for pair in pairs if pair.given > max(_JUMP * usual, _JUMPED)]
    return jumps if len(jumps) <= FEW * len(pairs) else []


def _alike(frames: Frames, late: int, early: int) -> bool:
    """Whether two frames show the same, still or moved as optical flow finds."""
    points = frames.points(late)
    target = frames.grey(late).codes[tuple(points.astype(np.intp))]

    def like(places: Points) -> bool:
        seen = frames.grey(early).at(places)
        return bool(seen.std() > 0 and target.std() > 0 and np.corrcoef(seen, target)[0, 1] >= _UNLIKE)

    return like(points) or like(EstimatedMotion(frames.picture).back(points, late, early))


@dataclass(frozen=True)
class Stray:
    """A pair that another motion explains. late: its later frame. lacking: (x, y) px that its motion lacks.

    left: by that other motion, as `PairFit.given` has it.
    """

    late: int
    lacking: Values
    left: float

    @property
    def length(self) -> float:
        """px that the motion lacks."""
        return float(np.hypot(*self.lacking))


def find_strays(pairs: list[PairFit], frames: Frames) -> list[Stray]:
    """Pairs whose motion lacks something beside what their neighbours lack, beyond what may be noise."""
    shifts = np.array([pair.shift for pair in pairs]).reshape(-1, 2)
    usual = float(np.median([pair.given for pair in pairs])) if pairs else 0.0
    strays: list[Stray] = []
    for k, pair in enumerate(pairs):
        near = shifts[max(0, k - _SMOOTH // 2) : k + _SMOOTH // 2 + 1]
        stray = shifts[k] - np.median(near, axis=0)
        sure = np.hypot(*stray) > max(STRAY, SURE * float(np.hypot(*np.where(np.isfinite(pair.error), pair.error, 0))))
        if sure and pair.better > MOST and pair.rigid**2 <= (1 - MENDED) * pair.given**2:
            strays.append(Stray(pair.late, stray, pair.rigid))
        elif pair.given > max(_LEAP * usual, _WORTH):
            strays += _flown(pair, frames)
    return strays


def _flown(pair: PairFit, frames: Frames) -> list[Stray]:
    """The pair, with what its motion lacks at the median, where optical flow explains it; else nothing."""
    points = frames.points(pair.late)
    places = EstimatedMotion(frames.picture).back(points, pair.late, pair.early)
    seen = frames.seen(places, pair.early)
    points, places = points[:, seen], places[:, seen]
    target = frames.grey(pair.late).codes[tuple(points.astype(np.intp))]
    left = float(np.sqrt(mean_square(frames.grey(pair.early).at(places) - target))) / pair.spread
    lacking = np.median(points - places, axis=1)[::-1] - pair.travel
    fits = left <= _FLOWN * pair.given and np.hypot(*lacking) > STRAY
    return [Stray(pair.late, lacking, left)] if fits else []
