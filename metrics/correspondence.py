"""Where the surface seen in one frame is seen in another, composed from motion fields, and images taken there.

Everything is done with B-spline interpolation (Unser 1999): linear interpolation would itself read as flicker.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from metrics.clip import Clip

# Splines ring where a picture ends: nothing is measured this near to an edge (the quintic's ringing falls by
# .43 a pixel).
MARGIN = 8
IMAGE_ORDER = 5
FIELD_ORDER = 3

# A tile is left out where the other frame shows the surface this many times smaller: its detail is lost there.
SHRINK = 2.0

_TOLERANCE = 1e-4
_ROUNDS = 30

Places = NDArray[np.float32]
Mask = NDArray[np.bool_]


def follow(clip: Clip, start: int, stop: int) -> tuple[list[Places | None], Mask]:
    """Follow the surface of a span's middle frame through frames start..stop-1.

    Returns for every frame the places [2, H, W] (y, x indices, px) where the surface seen at each pixel of the
    middle frame is seen, None for the middle frame itself; and [H, W], true where that place is covered, off the
    edges, and not much smaller in every frame.
    """
    middle = (start + stop - 1) // 2
    rest = np.indices(clip.shape, dtype=np.float64)
    usable = _inner(clip, middle)
    places: list[Places | None] = [None] * (stop - start)
    place = rest
    for t in range(middle, start, -1):
        place = place - _take(_field(clip, t), place, FIELD_ORDER)
        usable &= _lands(_inner(clip, t - 1), place)
        places[t - 1 - start] = place.astype(np.float32)
    place = rest
    for t in range(middle + 1, stop):
        place = _advance(_field(clip, t), place, usable)
        usable &= _lands(_inner(clip, t), place)
        places[t - start] = place.astype(np.float32)
    return places, usable


def unwarp(image: NDArray[np.float64], places: Places | None, usable: Mask) -> NDArray[np.float64]:
    """The picture [channels, H, W] as seen from the middle frame: sampled at `places` where usable, else 0."""
    if places is None:
        return np.where(usable, image, 0.0)
    seen = np.zeros_like(image)
    where = places[:, usable].astype(np.float64)
    for channel, plane in zip(seen, image, strict=True):
        coefficients = ndimage.spline_filter(plane, order=IMAGE_ORDER, mode="mirror")
        channel[usable] = ndimage.map_coordinates(
            coefficients, where, order=IMAGE_ORDER, mode="mirror", prefilter=False
        )
    return seen


def _field(clip: Clip, t: int) -> NDArray[np.float64]:
    """Spline coefficients [2, H, W] (y, x) of the motion since frame t - 1."""
    moved = clip.moved(t)
    return np.stack([_coefficients(moved[:, :, axis]) for axis in (1, 0)])


def _coefficients(plane: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(ndimage.spline_filter(plane, order=FIELD_ORDER, mode="mirror"))


def _take(coefficients: NDArray[np.float64], place: NDArray[np.float64], order: int) -> NDArray[np.float64]:
    return np.stack(
        [ndimage.map_coordinates(c, place, order=order, mode="mirror", prefilter=False) for c in coefficients]
    )


def _advance(field: NDArray[np.float64], place: NDArray[np.float64], usable: Mask) -> NDArray[np.float64]:
    """Solve q - field(q) = place for the place q in the next frame, by fixed-point iteration."""
    target = place[:, usable]
    guess = target + _take(field, target, FIELD_ORDER)
    for _ in range(_ROUNDS):
        better = target + _take(field, guess, FIELD_ORDER)
        moved = float(np.max(np.abs(better - guess), initial=0.0))
        guess = better
        if moved < _TOLERANCE:
            break
    ahead = place.copy()
    ahead[:, usable] = guess
    return ahead


def _inner(clip: Clip, t: int) -> Mask:
    """[H, W], true where frame t is covered for MARGIN pixels all round."""
    covered = clip.covered(t)
    whole = np.ones(clip.shape, dtype=np.uint8) if covered is None else covered.astype(np.uint8)
    size = 2 * MARGIN + 1
    return np.asarray(ndimage.minimum_filter(whole, size=size, mode="constant", cval=0) > 0)


def _lands(inner: Mask, place: NDArray[np.float64]) -> Mask:
    """Where a place lies on an inner pixel, and a pixel's step there is no shorter than 1 / SHRINK."""
    row, column = (np.rint(p).astype(np.intp) for p in place)
    inside = (row >= 0) & (row < inner.shape[0]) & (column >= 0) & (column < inner.shape[1])
    landed = inside & inner[np.where(inside, row, 0), np.where(inside, column, 0)]
    (yy, yx), (xy, xx) = (np.gradient(p) for p in place)
    trace, area = yy**2 + yx**2 + xy**2 + xx**2, yy * xx - yx * xy
    shortest = np.sqrt(np.maximum(0.0, trace / 2 - np.sqrt(np.maximum(0.0, trace**2 / 4 - area**2))))
    return np.asarray(landed & (shortest > 1 / SHRINK))
