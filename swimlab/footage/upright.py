"""How stored pictures are to be turned or mirrored to be seen as they were meant."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_NOTHING = 0.01
"""Numbers of a matrix below this share of its largest are rounding."""


@dataclass(frozen=True)
class Upright:
    """One of the eight ways a rectangle may lie: across: rows become columns; then right, down: 1, or -1 for backwards.

    Stored as it is seen where all stand as they do here.
    """

    across: bool = False
    right: int = 1
    down: int = 1

    def of(self, pixels: NDArray[Any]) -> NDArray[Any]:
        """A stored picture [H, W, ...] as it is seen."""
        turned = pixels.swapaxes(0, 1) if self.across else pixels
        return turned[:: self.down, :: self.right]


def upright(matrix: Sequence[int]) -> Upright:
    """What a display matrix of nine numbers says, as FFmpeg's libavutil/display.h has it: a b u, c d v, x y w.

    A stored point (p, q), right and down, is seen at (a p + c q, b p + d q). Raises ValueError for a turn that is no
    quarter.
    """
    size = np.abs(matrix[:5])
    a, b, _, c, d = np.where(size > _NOTHING * size.max(), np.sign(matrix[:5]), 0).tolist()
    if a and d and not (b or c):
        return Upright(right=a, down=d)
    if b and c and not (a or d):
        return Upright(across=True, right=c, down=b)
    raise ValueError("is to be shown turned by no quarter")
