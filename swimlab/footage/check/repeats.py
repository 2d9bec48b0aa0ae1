"""Frames that are shown again: they repeat the one before, though their content moves."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from swimlab.footage.check.grey import Frames
from swimlab.footage.check.pairs import FEWEST, REACH, PairFit
from swimlab.footage.motion import Motion
from swimlab.footage.pattern import frame_range
from swimlab.footage.warping import mean_square

LEAST = 0.2
"""A pair moves if a quarter of its points goes this far, px."""
EQUAL = 0.1
"""A frame repeats the one before if it differs by less than this share of what most frames differ by."""
LOOKED_AT = 24
"""Frames in the middle of a clip that are read once more to find out whether it repeats any."""
_MOST = 0.8
_HELD = 4
"""Frames in a row that repeat one at most, as 12 a second shown at 60; a picture that stands longer rests."""


def repeated_frames(pairs: list[PairFit]) -> list[int]:
    """Indices of frames that show the one before once more, though they are said to move."""
    alike = {*_alike([pair.change for pair in pairs])}
    return [pair.late for place, pair in enumerate(pairs) if place in alike and pair.reach >= LEAST]


def held_frames(pairs: list[PairFit]) -> list[int]:
    """Indices of frames that show the one before once more, if content moves, which is not known yet."""
    alike = {*_alike([pair.change for pair in pairs])}
    runs = "".join("=" if place in alike else " " for place in range(len(pairs))).split()
    return [pairs[place].late for place in sorted(alike)] if max(map(len, runs), default=0) <= _HELD else []


def repeated_in(frames: Frames, indices: Sequence[int], motion: Motion) -> list[int]:
    """As `repeated_frames`, of frames whose motion was held against others: it is asked for where a pair is alike.

    Of a long clip a part is looked at, and all of it if that has any.
    """
    skipped = max(0, len(indices) - LOOKED_AT) // 2
    found = _repeated(frames, indices[skipped : skipped + LOOKED_AT], motion)
    return _repeated(frames, indices, motion) if found and len(indices) > LOOKED_AT else found


def _repeated(frames: Frames, indices: Sequence[int], motion: Motion) -> list[int]:
    pairs = list(pairwise(indices))
    alike = _alike([_change(frames, late, early) for early, late in pairs])
    return [pairs[place][1] for place in alike if _moves(frames, motion, *reversed(pairs[place]))]


def every_nth(repeated: list[int], frames: list[int]) -> int:
    """n where every nth frame repeats the one before, twice and more, all over the clip; else 0."""
    steps = {late - early for early, late in pairwise(repeated)}
    step = steps.pop() if len(steps) == 1 else 0
    whole = step > 1 and repeated[0] - step <= frames[0] and repeated[-1] + step > frames[-1]
    return step if whole else 0


def repeats_said(repeated: list[int], nth: int, number: Callable[[int], int], of: str = "") -> str:
    """That frames repeat the one before, in words. nth: every nth one does, 0: without order. of: of what."""
    pattern = f"every {ordinal(nth)} frame" if nth else "a frame"
    return f"{pattern}{of} repeats the one before ({frame_range([number(index) for index in repeated])})"


def ordinal(n: int) -> str:
    """2nd, 3rd, 11th."""
    ending = "th" if n % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(n % 10, "th")
    return f"{n}{ending}"


def _alike(changes: Sequence[float]) -> list[int]:
    """Places of changes that are far below what most are."""
    usual = float(np.quantile(changes, _MOST)) if len(changes) else 0.0
    return [place for place, change in enumerate(changes) if change < EQUAL * usual]


def _change(frames: Frames, late: int, early: int) -> float:
    """Rms of the change between two frames, codes; infinite where they have too little in common."""
    points = frames.points(late)
    points = points[:, frames.seen(points, early)]
    if points.shape[1] < FEWEST:
        return float("inf")
    now, before = (frames.grey(index).codes[tuple(points.astype(np.intp))] for index in (late, early))
    return float(np.sqrt(mean_square(now - before)))


def _moves(frames: Frames, motion: Motion, late: int, early: int) -> bool:
    points = frames.points(late)
    moved = np.hypot(*(points - motion.back(points, late, early)))
    return bool(np.quantile(moved, REACH) >= LEAST)
