"""Surface-locked spectra: the one transform that carries all measures.

A tile's window rides with the surface at its sub-pixel place c, evaluated analytically; the tile's spectrum is
multiplied by exp(2 pi i k.(c - o)), o the first pixel of the block that was transformed. A pattern glued to the
surface then has the *same* spectrum in every frame, with no pixel interpolated.

Spectra are scaled so that, by Parseval, the plain sum of |X(k)|^2 over the stored half plane is the sum of
w^2 x^2 over the tile's pixels: columns that stand for k and -k carry sqrt(2). Content exactly at the pixel
Nyquist cannot be locked, since +1/2 and -1/2 share a bin; those bins are kept, with the phase of -1/2 (rows)
or +1/2 (columns), so that energies stay exact.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrics.spans import Span
from metrics.tiles import Level, split, window

# Pixels transformed at a time: small enough that all work on a batch stays in the cache.
BATCH = 2**16

Spectrum = NDArray[np.complex128]
Energy = NDArray[np.float64]


@dataclass(frozen=True)
class Batch:
    """Some tiles of one level in one frame.

    tiles: which of the level's tiles. weight: sum of w^2 of one tile.
    level_spectrum: [L, L/2 + 1], the spectrum of a constant picture of value 1.
    test, error: [n, 3, L, L/2 + 1]; error is None without a reference.
    mean: [n, 3], mean level of the test's tiles under a Hann window, which shuts out what is not level best.
    pixel_energy: [n, 3], sum of w^2 e^2 from pixels. floor_energy: the same of the reference's half-difference.
    """

    frame: int
    level: int
    tiles: slice
    weight: float
    level_spectrum: Spectrum
    test: Spectrum
    mean: Energy
    error: Spectrum | None
    pixel_energy: Energy | None
    floor_energy: Energy | None

    @property
    def reference(self) -> Spectrum | None:
        return None if self.error is None else self.test - self.error


class TileTransform:
    """Windows, phases and scale of one level at one place of the surface."""

    def __init__(self, level: Level, offset: tuple[float, float]) -> None:
        size = level.size
        whole, (down, right) = split(offset)
        self.origin = level.origin + np.array(whole)
        self.size = size
        self.window = window(size, down)[:, None] * window(size, right)[None, :]
        self.weight = float(np.sum(self.window**2))
        hann = _hann(size, down)[:, None] * _hann(size, right)[None, :]
        self._levelling = np.where(self.window > 0, hann / np.maximum(self.window, 1e-300), 0.0) / hann.sum()
        vertical, horizontal = level.frequencies()
        middle = (size - 1) / 2
        scale = np.full(size // 2 + 1, np.sqrt(2.0))
        scale[[0, -1]] = 1.0
        turn = np.exp(2j * np.pi * (vertical * (middle + down) + horizontal * (middle + right)))
        self.phase: Spectrum = turn * scale / size

    def blocks(self, planes: NDArray[np.float64], tiles: slice) -> NDArray[np.float64]:
        """Windowed blocks [n, 3, L, L] of a picture [3, H, W]."""
        view = np.lib.stride_tricks.sliding_window_view(planes, (self.size, self.size), axis=(1, 2))
        y, x = self.origin[tiles].T
        blocks: NDArray[np.float64] = view.transpose(1, 2, 0, 3, 4)[y, x]
        blocks *= self.window
        return blocks

    def mean(self, blocks: NDArray[np.float64]) -> NDArray[np.float64]:
        """[n, 3], Hann-weighted mean of each windowed block's picture."""
        return np.asarray(blocks.reshape(*blocks.shape[:2], -1) @ self._levelling.ravel())

    def spectra(self, blocks: NDArray[np.float64]) -> Spectrum:
        """Surface-locked spectra of windowed blocks."""
        from scipy import fft

        spectra: Spectrum = fft.rfft2(blocks)
        spectra *= self.phase
        return spectra


def _hann(size: int, shift: float) -> NDArray[np.float64]:
    x = np.arange(size) + 0.5 - size / 2 - shift
    return np.asarray(np.where(np.abs(x) < size / 2, np.cos(np.pi * x / size) ** 2, 0.0))


def energy(values: NDArray[np.float64] | Spectrum) -> NDArray[np.float64]:
    """Sum of |values|^2 over the last two axes."""
    flat = np.ascontiguousarray(values).reshape(*values.shape[:-2], values.shape[-2] * values.shape[-1])
    real = flat.view(np.float64)
    return np.asarray(np.einsum("...i,...i->...", real, real))


def batches(
    span: Span,
    t: int,
    *,
    test: NDArray[np.float64],
    error: NDArray[np.float64] | None,
    half_difference: NDArray[np.float64] | None,
) -> Iterator[Batch]:
    """All tiles of frame t, batch by batch. Pictures are [3, H, W]."""
    test = span.align(test, t)
    error = None if error is None else span.align(error, t)
    half_difference = None if half_difference is None else span.align(half_difference, t)
    for index, level in enumerate(span.levels):
        transform = TileTransform(level, span.offsets[t - span.start])
        constant = transform.spectra(transform.window)
        step = max(1, BATCH // level.size**2)
        for first in range(0, level.count, step):
            tiles = slice(first, min(first + step, level.count))
            wrong = None if error is None else transform.blocks(error, tiles)
            noise = None if half_difference is None else transform.blocks(half_difference, tiles)
            seen = transform.blocks(test, tiles)
            yield Batch(
                frame=t,
                level=index,
                tiles=tiles,
                weight=transform.weight,
                level_spectrum=constant,
                test=transform.spectra(seen),
                mean=transform.mean(seen),
                error=None if wrong is None else transform.spectra(wrong),
                pixel_energy=None if wrong is None else energy(wrong),
                floor_energy=None if noise is None else energy(noise),
            )


class RunningMean:
    """Mean over time of locked spectra, and the energy of the variation about it (Welford 1962).

    mean: for every level [n, 3, L, L/2 + 1]. varied: for every level [n], sum over frames of |X - mean|^2.
    """

    def __init__(self, span: Span) -> None:
        self.mean = [np.zeros((lv.count, 3, *lv.spectrum_shape), dtype=np.complex128) for lv in span.levels]
        self.varied = [np.zeros(level.count) for level in span.levels]
        self._start = span.start

    def add(self, batch: Batch, spectra: Spectrum) -> None:
        """Take in the next frame's spectra of the batch's tiles."""
        seen = batch.frame - self._start + 1
        mean = self.mean[batch.level][batch.tiles]
        away = spectra - mean
        self.varied[batch.level][batch.tiles] += energy(away).sum(axis=1) * ((seen - 1) / seen)
        away /= seen
        mean += away
