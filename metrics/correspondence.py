"""Where the surface seen in one frame is seen in another, composed from motion fields, and images taken there.

Everything is done with B-spline interpolation (Unser 1999): linear interpolation would itself read as flicker.
Surfaces that pass in front of each other are recognised by their motion: the field bends at the edge between them, and
nothing is measured near such an edge, nor where two of them come from one place.
"""

from collections.abc import Iterator
from typing import Any

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

# A motion field has an edge where its second difference is larger, px.
BEND = 0.25

# Surfaces that move apart by less than this in a frame have an edge between them that is MARGIN wide, px.
APART = MARGIN / 2

_TOLERANCE = 1e-4
_ROUNDS = 30

# Points solved for at a time, to save memory.
_POINTS = 2**18

Places = NDArray[np.float32]
Mask = NDArray[np.bool_]
Field = NDArray[np.float64]


class Correspondence:
    """A span's middle frame followed through frames start..stop-1.

    usable: [H, W], true where the surface of the middle frame is seen in every frame, off all edges, and not much
        smaller. Places are held if they take no more than `room` bytes, else computed again for the rows asked for.
    """

    def __init__(self, clip: Clip, start: int, stop: int, *, room: float) -> None:
        self._clip, self._start, self._stop = clip, start, stop
        self._held: list[Places | None] | None = None
        height, width = clip.shape
        if 8 * height * width * (stop - start) <= room:
            self._held, self.usable = follow(clip, start, stop)
            return
        rows = max(1, int(room / (8 * width * (stop - start))))
        bands = (follow(clip, start, stop, slice(y, min(y + rows, height)))[1] for y in range(0, height, rows))
        self.usable = np.concatenate(list(bands))

    def places(self, rows: slice) -> list[Places | None]:
        """As `follow` gives them, for these rows of the middle frame."""
        if self._held is None:
            return follow(self._clip, self._start, self._stop, rows)[0]
        return [None if places is None else places[:, rows] for places in self._held]

    def course(self) -> Iterator[Places | None]:
        """Places of all rows, frame by frame in the order of `glue`."""
        if self._held is None:
            return (places for _, places, _ in trace(self._clip, self._start, self._stop))
        middle = (len(self._held) - 1) // 2
        return iter([*self._held[middle::-1], *self._held[middle + 1 :]])

    def bytes_per_row(self) -> int:
        """Memory that the places of a row take for as long as they are used; none where they are held anyway."""
        return 8 * self._clip.shape[1] * (self._stop - self._start) if self._held is None else 0


def follow(clip: Clip, start: int, stop: int, rows: slice = slice(None)) -> tuple[list[Places | None], Mask]:
    """Follow the surface of a span's middle frame through frames start..stop-1.

    Returns for every frame the places [2, rows, W] (y, x indices, px) where the surface seen at each pixel of the
    middle frame is seen, None for the middle frame itself; and [rows, W], true where that place is covered, off the
    edges, and not much smaller in every frame.
    """
    places: list[Places | None] = [None] * (stop - start)
    for t, place, landed in trace(clip, start, stop, rows):
        places[t - start] = place
        usable = landed
    return places, usable


def trace(clip: Clip, start: int, stop: int, rows: slice = slice(None)) -> Iterator[tuple[int, Places | None, Mask]]:
    """What `follow` returns, frame by frame: the middle one first, then backwards and forwards from it.

    The mask holds for the frames so far.
    """
    middle = (start + stop - 1) // 2
    first, last, _ = rows.indices(clip.shape[0])
    # One row more on each side: how much smaller a surface gets is a difference of neighbours.
    outer = slice(max(0, first - 1), min(clip.shape[0], last + 1))
    kept = slice(first - outer.start, last - outer.start)
    rest = np.indices((outer.stop - outer.start, clip.shape[1]), dtype=np.float64)
    rest[0] += outer.start
    usable = _inner(clip, middle)[outer]
    yield middle, None, usable[kept]
    place = rest
    for t in range(middle - 1, start - 1, -1):
        moved = clip.moved(t + 1)
        place = place - _take(_spline(moved), place)
        usable &= _lands(_inner(clip, t, moved), place)
        yield t, place[:, kept].astype(np.float32), usable[kept]
    place = rest
    for t in range(middle + 1, stop):
        moved = clip.moved(t)
        usable &= _lands(_inner(clip, t - 1, moved), place)
        place, found = _advance(_spline(moved), place)
        usable &= found & _lands(_inner(clip, t), place)
        yield t, place[:, kept].astype(np.float32), usable[kept]


def glue(clip: Clip, start: int, stop: int) -> Iterator[NDArray[np.float64]]:
    """Where in a span's middle frame the surface lies that each pixel of the other frames sees.

    Yields places [2, H, W] (y, x indices, px) of the middle frame first, then backwards and forwards from it. The
    opposite of `follow`, and found in another way: pixel by pixel from one frame to the next.
    """
    middle = (start + stop - 1) // 2
    rest = np.indices(clip.shape, dtype=np.float64)
    yield rest
    place = rest
    for t in range(middle - 1, start - 1, -1):
        ahead, _ = _advance(_spline(clip.moved(t + 1)), rest)
        place = ahead + _take(_coefficients(place - rest), ahead)
        yield place
    place = rest
    for t in range(middle + 1, stop):
        behind = rest - np.moveaxis(clip.moved(t), 2, 0)[::-1]
        place = behind + _take(_coefficients(place - rest), behind)
        yield place


