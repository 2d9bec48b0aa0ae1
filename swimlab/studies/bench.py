"""How fast the measures are, on frames that cost nothing to make, and on files."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from metrics import Clip, Measurement, align, measure
from metrics.clip import FrameSource
from metrics.machine import peak_memory
from metrics.score import MEMORY
from metrics.spans import Placement, Span
from metrics.spectra import Batch, Pictures
from metrics.sweep import Sweep
from metrics.tiles import Level
from swimlab.runs.frames import read_channels, write_channels

VELOCITY = (23 / 32, 19 / 32)
TRANSFORMS = "transforms alone"
MAIN = ("budget", "residual", "plane")
FAMILIES = (("budget",), ("residual",), ("plane",), MAIN, ())
"""Scores that are timed together; the last is all of them."""
PIXEL, FILES = "a vector a pixel", "from files"
NAMES = (
    TRANSFORMS,
    *(", ".join(names) or "all" for names in FAMILIES),
    f"all, {PIXEL}",
    f"all, {FILES}",
    f"all, {PIXEL}, {FILES}",
)

ZOOM = 5e-4
"""Share by which the picture grows in a frame where every pixel has a vector of its own."""


@dataclass(frozen=True)
class Timing:
    """Frames a second of what is named, the median of some rounds with the slowest and the fastest, and the process's
    peak memory, bytes, when it was done first."""

    name: str
    frames_per_second: float
    slowest: float
    fastest: float
    peak_memory: int


def time_measures(
    width: int,
    height: int,
    frames: int,
    *,
    rounds: int = 1,
    threads: int | None = None,
    memory: float | None = None,
    advance: Callable[[str], None] = lambda _: None,
) -> list[Timing]:
    """Time the measures on a wholly covered clip of noise, test against reference.

    It moves uniformly, or grows too; frames are in memory, or read from EXR files of halves in a temporary folder. The
    noise is cut from one larger picture, so that making a frame costs a copy. In each of the `rounds` all take turns.
    `memory` is what `measure` may take; `advance` is called with the names timed. The first timing is of the tiles'
    windows and Fourier transforms, without which there is no measure.
    """
    rng = np.random.default_rng(0)
    pool = rng.random((height + frames, width + frames, 3), np.float32)
    still = rng.random((height, width, 3), np.float32)
    grown = growing(width, height)
    made = Clips(lambda t: pool[t : t + height, t : t + width], lambda _: still, lambda _: grown, frames)

    def transform() -> None:
        test, reference = made.pair()

        def read(place: Placement) -> Pictures:
            picture = test.planes(place.t)
            return Pictures(picture, picture - reference.planes(place.t))

        with Sweep([_Spectra()], read, pictures=2, memory=memory or MEMORY, threads=threads) as sweep:
            for span in align(test, keep=False).spans:
                sweep.run(span, lambda _: None, lambda _: None)

    scored = partial(measure, threads=threads, memory=memory)
    # What is loaded and touched for the first time is not the measures' time.
    for unwarped in (False, True):
        scored(*replace(made, count=2).pair(unwarped=unwarped))
    with TemporaryDirectory() as folder:
        stored = made.written(Path(folder))
        works: list[Callable[[], object]] = [
            transform,
            *(partial(scored, *made.pair(), names=names or None) for names in FAMILIES),
            partial(scored, *made.pair(unwarped=True)),
            partial(scored, *stored.pair()),
            partial(scored, *stored.pair(unwarped=True)),
        ]
        speeds: dict[str, list[float]] = {name: [] for name in NAMES}
        peaks: dict[str, int] = {}
        for _ in range(rounds):
            for name, work in zip(NAMES, works, strict=True):
                started = time.perf_counter()
                work()
                speeds[name].append(frames / (time.perf_counter() - started))
                peaks.setdefault(name, peak_memory())
                advance(name)
    return [Timing(name, median(each), min(each), max(each), peaks[name]) for name, each in speeds.items()]


@dataclass(frozen=True)
class Clips:
    """Where a test, its reference and their motion come from."""

    test: FrameSource
    reference: FrameSource
    motion: FrameSource
    count: int

    def pair(self, *, unwarped: bool = False) -> tuple[Clip, Clip]:
        """Test and reference, with one motion for all pixels or a vector for each."""
        motion = self.motion if unwarped else VELOCITY
        return Clip(self.test, self.count, motion=motion), Clip(self.reference, self.count, motion=motion)

    def written(self, folder: Path) -> "Clips":
        """The same from files that are written into a folder."""
        colour, vector = ("R", "G", "B"), ("X", "Y")
        for t in range(self.count):
            for name, source in (("test", self.test), ("reference", self.reference)):
                write_channels(folder / f"{name}.{t:04d}.exr", source(t), colour, half=True, metadata={})
            write_channels(folder / f"motion.{t:04d}.exr", self.motion(t), vector, half=False, metadata={})
        return Clips(
            lambda t: read_channels(folder / f"test.{t:04d}.exr", colour),
            lambda t: read_channels(folder / f"reference.{t:04d}.exr", colour),
            lambda t: read_channels(folder / f"motion.{t:04d}.exr", vector),
            self.count,
        )


def growing(width: int, height: int) -> NDArray[np.float32]:
    """[H, W, 2], a motion by VELOCITY of a picture that grows about its middle."""
    row, column = np.indices((height, width), dtype=np.float32)
    away = np.stack([column - width / 2, row - height / 2], axis=2)
    return np.asarray(VELOCITY + ZOOM * away, np.float32)


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
        """Nothing was found."""

    def take(self, found: None) -> None:
        """Nothing to add."""

    def finish(self) -> Measurement:
        return Measurement()
