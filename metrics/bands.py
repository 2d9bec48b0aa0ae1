"""Bands of distance: near, mid and far."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrics.clip import Clip
from metrics.tiles import Level

BANDS = ("near", "mid", "far")

EDGES = (6.0, 16.0)
"""Metres at which mid and far begin."""


def describe(band: str) -> str:
    """A band's range in words."""
    near, far = (f"{edge:g} m" for edge in EDGES)
    return {"near": f"nearer than {near}", "mid": f"{near} to {far}", "far": f"{far} and further"}[band]


def of_depths(depth: NDArray[Any]) -> NDArray[np.intp]:
    """The band index of each depth, m."""
    return np.asarray(np.digitize(depth, EDGES))


def of_tiles(clip: Clip, levels: list[Level], anchor: int) -> list[NDArray[np.intp]] | None:
    """For every level the band index [n] of each tile, by the depth at its centre in the anchor frame.

    None if the clip has no depth.
    """
    distance = clip.distance(anchor)
    if distance is None:
        return None
    centres = (level.origin + level.size // 2 for level in levels)
    return [of_depths(distance[y, x]) for y, x in (centre.T for centre in centres)]
