"""Whether test and reference show the same moment, the same way up, at the same place.

A few frames of the test, spread over the clip, are compared with the reference's frames before and after their own,
with its mirror images, and with it shifted. Nothing is said unless one of these explains what differs in all of them:
noise, blur, aliasing and wrong shading are explained by none, and what exposure and contrast make is left out.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from metrics.clip import WHOLE
from swimlab.footage.check.grey import POINTS, Grey, block_of
from swimlab.footage.check.lucas_kanade import Fit, Values, fit_displacement, sides
from swimlab.footage.motion import Points
from swimlab.footage.warping import grid, inside, mean_square
from swimlab.runs.frames import Image

CLEAR = 0.7
"""Another moment, place or way up is named if it leaves less than this share of the energy that differs. Right ones of
rendered techniques that alias, blur or shade wrongly lose to no other by more than to .9."""
EACH = 0.85
"""... and less than this in each frame."""
FURTHEST = 2
"""Frames before and after that are tried."""
STRAY = 0.2
"""Shifts shorter than this are not named, px,"""
SURE = 6.0
"""... nor those of fewer standard errors,"""
AGREE = 0.25
"""... nor those from which one of the frames differs by more than this share."""

_SAMPLED = 3
_FEWEST = 2
"""Frames that must tell."""
_ALIKE = 2.0
"""A moment and a shift are both named if neither leaves this many times what the other does: steady motion is both."""
_EVEN = 0.4
"""Frames on both sides of the right moment leave alike, as one of them does this share of the other at least."""
_COUNTED = {1: "one frame", 2: "two frames"}
_MIRRORED = {"upside down": (-1, 1), "mirrored": (1, -1), "turned by 180 degrees": (-1, -1)}
_FEWEST_POINTS = 50
_MIDDLE = 512
"""px of the pictures' middle whose phases say from where a shift is sought."""
_EQUAL = 1e-6
"""Pictures whose codes differ by less than this share of their energy are equal."""
_FLAT = 1e-12

Pictures = Callable[[int], Image]
Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class _Shift:
    """share: of the energy that differs, left once the reference is shifted back."""

    share: float
    text: str


@dataclass(frozen=True)
class _Seen:
    """A frame of the test beside the reference: what is left of its energy with each frame and mirror image.

    moments: frames later -> share; mirrored: name -> share; fit: the shift of the reference's own frame.
    """

    moments: dict[int, float]
    mirrored: dict[str, float]
    fit: Fit


def misplaced(test: Pictures, reference: Pictures, coverage: Pictures | None, frames: list[int]) -> str:
    """How the reference stands otherwise than the test, in words; empty where it does not, or cannot be told.

    test, reference, coverage: index -> [H, W, 3] radiance, [H, W]. frames: indices that are measured, in order. A few
    of them are read, one after another.
    """
    places = sorted({round(place) for place in np.linspace(0, len(frames) - 1, _SAMPLED + 2)[1:-1]})
    seen: list[_Seen] = []
    for place in places:
        # Where one is fitted by none beside its own, these are not read any more: what is named fits each better.
        beside = 0 if any(_settles(each) for each in seen) else FURTHEST
        found = _look(test, reference, coverage, frames, place, beside)
        if found is not None:
            seen.append(found)
    if len(seen) < _FEWEST:
        return ""
    shift = _shift_of([each.fit for each in seen])
    left, later = _best([each.moments for each in seen], 0)
    if later and not _lags(seen, later) and (shift is None or left < _ALIKE * shift.share):
        count, when = _COUNTED[abs(later)], "later" if later > 0 else "earlier"
        also = f" (or {shift.text})" if shift is not None and shift.share < _ALIKE * left else ""
        return (
            f"the test fits the reference {count} {when} far better than its own frame: {left:.0%} of the energy that "
            f"differs is left{also}; check that both begin with the same frame"
        )
    left, way = _best([each.mirrored for each in seen], "")
    if way:
        return f"the reference is {way} against the test: so turned, {left:.0%} of the energy that differs is left"
    return f"{shift.text}; check pixel centres, jitter, crop and first frame of both" if shift is not None else ""


