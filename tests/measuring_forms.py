"""What runs the forms of measuring, each on inputs of its own; `test_native_forms.py` compares what they yield."""

import numpy as np
import warp as wp

from metrics.kernels.splines import LINES, VECTORS


def filtered(launcher, shoot, filter, width):
    """Lines of many lengths, also shorter than the recursions look ahead, of which not all fill a group."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(values: wp.array2d(dtype=VECTORS[width])):
        filter(LINES * wp.tid(), values)

    for count, length in ((LINES + 3, 70), (2, 9), (1, 1)):
        random = np.random.default_rng(0).random((count, length, width), np.float32)
        values = launcher.array(random, VECTORS[width])
        launcher.launch(kernel, -(-count // LINES), [values])
        assert (values.numpy() != random).any()
        yield values.numpy()


def looked_up(launcher, shoot, take, width):
    """Places all over a field, and far beyond it."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(field: wp.array2d(dtype=wp.vec2), away: wp.array(dtype=wp.vec2), found: wp.array(dtype=wp.vec2)):
        found[wp.tid()] = take(field, 4, 9, away[wp.tid()])

    random = np.random.default_rng(0)
    field = launcher.array(random.random((11, 17, 2), np.float32), wp.vec2)
    away, found = launcher.array(random.uniform(-30, 30, (500, 2)), wp.vec2), launcher.zeros(500, wp.vec2)
    launcher.launch(kernel, 500, [field, away, found])
    assert found.numpy().std() > 0.05
    yield found.numpy()


def unwarped(launcher, shoot, unwarp, width):
    """Rows of a picture, some pixels of which are not usable."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        picture: wp.array2d(dtype=wp.vec4),
        away: wp.array2d(dtype=wp.vec2),
        usable: wp.array2d(dtype=wp.uint8),
        seen: wp.array3d(dtype=wp.float32),
    ):
        unwarp(wp.tid(), picture, away, usable, 5, seen)

    random = np.random.default_rng(0)
    usable = random.random((9, 40)) < 0.7
    inputs = [
        launcher.array(random.random((30, 40, 4), np.float32), wp.vec4),
        launcher.array(random.uniform(-20, 20, (9, 40, 2)), wp.vec2),
        launcher.array(usable.view(np.uint8), wp.uint8),
    ]
    for channels in (1, 3):
        seen = launcher.empty((channels, 9, 40), wp.float32)
        launcher.launch(kernel, 9, [*inputs, seen])
        assert not seen.numpy()[:, ~usable].any()
        assert seen.numpy()[:, usable].all()
        yield seen.numpy()


def interleaved(launcher, shoot, interleave, width):
    """Pictures of one and of three planes."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(planes: wp.array3d(dtype=wp.float32), picture: wp.array2d(dtype=wp.vec4)):
        interleave(wp.tid(), planes, picture)

    for channels in (1, 3):
        planes = np.random.default_rng(0).random((channels, 3, 7), np.float32)
        picture = launcher.empty((3, 7), wp.vec4)
        launcher.launch(kernel, 3, [launcher.array(planes, wp.float32), picture])
        assert np.array_equal(np.moveaxis(picture.numpy(), 2, 0)[:channels], planes)
        yield picture.numpy()


def waves(launcher, shoot, sum_waves, width):
    """Three waves, seen at places up to 100 px away."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        across: wp.array2d(dtype=wp.float32),
        along: wp.array2d(dtype=wp.float32),
        frequency: wp.array(dtype=wp.vec2),
        away: wp.array2d(dtype=wp.vec2),
        values: wp.array2d(dtype=wp.float32),
    ):
        sum_waves(wp.tid(), across, along, frequency, 0.5, away, values)

    random = np.random.default_rng(0)
    turns = [launcher.array(random.random(shape, np.float32), wp.float32) for shape in ((3, 50), (3, 4))]
    places = launcher.array(random.uniform(-100, 100, (4, 50, 2)), wp.vec2)
    values = launcher.empty((4, 50), wp.float32)
    launcher.launch(kernel, 4, [*turns, launcher.array(random.uniform(-0.1, 0.1, (3, 2)), wp.vec2), places, values])
    yield values.numpy()


def transformed(launcher, shoot, transform, size):
    """A tile of two channels, beside the corner of a picture."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        picture: wp.array3d(dtype=wp.float32),
        corners: wp.array2d(dtype=wp.int32),
        window: wp.array2d(dtype=wp.float32),
        levelling: wp.array2d(dtype=wp.float32),
        phase: wp.array3d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        mean: wp.array2d(dtype=wp.float32),
    ):
        transform(wp.tid(), picture, corners, window, levelling, phase, spectra, mean)

    random = np.random.default_rng(size)
    shapes = ((2, size + 3, size + 5), (size, size), (size, size), (2, size, size // 2 + 1))
    picture, *rest = (random.uniform(-1, 1, shape).astype(np.float32) / size for shape in shapes)
    spectra, mean = np.zeros((2, size, size + 2), np.float32), np.zeros((1, 2), np.float32)
    launcher.launch(kernel, 2, [picture, np.array([[3, 4]], np.int32), *rest, spectra, mean])
    yield from (spectra / np.abs(spectra).max(), mean / np.abs(mean).max())


def spectra_and_octaves():
    random = np.random.default_rng(0)
    return random.random((3, 2, 64), np.float32), random.integers(0, 6, 64, np.int32), np.zeros((3, 6))


def summed(launcher, shoot, add, width):
    """Three tiles of two channels."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        spectra: wp.array3d(dtype=wp.float32),
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array2d(dtype=wp.float64),
    ):
        add(wp.tid(), spectra, octaves, energies)

    spectra, octaves, energies = spectra_and_octaves()
    launcher.launch(kernel, 3, [spectra, octaves, energies])
    yield energies


def followed(launcher, shoot, follow, width):
    """A state that goes a part of the way, and all of it."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        state: wp.array3d(dtype=wp.float32),
        spectra: wp.array3d(dtype=wp.float32),
        share: wp.float32,
        octaves: wp.array(dtype=wp.int32),
        energies: wp.array2d(dtype=wp.float64),
    ):
        follow(wp.tid(), state, spectra, share, octaves, energies)

    spectra, octaves, energies = spectra_and_octaves()
    for share in (0.3, 1.0):
        state = np.full_like(spectra, 0.5)
        launcher.launch(kernel, 3, [state, spectra, share, octaves, energies])
        yield from (state, energies)


def by_bin(launcher, shoot, add, width):
    """Three tiles of two channels."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(spectra: wp.array3d(dtype=wp.float32), power: wp.array2d(dtype=wp.float32)):
        add(wp.tid(), spectra, power)

    spectra, power = spectra_and_octaves()[0], np.zeros((3, 32), np.float32)
    launcher.launch(kernel, 3, [spectra, power])
    yield power


RUNS = {
    ("first", "values"): filtered,
    ("field", "row", "column", "away"): looked_up,
    ("line", "picture", "away", "usable", "top", "seen"): unwarped,
    ("row", "planes", "picture"): interleaved,
    ("row", "across", "along", "frequency", "amplitude", "away", "values"): waves,
    ("index", "picture", "corners", "window", "levelling", "phase", "spectra", "mean"): transformed,
    ("tile", "spectra", "octaves", "energies"): summed,
    ("tile", "state", "spectra", "share", "octaves", "energies"): followed,
    ("tile", "spectra", "power"): by_bin,
}
"""Parameters of a form -> what runs it."""
