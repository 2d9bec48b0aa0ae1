"""Whether a few pixels rule a squared error: glints and fireflies, brighter than any screen, or few that are wrong."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.clip import Image
from metrics.geometry import Mask
from metrics.kernels.launch import Launcher
from metrics.kernels.sizes import ROWS, SIZES, sort_by_size

SHARE = 1e-3
"""The share of the pixels that is looked at: those with the largest squared errors of all frames."""

RULES = 0.5
"""They rule a score if they make more than this share of its squared error."""


class Few(NamedTuple):
    """Of the largest errors: the share of the whole squared error that they make, and their own rms."""

    share: float
    rms: float


def largest(pixels: NDArray[np.float64], sums: NDArray[np.float64], share: float = SHARE) -> Few:
    """What the largest errors make of all, from their counts and sums by size, the smallest first.

    Of the last of their bins as many count as are still wanted.
    """
    pixels, sums = pixels[::-1], sums[::-1]
    wanted, total = share * pixels.sum(), sums.sum()
    taken = np.clip(wanted - (np.cumsum(pixels) - pixels), 0.0, pixels)
    made = float(np.divide(taken * sums, pixels, out=np.zeros(len(sums)), where=pixels > 0).sum())
    return Few(made / total, float(np.sqrt(made / wanted))) if total > 0 else Few(0.0, 0.0)


Counted = NDArray[np.float64]


def count(error: Image, covered: Mask, reached: Mask, launcher: Launcher) -> Counted:
    """[2, 3, SIZES], how many squared errors of a frame there are of each size, and their sums.

    Of pixels that tiles reach, of other covered ones, and of the rest. error: [3, H, W], finite. covered, reached:
    [H, W], where the frame is covered and, within that, tiles reach.
    """
    height = len(covered)
    pixels, sums = (launcher.zeros((-(-height // ROWS), 3, SIZES), wp.float64) for _ in range(2))
    masks = [launcher.view(mask.view(np.uint8), wp.uint8) for mask in (covered, reached)]
    inputs = [launcher.view(error, wp.float32), *masks, pixels, sums]
    launcher.over(height, sort_by_size, (), inputs, each=ROWS)
    return np.array([pixels.numpy().sum(axis=0), sums.numpy().sum(axis=0)])


@dataclass
class Glints:
    """Counts and sums of squared errors by size, of all frames."""

    _counted: Counted = field(default_factory=lambda: np.zeros((2, 3, SIZES)))

    def take(self, counted: Counted) -> None:
        """Add what `count` found of the next frame."""
        self._counted += counted

    def few(self) -> dict[str, Few]:
        """What the largest errors make of `budget.mse`, where tiles reach, and of `frame.mse`, where it is covered."""
        (measured, other, _), (measured_sum, other_sum, _) = self._counted
        return {
            "budget.mse": largest(measured, measured_sum),
            "frame.mse": largest(measured + other, measured_sum + other_sum),
        }

    def notes(self) -> list[str]:
        """A sentence on the scores that a few pixels rule; none where none is."""
        ruled = {name: few for name, few in self.few().items() if few.share > RULES}
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
