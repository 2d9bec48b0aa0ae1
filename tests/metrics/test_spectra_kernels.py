"""Kernels of spectra against numpy's and scipy's plain forms, in double precision."""

import numpy as np
import pytest
from scipy import fft

from metrics.octaves import OCTAVES
from metrics.tiles import SIZES, Level
from metrics.transform import TileTransform, bin_energy, energy, follow, octave_energy


@pytest.fixture(params=SIZES)
def tiles(request):
    """A transform of ten tiles at a sub-pixel place, and a picture of two channels around them."""
    random, size = np.random.default_rng(request.param), request.param
    origin = np.stack([random.integers(1, length - size, 10) for length in (97, 131)], axis=1)
    transform = TileTransform(Level(size, origin, np.ones(10, dtype=bool)), (0.31, -0.22))
    return transform, random.standard_normal((2, 98, 132), dtype=np.float32)


def spectra_of(transform, picture):
    """In double precision."""
    blocks = transform.blocks(picture.astype(np.float64), slice(None))
    size = transform.size
    k = np.meshgrid(np.fft.fftfreq(size), np.fft.rfftfreq(size), indexing="ij")
    twice = np.where(np.isin(np.arange(size // 2 + 1), (0, size // 2)), 1, np.sqrt(2))
    turn = np.exp(2j * np.pi * (k[0] * ((size - 1) / 2 + 0.31) + k[1] * ((size - 1) / 2 - 0.22)))
    return fft.rfft2(blocks) * turn * twice / size


def test_tiles_are_transformed_as_scipy_does_it(tiles, tolerance):
    transform, picture = tiles
    seen, _ = transform.seen(picture)
    exact = spectra_of(transform, picture)
    off = np.abs(seen - exact)
    assert off.max() < tolerance("single precision spectra") * np.abs(exact).max()
    some, _ = transform.seen(picture, slice(3, 7))
    assert np.array_equal(some, seen[3:7])


def test_a_picture_of_zeros_has_a_spectrum_of_zeros(tiles):
    transform, picture = tiles
    spectra, mean = transform.seen(np.zeros_like(picture))
    assert not spectra.any()
    assert not mean.any()


def test_the_mean_of_a_constant_picture_is_the_constant(tiles, tolerance):
    transform, picture = tiles
    _, mean = transform.seen(np.full_like(picture, 0.7))
    assert mean == pytest.approx(0.7, rel=tolerance("single precision spectra"))


def test_energies_are_sums_of_squares_by_octave(tiles, tolerance):
    spectra, _ = tiles[0].seen(tiles[1])
    squares = np.abs(spectra.astype(np.complex128)) ** 2
    size = spectra.shape[-2]
    octave = np.digitize(np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :]), OCTAVES) - 1
    exact = np.stack([squares[..., octave == number].sum(axis=(1, 2)) for number in range(len(OCTAVES))], axis=1)
    close = {"rel": tolerance("parseval")}
    assert octave_energy(spectra) == pytest.approx(exact, **close)
    assert energy(spectra) == pytest.approx(exact.sum(axis=1), **close)
    assert bin_energy(spectra) == pytest.approx(squares.sum(axis=1), **close)


def test_a_state_follows_by_a_share_and_tells_the_way(tiles, tolerance):
    spectra, _ = tiles[0].seen(tiles[1])
    state = spectra[::-1].copy()
    away = spectra - state
    middle = state + np.float32(0.25) * away
    assert follow(state, spectra, 0.25) == pytest.approx(octave_energy(away), rel=tolerance("parseval"))
    assert np.abs(state - middle).max() < tolerance("single precision spectra") * np.abs(middle).max()
    follow(state, spectra, 1.0)
    assert np.array_equal(state, spectra)


def test_a_state_that_is_not_whole_memory_is_refused(tiles):
    spectra, _ = tiles[0].seen(tiles[1])
    with pytest.raises(ValueError, match="copy"):
        follow(spectra[:, :, ::2], spectra[:, :, ::2], 1.0)
