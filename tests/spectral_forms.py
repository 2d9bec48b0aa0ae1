"""What runs the native forms that make spectra and follow them, each on inputs of its own."""

import numpy as np
import warp as wp


def transformed(launcher, shoot, transform, size):
    """A tile of two channels, beside the corner of a picture."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        picture: wp.array3d(dtype=wp.float32),
        corners: wp.array2d(dtype=wp.int32),
        window: wp.array2d(dtype=wp.float32),
        levelling: wp.array2d(dtype=wp.float32),
        down: wp.array2d(dtype=wp.float32),
        right: wp.array2d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        mean: wp.array2d(dtype=wp.float32),
    ):
        transform(wp.tid(), picture, corners, window, levelling, down, right, spectra, mean)

    random = np.random.default_rng(size)
    shapes = ((2, size + 3, size + 5), (2, size), (2, size), (2, size), (2, size // 2 + 1))
    picture, *rest = (random.uniform(-1, 1, shape).astype(np.float32) / size for shape in shapes)
    spectra, mean = np.zeros((2, size, size + 2), np.float32), np.zeros((1, 2), np.float32)
    launcher.launch(kernel, 2, [picture, np.array([[3, 4]], np.int32), *rest, spectra, mean])
    yield from (spectra / np.abs(spectra).max(), mean / np.abs(mean).max())


def spectra_and_octaves():
    """Of three tiles of two channels; the octaves of some parts are all one."""
    random = np.random.default_rng(0)
    octaves = np.concatenate([np.full(32, 4), random.integers(0, 6, 32)]).astype(np.int32)
    return random.random((3, 2, 64), np.float32), octaves


def summed(launcher, shoot, add, width):
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        add(wp.tid(), spectra, octaves, energies)

    energies = np.zeros((3, 1, 6))
    launcher.launch(kernel, 3, [*spectra_and_octaves(), energies])
    yield energies


def followed(launcher, shoot, follow, width):
    """A mean that goes a part of the way, and all of it."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        mean: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        follow(wp.tid(), spectra, before, mean, share, octaves, energies)

    spectra, octaves = spectra_and_octaves()
    for share in (0.3, 1.0):
        mean, energies = np.full_like(spectra, 0.5), np.zeros((3, 3, 6))
        launcher.launch(kernel, 3, [spectra, 0.7 * spectra, mean, share, octaves, energies])
        yield from (mean, energies)


def followed_both(launcher, shoot, follow, width):
    """The same beside others."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        mean: wp.array3d(dtype=wp.float32),
        other: wp.array3d(dtype=wp.float32),
        other_mean: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array3d(dtype=wp.float64),
    ):
        follow(wp.tid(), spectra, before, mean, other, other_mean, share, octaves, energies)

    spectra, octaves = spectra_and_octaves()
    for share in (0.3, 1.0):
        mean, other_mean, energies = 0.9 * spectra, spectra[::-1].copy(), np.zeros((3, 5, 6))
        inputs = [spectra, 0.7 * spectra, mean, 1 - spectra, other_mean, share, octaves, energies]
        launcher.launch(kernel, 3, inputs)
        yield from (mean, other_mean, energies)


def by_strip(launcher, shoot, add, width):
    """Three tiles of two strips."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        test: wp.array3d(dtype=wp.float32),
        error: wp.array3d(dtype=wp.float32),
        strips: wp.array(dtype=wp.int32),
        power: wp.array3d(dtype=wp.float64),
    ):
        add(wp.tid(), test, error, strips, power)

    test, power = spectra_and_octaves()[0], np.zeros((2, 3, 32))
    launcher.launch(kernel, 2, [test, 0.3 * test[::-1], np.array([0, 1, 0], np.int32), power])
    yield power


def laid_over(launcher, shoot, add, width):
    """Rows of a picture that one block crosses, and rows that two do, one over the other."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        corners: wp.array2d(dtype=wp.int32), square: wp.array2d(dtype=wp.float64), total: wp.array2d(dtype=wp.float64)
    ):
        y = 2 + wp.tid()
        add(y, 0, wp.where(y < 4, 1, 2), corners, square, total)

    random, total = np.random.default_rng(0), np.zeros((9, 31))
    launcher.launch(kernel, 4, [np.array([[2, 3], [4, 11]], np.int32), random.random((6, 17)), total])
    assert (total > 0).sum() == 2 * 17 + 2 * 25
    yield total


RUNS = {
    ("y", "begin", "end", "corners", "square", "total"): laid_over,
    ("index", "picture", "corners", "window", "levelling", "down", "right", "spectra", "mean"): transformed,
    ("tile", "spectra", "octaves", "energies"): summed,
    ("tile", "spectra", "before", "mean", "share", "octaves", "energies"): followed,
    ("tile", "spectra", "before", "mean", "other", "other_mean", "share", "octaves", "energies"): followed_both,
    ("strip", "test", "error", "strips", "power"): by_strip,
}
"""Parameters of a form -> what runs it."""
