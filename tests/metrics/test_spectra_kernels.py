"""Kernels of spectra against numpy's and scipy's plain forms, in double precision."""

import numpy as np
import pytest
from scipy import fft

from metrics.octaves import OCTAVES
from metrics.tiles import SIZES, Level
from metrics.transform import TileTransform, add_power, energy, follow, follow_both, octave_energy


@pytest.fixture(params=SIZES)
def tiles(request):
    """A transform of ten tiles at a sub-pixel place, and a picture of two channels around them."""
    random, size = np.random.default_rng(request.param), request.param
    origin = np.stack([random.integers(1, length - size, 10) for length in (97, 131)], axis=1)
    transform = TileTransform(Level(size, origin, np.ones(10, dtype=bool)), (0.31, -0.22))
    return transform, random.standard_normal((2, 98, 132), dtype=np.float32)


def spectra_of(transform, picture):
    """In double precision."""
    size = transform.size
    blocks = np.stack([picture[:, y : y + size, x : x + size] for y, x in transform.origin])
    blocks = blocks * np.outer(*transform.window.astype(np.float64))
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


def followed(spectra, other, share):
    """Energies that following gives, and the means [2] that it leaves: of the spectra, and of the other."""
    means = np.stack([0.5 * spectra, np.roll(other, 1, axis=0)])
    return follow_both(spectra, spectra[::-1].copy(), means[0], other, means[1], share), means


def test_means_follow_by_a_share_and_tell_the_way(tiles, tolerance):
    spectra, other = tiles[0].seen(tiles[1])[0], tiles[0].seen(tiles[1][::-1] ** 2)[0]
    mean, other_mean = 0.5 * spectra, np.roll(other, 1, axis=0)
    ways = [spectra - spectra[::-1], spectra - mean, other - other_mean, other - other_mean - (spectra - mean)]
    exact = [octave_energy(each) for each in (spectra, *ways)]
    found, means = followed(spectra, other, 0.25)
    assert found == pytest.approx(np.array(exact), rel=tolerance("parseval"))
    middles = [mean + np.float32(0.25) * ways[1], other_mean + np.float32(0.25) * ways[2]]
    for each, middle in zip(means, middles, strict=True):
        assert np.abs(each - middle).max() < tolerance("single precision spectra") * np.abs(middle).max()
    assert np.array_equal(followed(spectra, other, 1.0)[1], [spectra, other])


def test_spectra_are_followed_alone_as_beside_others(tiles):
    spectra, _ = tiles[0].seen(tiles[1])
    both, means = followed(spectra, spectra[::-1].copy(), 0.25)
    mean = 0.5 * spectra
    assert np.array_equal(follow(spectra, spectra[::-1].copy(), mean, 0.25), both[:3])
    assert np.array_equal(mean, means[0])


def test_power_is_added_up_by_strip(tiles, tolerance):
    test, error = tiles[0].seen(tiles[1])[0], tiles[0].seen(0.1 * tiles[1][::-1])[0]
    strips = np.arange(len(test), dtype=np.int32) % 3
    found = np.ones((3, 3, *test.shape[2:]))
    add_power(test, error, strips, found)
    for strip in range(3):
        kinds = [each[strips == strip].astype(np.complex128) for each in (test, test - error, error)]
        exact = [1 + (np.abs(kind) ** 2).sum(axis=(0, 1)) for kind in kinds]
        assert found[strip] == pytest.approx(np.array(exact), rel=tolerance("parseval"))


def test_a_state_that_is_not_whole_memory_is_refused(tiles):
    spectra = tiles[0].seen(tiles[1])[0][:, :, ::2]
    with pytest.raises(ValueError, match="copy"):
        follow(spectra, spectra, spectra, 1.0)
