"""Bloom: bright light that a lens, and the eye, spread about where it fell."""

from dataclasses import dataclass
from math import ceil, log2, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

OCTAVES = 4
"""Gaussians that spread light in equal shares, each half as wide as the one before, down to a pixel."""


@dataclass(frozen=True)
class Bloom:
    """A share of the light above a threshold, spread by a Gaussian pyramid (Burt & Adelson 1983); none is lost.

    strength: share of that light that is spread, 0..1; 0 is no bloom. threshold: radiance, a channel at a time, at
    least 0. radius: standard deviation of the widest Gaussian, as a share of the picture's height, so that a picture
    of another size blooms in the same way. Raises ValueError for values out of range.
    """

    strength: float = 0.0
    threshold: float = 1.0
    radius: float = 0.03

    def __post_init__(self) -> None:
        if not (0 <= self.strength <= 1 and self.threshold >= 0 and 0 < self.radius <= 1):
            raise ValueError(f"{self}: strength lies in 0..1, threshold is at least 0, radius above 0 and at most 1")

    def spread(self, light: NDArray[np.float64]) -> NDArray[np.float64]:
        """Planes of light [n, H, W], at least 0, with the bright part spread."""
        if self.strength == 0:
            return light
        bloomed = np.empty_like(light)
        for plane, found in zip(light, bloomed, strict=True):
            bright = np.maximum(plane - self.threshold, 0.0)
            found[...] = (plane - self.strength * bright) + self.strength * _glow(bright, self.radius * len(plane))
        return bloomed


def _glow(bright: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Mean of OCTAVES Gaussians of [H, W], the widest of a standard deviation of about `radius` px.

    Level n of the pyramid, brought back to full size, has one of sqrt(2/3 (4^n - 1)) px; between two levels both are
    mixed, so that nothing jumps where the radius, or the size of the picture, passes an octave.
    """
    import cv2  # heavy

    widest = log2(max(radius * sqrt(1.5), 1.0))
    depths = np.clip(widest - np.arange(OCTAVES), 0.0, log2(min(bright.shape)))
    levels = np.arange(ceil(depths[0]) + 1)
    weights = np.maximum(1.0 - np.abs(levels[:, None] - depths), 0.0).mean(axis=1)
    pyramid: list[NDArray[Any]] = [bright]
    for _ in levels[1:]:
        pyramid.append(cv2.pyrDown(pyramid[-1]))
    glow: NDArray[Any] = weights[-1] * pyramid.pop()
    for weight in weights[-2::-1]:
        level = pyramid.pop()
        glow = cv2.pyrUp(glow, dstsize=level.shape[::-1]) + weight * level
    return glow
