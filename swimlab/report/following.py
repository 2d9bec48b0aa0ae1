"""A surface followed from frame to frame through motion vectors, and pictures read where it is."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.motion import Points, sample
from swimlab.footage.pictures import Moved
from swimlab.runs.frames import Image

ALIKE = 1.0
"""A place whose own motion differs by more from that of what is followed shows another surface, px a frame; but for
what the camera changes in the motion of all."""

_NEAR, _ROUNDS = 0.01, 30
_GRID = 16
_STRIP = 64


def follow(points: Points, anchor: int, frames: Sequence[int], moved: Moved) -> NDArray[np.float64]:
    """Where points [2, n] (y, x px) of the surface of one frame are in each of the frames, [frames, 2, n].

    anchor: place of that frame in `frames`, not the first. NaN where the surface is out of the picture, or another one
    is before it; meanwhile it is taken to move on as it did.
    """
    places = np.full((len(frames), *points.shape), np.nan)
    places[anchor] = points
    middle = moved(frames[anchor])
    start = sample(middle, points)
    place, velocity, last = points - start, start, middle
    for t in range(anchor - 1, 0, -1):
        vectors = moved(frames[t])
        expected = velocity + _shake(vectors, last)
        own = sample(vectors, place)
        seen = _alike(own, expected)
        places[t] = np.where(seen & _inside(place, middle.shape), place, np.nan)
        velocity, last = np.where(seen, own, expected), vectors
        place = place - velocity
    places[0] = np.where(_inside(place, middle.shape), place, np.nan)
    place, velocity, last = points, start, middle
    for t in range(anchor + 1, len(frames)):
        vectors = moved(frames[t])
        expected = velocity + _shake(vectors, last)
        there = place + expected
        for _ in range(_ROUNDS):
            better = place + sample(vectors, there)
            gone = float(np.nanmax(np.abs(better - there), initial=0.0))
            there = better
            if gone < _NEAR:
                break
        own = sample(vectors, there)
        seen = _alike(own, expected) & (np.abs(there - own - place) < _NEAR).all(axis=0)
        velocity, last = np.where(seen, own, expected), vectors
        place = place + velocity
        places[t] = np.where(seen & _inside(place, middle.shape), place, np.nan)
    return places


def warped(before: Image, moved: Image) -> Image:
    """The frame before [H, W, channels] as a frame shows it that moved so since, by linear interpolation.

    NaN where it does not show the surface or that is not known; channels are as they come.
    """
    height, width = moved.shape[:2]
    shown = np.empty((height, width, before.shape[2]), np.float32)
    for top in range(0, height, _STRIP):
        strip = moved[top : top + _STRIP]
        points = np.indices(strip.shape[:2], dtype=np.float64).reshape(2, -1) + np.array([[top], [0]])
        shown[top : top + _STRIP] = read_at(before, points - strip[..., ::-1].reshape(-1, 2).T).reshape(
            *strip.shape[:2], -1
        )
    return shown


def read_at(picture: Image, places: Points, top: int = 0) -> Image:
    """[n, channels] of rows top, top + 1, ... of a picture [rows, W, channels] at places [2, n] (y, x px).

    Linear between pixels; NaN where a place is NaN or a pixel that it needs is not there.
    """
    rows, width = picture.shape[:2]
    y, x = places[0] - top, places[1]
    there = np.isfinite(y) & np.isfinite(x)
    y, x = np.where(there, y, 0.0), np.where(there, x, 0.0)
    row, column = np.floor(y), np.floor(x)
    there &= (row >= 0) & (column >= 0) & (np.ceil(y) < rows) & (np.ceil(x) < width)
    low = [np.clip(first.astype(int), 0, size - 1) for first, size in ((row, rows), (column, width))]
    high = [np.minimum(first + 1, size - 1) for first, size in zip(low, (rows, width), strict=True)]
    down, right = (y - row)[:, None], (x - column)[:, None]
    upper = picture[low[0], low[1]] * (1 - right) + picture[low[0], high[1]] * right
    lower = picture[high[0], low[1]] * (1 - right) + picture[high[0], high[1]] * right
    return np.where(there[:, None], upper * (1 - down) + lower * down, np.nan).astype(np.float32)


def same_surface(now: Image, before: Image) -> NDArray[np.bool_]:
    """[H, W], whether the frame before, which moved as `before` says [H, W, 2], shows the surface that moved so now."""
    shake = _shake(before, now)[::-1, 0].astype(np.float32)
    return np.asarray(np.abs(warped(before, now) - now - shake).max(axis=2) <= ALIKE)


def _shake(field: Image, other: Image) -> Points:
    """[2, 1] (y, x), by how much one field differs from another at most pixels: what the camera changes."""
    change = (field[::_GRID, ::_GRID] - other[::_GRID, ::_GRID]).reshape(-1, 2)
    known = change[np.isfinite(change).all(axis=1)]
    return np.median(known, axis=0)[::-1, None].astype(np.float64) if len(known) else np.zeros((2, 1))


def _alike(one: Points, other: Points) -> NDArray[np.bool_]:
    return np.asarray(np.abs(one - other).max(axis=0) <= ALIKE)


def _inside(place: Points, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    return np.asarray(((place >= 0) & (place <= np.array(shape[:2])[:, None] - 1)).all(axis=0))