def _look(
    test: Pictures, reference: Pictures, coverage: Pictures | None, frames: list[int], place: int, beside: int
) -> _Seen | None:
    """One frame of the test, and so many of the reference beside its own; None where too little is covered or
    differs."""
    index = frames[place]
    shown = test(index)
    shape = shown.shape[:2]
    covered = None if coverage is None else coverage(index) >= WHOLE
    points = grid(shape, POINTS)
    points = points[:, inside(points, shape, covered)]
    if points.shape[1] < _FEWEST_POINTS:
        return None
    rows, columns = points.astype(np.intp)
    whole = _grey(shown, points)
    target = whole.codes[rows, columns]
    own = _grey(reference(index), points)
    left = _share(own.codes[rows, columns], target)
    if left < _EQUAL or target.std() < _FLAT:
        return None
    mirrored = {
        way: _share(own.codes[::down, ::across][rows, columns], target) for way, (down, across) in _MIRRORED.items()
    }
    start = _guess(whole, own)
    own.codes += target.mean() - own.codes[rows, columns].mean()
    fit = fit_displacement(target, own, points, sides(points.shape[1]), block_of(points, shape), start)
    moments = {0: left}
    for later in range(-beside, beside + 1):
        there = place + later
        if later and 0 <= there < len(frames) and frames[there] == index + later:
            moments[later] = _share(_grey(reference(index + later), points).codes[rows, columns], target)
    return _Seen(moments, {"": left} | mirrored, fit)


def _settles(seen: _Seen) -> bool:
    """Whether all frames beside the reference's own were tried, and none is the better one."""
    return len(seen.moments) == 2 * FURTHEST + 1 and min(seen.moments.values()) >= EACH * seen.moments[0]


def _grey(picture: Image, points: Points) -> Grey:
    """In codes by its own mean over points, so that exposure makes no difference."""
    rows, columns = points.astype(np.intp)
    typical = float(np.abs(picture[rows, columns].mean(axis=1, dtype=np.float64)).mean()) or 1.0
    return Grey(picture, typical, None)


def _guess(shown: Grey, own: Grey) -> Values:
    """(x, y) px by which the reference is to be shifted, from the phases of the middle of both pictures."""
    import cv2  # heavy

    height, width = shown.codes.shape
    down, across = (max(0, size - _MIDDLE) // 2 for size in (height, width))
    middle = slice(down, height - down), slice(across, width - across)
    first, second = (each.codes[middle].copy() for each in (shown, own))  # which are written over
    window = cv2.createHanningWindow(first.shape[::-1], cv2.CV_64F)
    return -np.array(cv2.phaseCorrelate(first, second, window)[0])


def _share(codes: Values, target: Values) -> float:
    """Share of the target's energy that is left by the straight line of other codes that fits it best."""
    spread, mean = codes - codes.mean(), target - target.mean()
    energy = float(spread @ spread)
    slope = max(float(spread @ mean) / energy, 0.0) if energy > 0 else 0.0
    return mean_square(mean - slope * spread) / max(mean_square(mean), _FLAT)


def _best(seen: list[dict[Key, float]], own: Key) -> tuple[float, Key]:
    """What leaves clearly less than all else, and its share of what the frame itself leaves; else that, and 1."""
    shares: dict[Key, float] = {}
    for key in dict.fromkeys(key for each in seen for key in each):
        pairs = [(each[key], each[own]) for each in seen if key in each]
        if len(pairs) >= _FEWEST:
            shares[key] = sum(left for left, _ in pairs) / sum(given for _, given in pairs)
    best, *others = sorted(shares, key=lambda key: shares[key])
    clear = all(each[best] < EACH * each[own] for each in seen if best in each)
    if not others or not clear or shares[best] >= CLEAR * shares[others[0]]:
        return 1.0, own
    return shares[best], best


def _lags(seen: list[_Seen], later: int) -> bool:
    """Whether the test is less than a frame from its own, as a history that trails: beyond the moment it fits worse."""
    told = [(each.moments[0], each.moments[2 * later]) for each in seen if 2 * later in each.moments]
    return bool(told) and sum(own for own, _ in told) < _EVEN * sum(beyond for _, beyond in told)


def _shift_of(fits: list[Fit]) -> _Shift | None:
    """By how much the reference is shifted; None where that does not explain what differs."""
    shifts = np.array([-fit.theta for fit in fits])
    errors = np.array([fit.error for fit in fits])
    mean = shifts.mean(axis=0)
    length = float(np.hypot(*mean))
    strays = np.hypot(*(shifts - mean).T)
    unsure = float(np.hypot(*np.where(np.isfinite(errors), errors, 0.0).T).max())
    share = sum(fit.after for fit in fits) / sum(fit.before for fit in fits)
    clear = share < CLEAR and all(fit.after < EACH * fit.before for fit in fits)
    if not clear or length < max(STRAY, SURE * unsure) or strays.max() > AGREE * length:
        return None
    x, y = mean.round(2) + 0.0
    text = f"the reference is shifted by about {x:.2g},{y:.2g} px against the test, right and down: shifted back, "
    return _Shift(share, f"{text}{share:.0%} of the energy that differs is left")
