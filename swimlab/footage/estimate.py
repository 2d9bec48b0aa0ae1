"""Motion estimated from the frames themselves by OpenCV's DIS optical flow (Kroeger et al. 2016).

An estimate follows what is seen, flicker and swimming included, and so hides part of them: its scores are labelled.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.motion import Motion, Points, sample
from swimlab.runs.frames import Image

_BRIGHT = 99.5
"""Percentile of the radiance that becomes white for the estimator, which takes 8-bit codes."""


class EstimatedMotion:
    """Optical flow from each frame back to an earlier one."""

    def __init__(self, picture: Callable[[int], Image]) -> None:
        """picture: index -> [H, W, 3] linear radiance."""
        self._picture = picture
        self._codes = lru_cache(maxsize=2)(self._grey)

    def back(self, points: Points, start: int, stop: int) -> Points:
        return points - sample(self.moved(start, stop), points)

    def moved(self, start: int, stop: int) -> Image:
        import cv2  # heavy

        flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
        flow.setFinestScale(0)
        flow.setVariationalRefinementIterations(10)
        first, second = self._codes(start), self._codes(stop)
        return -np.asarray(flow.calc(first, second, np.zeros((*first.shape, 2), np.float32)), np.float32)

    def variants(self) -> dict[str, tuple[str, Motion]]:
        """None: it is found by matching, so there is nothing to check."""
        return {}

    def _grey(self, index: int) -> NDArray[np.uint8]:
        grey = self._picture(index).mean(axis=2)
        low, high = float(grey.min()), float(np.percentile(grey, _BRIGHT))
        share = np.clip((grey - low) / max(high - low, 1e-12), 0, 1)
        return np.asarray(np.rint(255 * np.sqrt(share)), np.uint8)
