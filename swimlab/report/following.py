"""A surface followed from frame to frame through motion vectors, and pictures read where it is."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.motion import Points, sample
from swimlab.footage.pictures import Moved
from swimlab.runs.frames import Image

ALIKE = 1.0
"""A place whose own motion differs by more from that of what is followed shows another surface, px a frame."""

_NEAR, _ROUNDS = 0.01, 30


def follow(points: Points, anchor: int, frames: Sequence[int], moved: Moved) -> NDArray[np.float64]:
    """Where points [2, n] (y, x px) of the surface of one frame are in each of the frames, [frames, 2, n].

    anchor: place of that frame in `frames`, not the first. NaN where the surface is out of the picture, or another one
    is before it; meanwhile it is taken to move on as it did.
    """
    places = np.full((len(frames), *points.shape), np.nan)
    places[anchor] = points
    field = moved(frames[anchor])
    start = sample(field, points)
    place, velocity = points, start
    for t in range(anchor, 0, -1):
        if t < anchor:
            own = sample(moved(frames[t]), place)
            seen = _alike(own, velocity)
            velocity = np.where(seen, own, velocity)
            places[t] = np.where(seen & _inside(place, field.shape), place, np.nan)
        place = place - velocity
    places[0] = np.where(_inside(place, field.shape), place, np.nan)
    place, velocity = points, start
    for t in range(anchor + 1, len(frames)):
        vectors = moved(frames[t])
        there = place + velocity
        for _ in range(_ROUNDS):
            better = place + sample(vectors, there)
            gone = float(np.nanmax(np.abs(better - there), initial=0.0))
            there = better
            if gone < _NEAR:
                break
        own = sample(vectors, there)
        seen = _alike(own, velocity) & (np.abs(there - own - place) < _NEAR).all(axis=0)
        velocity = np.where(seen, own, velocity)
        place = place + velocity
        places[t] = np.where(seen & _inside(place, field.shape), place, np.nan)
    return places


def warped(before: Image, moved: Image) -> Image:
    """The frame before [H, W, channels] as a frame shows it that moved so since, by linear interpolation.

    NaN where it does not show the surface or that is not known; channels are as they come.
    """
    height, width = moved.shape[:2]
    points = np.indices((height, width), dtype=np.float64).reshape(2, -1)
    places = points - moved[..., ::-1].reshape(-1, 2).T
    return read_at(before, places).reshape(height, width, -1)


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
    return np.asarray(np.abs(warped(before, now) - now).max(axis=2) <= ALIKE)


def _alike(one: Points, other: Points) -> NDArray[np.bool_]:
    return np.asarray(np.abs(one - other).max(axis=0) <= ALIKE)


def _inside(place: Points, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    return np.asarray(((place >= 0) & (place <= np.array(shape[:2])[:, None] - 1)).all(axis=0))