def unwarp(image: NDArray[Any], places: Places | None, usable: Mask, rows: slice) -> NDArray[np.float32]:
    """Rows of the picture [channels, H, W] as seen from the middle frame: taken at `places` where usable, else 0."""
    if places is None:
        return np.where(usable, image[:, rows], 0.0).astype(np.float32)
    seen = np.zeros((len(image), *usable.shape), dtype=np.float32)
    where = places[:, usable].astype(np.float64)
    for channel, plane in zip(seen, image, strict=True):
        coefficients = ndimage.spline_filter(plane, order=IMAGE_ORDER, mode="mirror")
        channel[usable] = ndimage.map_coordinates(
            coefficients, where, order=IMAGE_ORDER, mode="mirror", prefilter=False
        )
    return seen


def _spline(moved: NDArray[np.float64]) -> Field:
    """Spline coefficients [2, H, W] (y, x) of a motion field [H, W, 2] (x, y)."""
    return _coefficients(np.moveaxis(moved, 2, 0)[::-1])


def _coefficients(planes: NDArray[np.float64]) -> Field:
    return np.stack([ndimage.spline_filter(plane, order=FIELD_ORDER, mode="mirror") for plane in planes])


def _take(field: Field, place: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack(
        [ndimage.map_coordinates(c, place, order=FIELD_ORDER, mode="mirror", prefilter=False) for c in field]
    )


def _advance(field: Field, place: NDArray[np.float64]) -> tuple[NDArray[np.float64], Mask]:
    """Solve q - field(q) = place for the place q in the next frame, by fixed-point iteration.

    Returns q, and where it was found: a surface that is covered up has no place. Each pixel stops by itself.
    """
    target = place.reshape(2, -1)
    ahead, found = np.empty_like(target), np.empty(target.shape[1], dtype=bool)
    for first in range(0, target.shape[1], _POINTS):
        some = slice(first, first + _POINTS)
        ahead[:, some], found[some] = _solve(field, target[:, some])
    return ahead.reshape(place.shape), found.reshape(place.shape[1:])


def _solve(field: Field, target: NDArray[np.float64]) -> tuple[NDArray[np.float64], Mask]:
    """The same for some points [2, n]."""
    guess = target + _take(field, target)
    left = np.arange(target.shape[1])
    for _ in range(_ROUNDS):
        better = target[:, left] + _take(field, guess[:, left])
        moved = np.abs(better - guess[:, left]).max(axis=0)
        guess[:, left] = better
        left = left[moved >= _TOLERANCE]
        if not left.size:
            break
    found = np.ones(target.shape[1], dtype=bool)
    found[left] = False
    return guess, found


def _inner(clip: Clip, t: int, after: NDArray[np.float64] | None = None) -> Mask:
    """[H, W], true where frame t is covered, and its motion has no edge, for MARGIN pixels all round.

    after: motion into frame t + 1, to leave out where surfaces meet of which one covered the other in frame t.
    """
    covered = clip.covered(t)
    whole = np.ones(clip.shape, dtype=bool) if covered is None else covered.copy()
    if t > 0:
        whole &= ~_bends(clip.moved(t), whole)
    size = 2 * MARGIN + 1
    inner = ndimage.minimum_filter(whole.astype(np.uint8), size=size, mode="constant", cval=0) > 0
    if after is not None:
        inner &= ~_meet(after, clip.covered(t + 1))
    return np.asarray(inner)


def _bends(moved: NDArray[np.float64], covered: Mask) -> Mask:
    """Where a motion field [H, W, 2] has an edge between covered pixels."""
    bent = np.zeros(covered.shape, dtype=bool)
    for plane in np.moveaxis(moved, 2, 0).astype(np.float32):
        for field, known, edge in ((plane, covered, bent), (plane.T, covered.T, bent.T)):
            second = np.abs(np.diff(field, n=2, axis=0))
            edge[1:-1] |= (second > BEND) & known[2:] & known[1:-1] & known[:-2]
    return bent


def _meet(moved: NDArray[np.float64], covered: Mask | None) -> Mask:
    """Where surfaces of the next frame come from one place though they move apart: one covered the other there.

    moved: the motion [H, W, 2] into the next frame; covered: where it is known.
    """
    height, width = moved.shape[:2]
    met = np.zeros(height * width, dtype=bool)
    planes = np.moveaxis(moved, 2, 0).astype(np.float32)
    if max(map(np.ptp, planes)) <= APART:
        return met.reshape(height, width)
    column = np.rint(np.arange(width, dtype=np.float32)[None, :] - planes[0]).astype(np.int32)
    row = np.rint(np.arange(height, dtype=np.float32)[:, None] - planes[1]).astype(np.int32)
    inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
    if covered is not None:
        inside &= covered
    place = (row * width + column)[inside]
    for plane in planes:
        speed = plane[inside]
        slowest = np.full(height * width, np.inf, dtype=np.float32)
        fastest = -slowest
        np.minimum.at(slowest, place, speed)
        np.maximum.at(fastest, place, speed)
        met |= fastest - slowest > APART
    return met.reshape(height, width)


def _lands(inner: Mask, place: NDArray[np.float64]) -> Mask:
    """Where a place lies on an inner pixel, and a pixel's step there is no shorter than 1 / SHRINK."""
    row, column = (np.rint(p).astype(np.intp) for p in place)
    inside = (row >= 0) & (row < inner.shape[0]) & (column >= 0) & (column < inner.shape[1])
    landed = inside & inner[np.where(inside, row, 0), np.where(inside, column, 0)]
    (yy, yx), (xy, xx) = (np.gradient(p) for p in place)
    trace, area = yy**2 + yx**2 + xy**2 + xx**2, yy * xx - yx * xy
    shortest = np.sqrt(np.maximum(0.0, trace / 2 - np.sqrt(np.maximum(0.0, trace**2 / 4 - area**2))))
    return np.asarray(landed & (shortest > 1 / SHRINK))
