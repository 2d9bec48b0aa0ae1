"""Made maps in the size of the maps that are given as files."""

from functools import lru_cache

import numpy as np

from sequences import asphalt, brushed
from swimlab.render.inputs import Map

SIZE = (1024, 1024)
"""Height and width in texels where no map is a file."""

_SMALLEST = 64
"""Texels a side under which asphalt holds no road."""


def made_map(key: str, seed: int, size: tuple[int, int]) -> Map:
    """The made map of a key, of (height, width) texels, powers of two.

    It is made square, at the longer side, and texels of the shorter one are means; normals stay of unit length.
    """
    height, width = size
    side = max(height, width, _SMALLEST)
    whole = tangents(brushed.make(seed, side)) if key == "twist" else np.asarray(getattr(_asphalt(seed, side), key))
    if size == whole.shape[:2]:
        return whole
    means = whole.reshape(height, side // height, width, side // width, -1).mean(axis=(1, 3), dtype=np.float64)
    if key == "normal":
        means /= np.linalg.norm(means, axis=2, keepdims=True)
    return np.asarray(means, np.float32)


def tangents(angle: Map) -> Map:
    """x and y [h, w, 2] of tangents that are turned by `angle` [h, w] radians from x to y."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1).astype(np.float32)


@lru_cache(maxsize=1)
def _asphalt(seed: int, side: int) -> asphalt.Maps:
    return asphalt.make(seed, side)
