"""The spectra of a clip's tiles, frame by frame, as measures take them in."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from metrics.octaves import OCTAVES
from metrics.parts import pieces
from metrics.spans import Span
from metrics.transform import Energy, Picture, Spectrum, TileTransform, follow, octave_energy


@dataclass(frozen=True)
class Pictures:
    """One frame aligned to a span, each picture [3, H, W]: the test, and with a reference the test minus it.

    half_difference: (A - B)/2 of two halves of the reference's samples, if it is known.
    """

    test: Picture
    error: Picture | None = None
    half_difference: Picture | None = None


@dataclass(frozen=True)
class Batch:
    """Some tiles of one level in one frame.

    piece: which of the span's pieces. tiles: which of the level's tiles. What no measure asks for is not made.
    """

    frame: int
    level: int
    piece: int
    tiles: slice
    pictures: Pictures
    transform: TileTransform

    @property
    def weight(self) -> float:
        """Sum of w^2 of one tile."""
        return self.transform.weight

    @property
    def level_spectrum(self) -> Spectrum:
        """[L, L/2 + 1], the spectrum of a constant picture of value 1."""
        return self.transform.constant

    @cached_property
    def test(self) -> Spectrum:
        """[n, 3, L, L/2 + 1]."""
        return self._seen[0]

    @cached_property
    def error(self) -> Spectrum | None:
        """The same of the test minus the reference, if there is one."""
        error = self.pictures.error
        return None if error is None else self.transform.seen(error, self.tiles)[0]

    @cached_property
    def reference(self) -> Spectrum | None:
        return None if self.error is None else self.test - self.error

    @property
    def mean(self) -> Picture:
        """[n, 3], mean level of the test's tiles under a Hann window, which shuts out what is not level best."""
        return self._seen[1]

    @property
    def floor_energy(self) -> Energy | None:
        """[n], sum of w^2 x^2 of the reference's half-difference from pixels, if it is known."""
        half = self.pictures.half_difference
        if half is None:
            return None
        blocks = self.transform.blocks(half, self.tiles).reshape(self.tiles.stop - self.tiles.start, -1)
        return np.asarray(np.vecdot(blocks, blocks), dtype=np.float64)

    @cached_property
    def _seen(self) -> tuple[Spectrum, Picture]:
        return self.transform.seen(self.pictures.test, self.tiles)


def transforms(span: Span, t: int) -> list[TileTransform]:
    """What frame t's tiles are transformed with, for every level."""
    return [TileTransform(level, span.offsets[t - span.start], span.rows.start) for level in span.levels]


def batches(span: Span, t: int, pictures: Pictures) -> Iterator[Batch]:
    """All tiles of frame t, piece by piece."""
    transform = transforms(span, t)
    for number, piece in enumerate(pieces(span)):
        yield Batch(t, piece.level, number, piece.tiles, pictures, transform[piece.level])


class RunningMean:
    """Mean over time of locked spectra, and the energy of the variation about it (Welford 1962).

    mean: for every level [n, 3, L, L/2 + 1]. varied: for every level [n, octaves], sum over frames of |X - mean|^2.
    """

    def __init__(self, span: Span) -> None:
        self.mean = [np.zeros((level.count, 3, *level.spectrum_shape), dtype=np.complex64) for level in span.levels]
        self.varied = [np.zeros((level.count, len(OCTAVES))) for level in span.levels]
        self._start, self._left = span.start, span.left

    def add(self, batch: Batch, spectra: Spectrum) -> None:
        """Take in the next frame's spectra of the batch's tiles."""
        seen = batch.frame - self._start + 1
        away = follow(self.mean[batch.level][batch.tiles], spectra, 1 / seen)
        if seen > 1:
            self.varied[batch.level][batch.tiles] += away * ((seen - 1) / seen)

    def split(self, level: int, count: int) -> tuple[Energy, Energy]:
        """Energies over `count` frames of what is static and of what varies, each [n, octaves].

        They add up to the whole, and what unwarping took is given back. By Bessel's correction what varies
        independently from frame to frame, such as noise, has no static part on average (which may make a static energy
        negative by chance); without it 1 / count.
        """
        varied = self.varied[level]
        excess = varied / max(1, count - 1)
        left = 1.0 if self._left is None else self._left[level]
        return (count * octave_energy(self.mean[level]) - excess) / left, (varied + excess) / left
