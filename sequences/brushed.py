"""Brushed metal: the angle by which its strokes turn the tangent, made from a seed."""

import numpy as np
from numpy.typing import NDArray

SWING = np.pi / 3
"""Largest turn of the strokes' direction from straight across, radians."""
SPREAD = 0.12
"""Standard deviation of single strokes about it, radians."""


def make(seed: int, size: int = 1024) -> NDArray[np.float32]:
    """Angle of the tangent from x (right) to y (forward), radians, float32 [size, size]; tileable, row 0 is v = 0.

    The strokes' direction waves once over the map in u and in v; each row of texels strays from it by its own angle.
    Angles stay within a right angle of each other nearly everywhere, so that tangents do not cancel where they are
    filtered.
    """
    rng = np.random.default_rng(seed)
    place = 2 * np.pi * (np.arange(size) + 0.5) / size
    swing = SWING * np.sin(place)[None, :] * np.cos(place)[:, None]
    return (swing + SPREAD * rng.standard_normal(size)[:, None]).astype(np.float32)
