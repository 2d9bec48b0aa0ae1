"""When a video's frames are shown: their places on an even grid of times."""

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

_LONGER = 1.5
"""Steps of less than so many of the shortest one are the same step, rounded to the file's time base."""
_OFF = 0.25
"""How far a time stamp may lie off the grid, in its steps."""


class Times(NamedTuple):
    """Places of the frames on an even grid, from 0, and the grid's frames a second."""

    places: tuple[int, ...]
    rate: float


def even_times(stamps: Sequence[Fraction | None], stated: Fraction | None, average: Fraction | None) -> Times | None:
    """The grid on which time stamps lie, s; None where they say nothing, or are on none.

    stated: the rate that the file says frames have; average: frames over duration, which counts where no place is
    empty. Raises ValueError where frames lie on no even grid.
    """
    known = [stamp for stamp in stamps if stamp is not None]
    if len(known) < 2 or len(known) != len(stamps):
        return None
    steps = np.diff(np.array([float(stamp - known[0]) for stamp in known]))
    if steps.min() <= 0:
        raise ValueError("two of its frames have the same time stamp, or go back in time")
    shortest = float(np.mean(steps[steps < _LONGER * steps.min()]))
    counts = np.rint(steps / shortest)
    step = float(steps.sum() / counts.sum())
    off = np.abs(np.cumsum(steps) - step * np.cumsum(counts)) / step
    if off.max() > _OFF:
        raise ValueError("its frames are shown at uneven times, which are no multiples of one step")
    places = (0, *np.cumsum(counts).astype(int).tolist())
    if places[-1] == len(places) - 1 and average is not None:
        return Times(places, float(average))
    if stated is not None:
        by_rate = np.concatenate([[0], np.cumsum(steps)]) * float(stated)
        if np.abs(by_rate - places).max() < _OFF:
            return Times(places, float(stated))
    return Times(places, 1 / step)
