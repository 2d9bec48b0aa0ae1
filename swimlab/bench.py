"""How fast the measures are, on frames that cost nothing to make."""

import resource
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrics import Clip, measure

VELOCITY = (23 / 32, 19 / 32)
FAMILIES = (("budget",), ("residual",), ("plane",), ("budget", "residual", "plane"), ())
"""Scores that are timed together; the last is all of them."""


@dataclass(frozen=True)
class Timing:
    """Frames a second of measuring `names` (all scores if empty), and the process's peak memory by then, bytes."""

    names: tuple[str, ...]
    frames_per_second: float
    peak_memory: int


def time_measures(
    width: int,
    height: int,
    frames: int,
    *,
    threads: int | None = None,
    memory: float = 1.0e9,
    advance: Callable[[str], None] = lambda _: None,
) -> list[Timing]:
    """Time the measures on a wholly covered clip of noise under uniform motion, test against reference.

    The noise is cut from one larger picture, so that making a frame costs a copy. `memory` is what `measure` may take;
    `advance` is called with the names timed.
    """
    rng = np.random.default_rng(0)
    pool = rng.random((height + frames, width + frames, 3), np.float32)
    still = rng.random((height, width, 3), np.float32)

    def test(t: int) -> NDArray[np.float32]:
        return pool[t : t + height, t : t + width]

    timings = []
    for names in FAMILIES:
        started = time.perf_counter()
        measure(
            Clip(test, frames, motion=VELOCITY),
            Clip(lambda _: still, frames, motion=VELOCITY),
            names=names or None,
            threads=threads,
            memory=memory,
        )
        elapsed = time.perf_counter() - started
        peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        timings.append(Timing(names, frames / elapsed, peak))
        advance(", ".join(names) or "all")
    return timings
