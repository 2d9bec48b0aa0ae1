"""How fast the measures are, on frames that cost nothing to make."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from metrics import Clip, Measurement, align, measure
from metrics.machine import peak_memory
from metrics.spans import Placement, Span
from metrics.spectra import Batch, Pictures
from metrics.sweep import Sweep
from metrics.tiles import Level

VELOCITY = (23 / 32, 19 / 32)
TRANSFORMS = "transforms alone"
MAIN = ("budget", "residual", "plane")
FAMILIES = (("budget",), ("residual",), ("plane",), MAIN, ())
"""Scores that are timed together; the last is all of them."""
NAMES = (TRANSFORMS, *(", ".join(names) or "all" for names in FAMILIES))


@dataclass(frozen=True)
class Timing:
    """Frames a second of what is named, and the process's peak memory by then, bytes."""

    name: str
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
    `advance` is called with the names timed. The first timing is of the tiles' windows and Fourier transforms, without
    which there is no measure.
    """
    rng = np.random.default_rng(0)
    pool = rng.random((height + frames, width + frames, 3), np.float32)
    still = rng.random((height, width, 3), np.float32)
    test = Clip(lambda t: pool[t : t + height, t : t + width], frames, motion=VELOCITY)
    reference = Clip(lambda _: still, frames, motion=VELOCITY)

    def transform() -> None:
        def read(place: Placement) -> Pictures:
            picture = test.planes(place.t)
            return Pictures(picture, picture - reference.planes(place.t))

        with Sweep([_Spectra()], read, pictures=2, memory=memory, threads=threads) as sweep:
            for span in align(test, keep=False).spans:
                sweep.run(span, lambda _: None)

    scored = partial(measure, test, reference, threads=threads, memory=memory)
    works: list[Callable[[], object]] = [transform, *(partial(scored, names=names or None) for names in FAMILIES)]
    # What is loaded and touched for the first time is not the measures' time.
    measure(replace(test, count=2), replace(reference, count=2), threads=threads, memory=memory)
    timings = []
    for name, work in zip(NAMES, works, strict=True):
        started = time.perf_counter()
        work()
        elapsed = time.perf_counter() - started
        peak = peak_memory()
        timings.append(Timing(name, frames / elapsed, peak))
        advance(name)
    return timings


class _Spectra:
    """A measure that does nothing with the spectra of test and error but have them made."""

    def held(self, level: Level) -> float:
        del level
        return 0.0

    def begin(self, span: Span) -> None:
        """Nothing to set up."""

    def add(self, batch: Batch) -> None:
        _ = batch.test, batch.error

    def end(self) -> None:
        """Nothing to close."""

    def finish(self) -> Measurement:
        return Measurement()
