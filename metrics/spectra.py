"""The spectra of a clip's tiles, frame by frame, as measures take them in."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from metrics.octaves import OCTAVES
from metrics.parts import pieces
from metrics.spans import Span
from metrics.transform import Energy, Picture, Spectrum, TileTransform, energy, octave_energy, squares


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
        return self.transform.spectra(self._seen)

    @cached_property
    def error(self) -> Spectrum | None:
        """The same of the test minus the reference, if there is one."""
        return None if self._wrong is None else self.transform.spectra(self._wrong)

    @cached_property
    def reference(self) -> Spectrum | None:
        return None if self.error is None else self.test - self.error

    @cached_property
    def error_squares(self) -> Picture | None:
        """Of the error's spectra the squared real and imaginary parts, in turns, summed over channels, [n, 2 bins]."""
        return None if self.error is None else squares(self.error)

    @cached_property
    def mean(self) -> Energy:
        """[n, 3], mean level of the test's tiles under a Hann window, which shuts out what is not level best."""
        return self.transform.mean(self._seen)

    @property
    def pixel_energy(self) -> Energy | None:
        """[n], sum of w^2 e^2 from pixels, if there is a reference."""
        return None if self._wrong is None else energy(self._wrong)

    @property
    def floor_energy(self) -> Energy | None:
        """[n], the same of the reference's half-difference, if it is known."""
        half = self.pictures.half_difference
        return None if half is None else energy(self.transform.blocks(half, self.tiles))

    @cached_property
    def _seen(self) -> Picture:
        return self.transform.blocks(self.pictures.test, self.tiles)

    @cached_property
    def _wrong(self) -> Picture | None:
        error = self.pictures.error
        return None if error is None else self.transform.blocks(error, self.tiles)


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

    mean: for every level [n, 3, L, L/2 + 1]. varied: for every level, sum over frames of |X - mean|^2: [n], or
    [n, octaves], as it is where unwarping takes some of the energy of octaves.
    """

    def __init__(self, span: Span, *, octaves: bool = False) -> None:
        octaves = octaves or span.left is not None
        self.mean = [np.zeros((level.count, 3, *level.spectrum_shape), dtype=np.complex64) for level in span.levels]
        self.varied = [np.zeros((level.count, len(OCTAVES)) if octaves else level.count) for level in span.levels]
        self._energy = octave_energy if octaves else energy
        self._start, self._left = span.start, span.left

    def add(self, batch: Batch, spectra: Spectrum) -> None:
        """Take in the next frame's spectra of the batch's tiles."""
        seen = batch.frame - self._start + 1
        mean = self.mean[batch.level][batch.tiles]
        away = spectra - mean
        if seen > 1:
            self.varied[batch.level][batch.tiles] += self._energy(away) * ((seen - 1) / seen)
        away *= np.float32(1 / seen)
        mean += away

    def split(self, level: int, count: int) -> tuple[Energy, Energy]:
        """Energies over `count` frames of what is static and of what varies, each [n], or [n, octaves].

        They add up to the whole, and what unwarping took is given back. By Bessel's correction what varies
        independently from frame to frame, such as noise, has no static part on average (which may make a static energy
        negative by chance); without it 1 / count.
        """
        varied = self.varied[level]
        excess = varied / max(1, count - 1)
        left = 1.0 if self._left is None else self._left[level]
        return (count * self._energy(self.mean[level]) - excess) / left, (varied + excess) / left
