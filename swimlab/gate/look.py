"""Where in a frame a score is at its worst, by the pictures: the part of the frame's error or change it is about."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from math import log, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics import bands
from metrics.budget import CUT
from metrics.levels import levels_of
from swimlab.footage.pictures import Pictures
from swimlab.gate.about import About
from swimlab.report.clips import Region
from swimlab.report.display import COVERED, ERROR_RANGE, Picture, difference_codes, srgb
from swimlab.report.places import Pair, cut, pair_into, worst_square
from swimlab.runs.frames import FrameError, Image
from swimlab.runs.record import REFERENCE

Power = NDArray[np.float64]

BLUR = sqrt(log(2) / 2) / (pi * CUT)
"""Of the Gaussian that halves an amplitude where detail begins, px."""


class Found(NamedTuple):
    """Where a score is worst. power: the sum over the region. panels: pictures of the region, by what they show.

    before: the frame before it, where it is not known which of the two is at fault for the change between them.
    """

    power: float
    frame: int
    before: int | None
    region: Region
    panels: dict[str, Picture]


class Look:
    """A frame of a technique. frames: of the run. map: of classes, as `frame.map` in scores.json; empty: not known.

    Everything raises FrameError where a picture, the motion or depth cannot be read.
    """

    def __init__(
        self,
        pictures: Pictures,
        technique: str,
        frames: Sequence[int],
        frame: int,
        *,
        reference: bool,
        classes: Mapping[str, Any],
    ) -> None:
        self._pictures, self._technique, self._frames, self._frame = pictures, technique, frames, frame
        self._reference, self._classes = reference, classes

    def find(self, what: About) -> Found | None:
        """Where the frame is worst for what a score is about; None where nothing of it is in the frame."""
        power = self._power(what)
        region, total = worst_square(power * self._weight(what, power.shape))
        if not total > 0:
            return None
        if "change" not in what.kind:
            test, exact, error = (cut(each[..., :3], region) for each in (*self._shown, self._error))
            panels = {self._technique: srgb(test), REFERENCE: srgb(exact)}
            return Found(
                total, self._frame, None, region, panels | {f"error +-{ERROR_RANGE:g}": difference_codes(error)}
            )
        pair = self._pair if what.kind == "change" else self._own_pair
        against = self._reference and what.kind == "change"
        frame, place = pair.fault(region) if against else (self._frame, region)
        panels = {
            f"frame {number}": srgb(cut(picture[..., :3], region))
            for number, picture in zip(pair.frames, pair.pictures, strict=True)
        }
        panels[f"change +-{ERROR_RANGE:g}"] = difference_codes(cut(pair.change, region))
        return Found(total, frame, None if against else pair.frames[0], place, panels)

    def _power(self, what: About) -> Power:
        """[H, W], what the score is about, pixel by pixel."""
        if what.kind == "error":
            covered = self._shown[1][..., 3] >= COVERED
            if what.pixels == "new" and self._frames.index(self._frame):
                covered = self._pair.covered & ~self._pair.known
            return np.where(covered, _products(self._error, self._error), 0.0)
        if what.kind == "change":
            return _products(self._pair.change, self._pair.change)
        if what.kind == "own change":
            return _products(self._own_pair.change, self._own_pair.change)
        # What both frames of a pair have in common is static: noise and flicker have no mean product.
        before, now = ((error, _low(error, self._pair.known)) for error in self._pair.errors)
        if what.kind == "bias":
            return np.where(self._pair.known, _products(before[1], now[1]), 0.0)
        return np.where(self._pair.known, _products(before[0] - before[1], now[0] - now[1]), 0.0)

    def _weight(self, what: About, shape: tuple[int, ...]) -> Power:
        """[H, W], 0..1, how much of each pixel is of the score's class and band."""
        weight = np.ones(shape)
        if what.pixels in self._classes:
            (cell,) = self._classes["cell"]
            shares = levels_of(self._classes[what.pixels]) / 100
            weight = shares.repeat(cell, axis=0).repeat(cell, axis=1)[: shape[0], : shape[1]]
        elif what.pixels == "edges":
            raise FrameError("the scores hold no map of edges; measure the run again")
        if what.band:
            depth = self._pictures.depth(self._frame)
            weight = weight * ((bands.of_depths(depth) == bands.BANDS.index(what.band)) & (depth > 0))
        return weight

    @cached_property
    def _shown(self) -> tuple[Image, Image]:
        return self._pictures.read(self._technique, self._frame), self._pictures.read(REFERENCE, self._frame)

    @cached_property
    def _error(self) -> Image:
        test, exact = self._shown
        return test[..., :3] - exact[..., :3]

    @cached_property
    def _pair(self) -> Pair:
        return pair_into(self._pictures, self._technique, self._frames, self._frame, reference=self._reference)

    @cached_property
    def _own_pair(self) -> Pair:
        if not self._reference:
            return self._pair
        return pair_into(self._pictures, self._technique, self._frames, self._frame, reference=False)


def _products(one: Image, other: Image) -> Power:
    return np.asarray((one.astype(np.float64) * other).sum(axis=2))


def _low(error: Image, known: NDArray[np.bool_]) -> Image:
    """The mean of a neighbourhood, over pixels that are known; 0 where none is near. The error is 0 where unknown."""
    import cv2  # heavy

    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), BLUR)
    blurred = cv2.GaussianBlur(error, (0, 0), BLUR)
    return np.divide(blurred, weight[..., None], out=np.zeros_like(error), where=weight[..., None] > 0)
