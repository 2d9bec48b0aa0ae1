"""Whether a few pixels rule a squared error: glints and fireflies, brighter than any screen, or few that are wrong."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SHARE = 1e-3
"""The share of the pixels that is looked at: those with the largest squared errors of all frames."""

RULES = 0.5
"""They rule a score if they make more than this share of its squared error."""

_BINS, _SHIFT = 1024, 21
"""Squared errors are counted by the upper bits of their float32: the exponent, and quarters of it."""


class Few(NamedTuple):
    """Of the largest errors: the share of the whole squared error that they make, and their own rms."""

    share: float
    rms: float


@dataclass
class Errors:
    """Counts and sums of squared errors by size."""

    _pixels: NDArray[np.float64] = field(default_factory=lambda: np.zeros(_BINS))
    _sums: NDArray[np.float64] = field(default_factory=lambda: np.zeros(_BINS))

    def add(self, squared: NDArray[np.float32]) -> None:
        """Take in squared errors [n], finite and at or above 0."""
        place = np.ascontiguousarray(squared).view(np.uint32) >> _SHIFT
        self._pixels += np.bincount(place, minlength=_BINS)
        self._sums += np.bincount(place, squared, minlength=_BINS)

    def largest(self, share: float = SHARE) -> Few:
        """What the largest errors make of all; of the last of their bins as many count as are still wanted."""
        pixels, sums = self._pixels[::-1], self._sums[::-1]
        wanted = share * pixels.sum()
        taken = np.clip(wanted - (np.cumsum(pixels) - pixels), 0.0, pixels)
        total = sums.sum()
        largest = float(np.divide(taken * sums, pixels, out=np.zeros(_BINS), where=pixels > 0).sum())
        return Few(largest / total, float(np.sqrt(largest / wanted))) if total > 0 else Few(0.0, 0.0)


@dataclass
class Glints:
    """The errors behind `frame.mse`, of all covered pixels, and behind `budget.mse`, of those that tiles reach."""

    _errors: dict[str, Errors] = field(default_factory=lambda: {name: Errors() for name in ("budget.mse", "frame.mse")})

    def add(self, error: NDArray[np.float32], covered: NDArray[np.bool_], reached: NDArray[np.bool_]) -> None:
        """Take in a frame's error [3, H, W], and where it is covered and tiles reach, [H, W]."""
        squared = np.square(error).mean(axis=0)
        for errors, where in zip(self._errors.values(), (reached, covered), strict=True):
            errors.add(squared[where])

    def notes(self) -> list[str]:
        """A sentence on the scores that a few pixels rule; none where none is."""
        ruled = {name: few for name, errors in self._errors.items() if (few := errors.largest()).share > RULES}
        if not ruled:
            return []
        said = " and ".join(f"{few.share:.0%} of {name}" for name, few in ruled.items())
        rms = max(few.rms for few in ruled.values())
        text = f"a thousandth of the pixels, rms error {rms:.2g}, makes {said}"
        if rms <= 1:
            return [f"{text}: a few places rule what it says"]
        return [
            f"{text}: glints or fireflies, beyond what a screen shows; the display domain (--domain display, with "
            "[display] or --display for the view) measures what is seen of them"
        ]
