"""Surface-locked spectra: the one transform that carries all measures.

A tile's window rides with the surface at its sub-pixel place c, evaluated analytically; the tile's spectrum is
multiplied by exp(2 pi i k.(c - o)), o the first pixel of the block that was transformed. A pattern glued to the
surface then has the *same* spectrum in every frame, with no pixel interpolated.

Spectra are scaled so that, by Parseval, the plain sum of |X(k)|^2 over the stored half plane is the sum of
w^2 x^2 over the tile's pixels: columns that stand for k and -k carry sqrt(2). Content exactly at the pixel
Nyquist cannot be locked, since +1/2 and -1/2 share a bin; those bins are kept, with the phase of -1/2 (rows)
or +1/2 (columns), so that energies stay exact.

Pictures and spectra are held in single precision, which costs 1e-7 of an amplitude; sums are taken in double.
"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from metrics.octaves import OCTAVES
from metrics.tiles import Level, split, window

# Tiles that are looked at together where there are no batches.
_SOME = 32

Spectrum = NDArray[np.complex64]
Picture = NDArray[np.float32]
Energy = NDArray[np.float64]


class TileTransform:
    """Windows, phases and scale of one level at one place of the surface."""

    def __init__(self, level: Level, offset: tuple[float, float], first_row: int = 0) -> None:
        size = level.size
        whole, (down, right) = split(offset)
        self.origin = level.origin + np.array(whole) - np.array([first_row, 0])
        self.size = size
        self.window = (window(size, down)[:, None] * window(size, right)[None, :]).astype(np.float32)
        self.weight = float(np.sum(self.window**2, dtype=np.float64))
        hann = _hann(size, down)[:, None] * _hann(size, right)[None, :]
        levelling = np.where(self.window > 0, hann / np.maximum(self.window, 1e-30), 0.0) / hann.sum()
        self._levelling = levelling.astype(np.float32).ravel()
        vertical, horizontal = level.frequencies()
        middle = (size - 1) / 2
        scale = np.full(size // 2 + 1, np.sqrt(2.0))
        scale[[0, -1]] = 1.0
        turn = np.exp(2j * np.pi * (vertical * (middle + down) + horizontal * (middle + right)))
        self.phase: Spectrum = (turn * scale / size).astype(np.complex64)
        self.constant = self.spectra(self.window)

    def blocks(self, planes: Picture, tiles: slice) -> Picture:
        """Windowed blocks [n, 3, L, L] of a picture [3, H, W]."""
        channels, height, width = planes.shape
        # All blocks that there are, [y, x, channel, row, column]: as sliding_window_view, in a tenth of its time.
        places = (height - self.size + 1, width - self.size + 1)
        down, right = planes.strides[1:]
        every = np.ndarray(
            (*places, channels, self.size, self.size), planes.dtype, planes, 0, (down, right, *planes.strides)
        )
        y, x = self.origin[tiles].T
        blocks: Picture = every[y, x]
        blocks *= self.window
        return blocks

    def power_mean(self, planes: Picture) -> Energy:
        """[n, channels], mean of a picture [channels, H, W] over each tile, by the squared window."""
        found = np.empty((len(self.origin), len(planes)))
        for first in range(0, len(found), _SOME):
            tiles = slice(first, first + _SOME)
            blocks = self.blocks(planes, tiles)
            found[tiles] = np.vecdot(blocks.reshape(*blocks.shape[:2], -1), self.window.ravel())
        return found / self.weight

    def mean(self, blocks: Picture) -> Energy:
        """[n, 3], Hann-weighted mean of each windowed block's picture."""
        flat = blocks.reshape(*blocks.shape[:2], -1)
        return np.asarray(np.vecdot(flat, self._levelling), dtype=np.float64)

    def spectra(self, blocks: Picture) -> Spectrum:
        """Surface-locked spectra of windowed blocks."""
        spectra: Spectrum = fft.rfft2(blocks)
        spectra *= self.phase
        return spectra


def _hann(size: int, shift: float) -> NDArray[np.float64]:
    x = np.arange(size) + 0.5 - size / 2 - shift
    return np.asarray(np.where(np.abs(x) < size / 2, np.cos(np.pi * x / size) ** 2, 0.0))


def energy(values: Picture | Spectrum) -> Energy:
    """Sum of |values|^2 over channels and both last axes, [n]."""
    real = _flat(values)
    return np.asarray(np.vecdot(real, real).sum(axis=1, dtype=np.float64))


def _flat(values: Picture | Spectrum) -> Picture:
    """Real and imaginary parts, [n, channels, parts]."""
    flat = np.ascontiguousarray(values).reshape(*values.shape[:2], math.prod(values.shape[2:]))
    return flat.view(np.float32)


def octave_energy(spectra: Spectrum) -> Energy:
    """The same by octave of |k|, [n, octaves]."""
    parts = squares(spectra)
    return np.stack([np.vecdot(parts, member) for member in _members(spectra.shape[-2])], axis=1).astype(np.float64)


def octave_sum(squared: Picture, size: int) -> Energy:
    """[octaves], the energy of squares [n, 2 bins] of tiles of one size, all together."""
    return np.asarray(np.vecdot(_members(size), squared.sum(axis=0)), dtype=np.float64)


def squares(spectra: Spectrum) -> Picture:
    """Squared real and imaginary parts, in turns, summed over channels, [n, 2 bins]."""
    real = _flat(spectra)
    return np.asarray(np.einsum("ncp,ncp->np", real, real))


@lru_cache(maxsize=8)
def _members(size: int) -> Picture:
    """[octaves, size (size + 2)], 1 where a real or imaginary part of a half plane's bin is in an octave."""
    radius = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :])
    octave = np.digitize(np.repeat(radius.ravel(), 2), OCTAVES) - 1
    return np.asarray(octave == np.arange(len(OCTAVES))[:, None], dtype=np.float32)
