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
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from metrics.kernels.blocks import cut_blocks
from metrics.kernels.energies import (
    following_energies,
    following_energies_of_both,
    octave_energies,
)
from metrics.kernels.fourier import tile_spectra
from metrics.kernels.host import on_cpu
from metrics.kernels.launch import Launcher
from metrics.kernels.power import strip_powers
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
        self.window = np.stack([window(size, down), window(size, right)]).astype(np.float32)
        self.weight = float(np.prod(np.sum(self.window**2, axis=1, dtype=np.float64)))
        hann = np.stack([_hann(size, down), _hann(size, right)])
        levelling = np.where(self.window > 0, hann / np.maximum(self.window, 1e-30), 0.0)
        self._levelling = (levelling / hann.sum(axis=1, keepdims=True)).astype(np.float32)
        vertical, horizontal = (each.ravel() for each in level.frequencies())
        middle = (size - 1) / 2
        scale = np.full(size // 2 + 1, np.sqrt(2.0) / size)
        scale[[0, -1]] = 1.0 / size
        turns = [np.exp(2j * np.pi * vertical * (middle + down)), np.exp(2j * np.pi * horizontal * (middle + right))]
        turns[1] *= scale
        self._turns = [np.stack([turn.real, turn.imag]).astype(np.float32) for turn in turns]
        self._corners = self.origin.astype(np.int32, order="C")

    @cached_property
    def constant(self) -> Spectrum:
        """[L, L/2 + 1], the spectrum of a constant picture of value 1."""
        ones = np.ones((1, self.size, self.size), np.float32)
        spectrum: Spectrum = self._transformed(ones, np.zeros((1, 2), np.int32))[0][0, 0]
        return spectrum

    def seen(self, planes: Picture, tiles: slice = slice(None)) -> tuple[Spectrum, Picture]:
        """What tiles show of a picture [channels, H, W].

        Returns their surface-locked spectra [n, channels, L, L/2 + 1], and [n, channels] the picture's mean in each,
        by a Hann window.
        """
        return self._transformed(planes, self._corners[tiles])

    def _transformed(self, planes: Picture, corners: NDArray[np.int32]) -> tuple[Spectrum, Picture]:
        shape = (len(corners), len(planes))
        spectra: Spectrum = np.empty((*shape, self.size, self.size // 2 + 1), np.complex64)
        mean: Picture = np.empty(shape, np.float32)
        inputs = [np.ascontiguousarray(planes), corners, self.window, self._levelling, *self._turns]
        parts = spectra.view(np.float32).reshape(-1, self.size, self.size + 2, copy=False)
        on_cpu(tile_spectra(self.size), len(parts), [*inputs, parts, mean])
        return spectra, mean

    def blocks(self, planes: Picture, tiles: slice) -> Picture:
        """Windowed blocks [n, channels, L, L] of a picture [channels, H, W]."""
        corners, channels = self._corners[tiles], len(planes)
        blocks: Picture = np.empty((len(corners), channels, self.size, self.size), np.float32)
        inputs = [np.ascontiguousarray(planes), corners, np.outer(*self.window), blocks]
        on_cpu(cut_blocks, len(corners) * channels * self.size, inputs)
        return blocks

    def power_mean(self, planes: Picture, launcher: Launcher) -> Energy:
        """[n, channels], mean of a picture [channels, H, W] over each tile, by the squared window."""
        found, window = np.empty((len(self.origin), len(planes))), np.outer(*self.window).ravel()

        def look(first: int) -> None:
            tiles = slice(first, first + _SOME)
            blocks = self.blocks(planes, tiles)
            found[tiles] = np.vecdot(blocks.reshape(*blocks.shape[:2], -1), window)

        launcher.each(range(0, len(found), _SOME), look)
        return found / self.weight


def _hann(size: int, shift: float) -> NDArray[np.float64]:
    x = np.arange(size) + 0.5 - size / 2 - shift
    return np.asarray(np.where(np.abs(x) < size / 2, np.cos(np.pi * x / size) ** 2, 0.0))


def energy(values: Spectrum) -> Energy:
    """Sum of |values|^2 over channels and both last axes of [n, channels, L, L/2 + 1], [n]."""
    return np.asarray(octave_energy(values).sum(axis=1))


def octave_energy(spectra: Spectrum) -> Energy:
    """The same by octave of |k|, [n, octaves]."""
    found = np.empty((len(spectra), 1, len(OCTAVES)))
    on_cpu(octave_energies(), len(spectra), [_flat(spectra), _octaves(spectra.shape[-2]), found])
    return found[:, 0]


def follow(spectra: Spectrum, before: Spectrum, mean: Spectrum, share: float) -> Energy:
    """Energies of spectra [n, channels, L, L/2 + 1], of their step from those before, and from their mean.

    Returns them by octave of |k|, [3, n, octaves]. In place, the mean goes a share of the way to the spectra; at 1 it
    becomes them.
    """
    found = np.empty((len(spectra), 3, len(OCTAVES)))
    inputs = [*map(_flat, (spectra, before, mean)), share, _octaves(spectra.shape[-2]), found]
    on_cpu(following_energies(), len(spectra), inputs)
    return found.swapaxes(0, 1)


def follow_both(
    spectra: Spectrum, before: Spectrum, mean: Spectrum, other: Spectrum, other_mean: Spectrum, share: float
) -> Energy:
    """The same, and of the step of other spectra from their mean, and of the difference from its: [5, n, octaves]."""
    found = np.empty((len(spectra), 5, len(OCTAVES)))
    inputs = [*map(_flat, (spectra, before, mean, other, other_mean)), share, _octaves(spectra.shape[-2]), found]
    on_cpu(following_energies_of_both(), len(spectra), inputs)
    return found.swapaxes(0, 1)


def add_power(test: Spectrum, error: Spectrum, strips: NDArray[np.int32], power: Energy) -> None:
    """Add |X(k)|^2 of test, reference and error, summed over channels and over the tiles of each strip.

    test, error: [n, channels, L, L/2 + 1]; the reference is their difference. strips: [n], of every tile. power:
    [strips, 3, L, L/2 + 1], to which it is added.
    """
    inputs = [_flat(test), _flat(error), strips, power.reshape(*power.shape[:2], -1, copy=False)]
    on_cpu(strip_powers(), len(power), inputs)


def _flat(spectra: Spectrum) -> Picture:
    """The same memory as real and imaginary parts, [n, channels, 2 bins]."""
    return spectra.view(np.float32).reshape(*spectra.shape[:2], 2 * math.prod(spectra.shape[2:]), copy=False)


@lru_cache(maxsize=8)
def _octaves(size: int) -> NDArray[np.int32]:
    """[size (size + 2)], the octave of each real or imaginary part of a half plane's bin."""
    radius = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :])
    return np.asarray(np.digitize(np.repeat(radius.ravel(), 2), OCTAVES) - 1, np.int32)
