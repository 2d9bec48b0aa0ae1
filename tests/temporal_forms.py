"""What runs the forms of rows, of the rasteriser and of temporal reuse, to hold native forms against plain ones.

Each takes (launcher, shoot, function, width) and yields the function's results.
"""

import numpy as np
import warp as wp

from sequences import load
from swimlab.render.geometry import seen_from
from swimlab.render.kernels.geometry import Previous
from swimlab.render.kernels.structs import LANES, Chain, Grid, Planes

SIZE = (9, 40)


def blanked(launcher, shoot, blank, width):
    """One row of a picture."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(picture: wp.array2d(dtype=wp.vec4)):
        blank(picture, 1)

    picture = launcher.array(np.ones((3, 40, 4), np.float32), wp.vec4)
    launcher.launch(kernel, 1, [picture])
    assert picture.numpy().sum() == 2 * 40 * 4
    yield picture.numpy()


def copied(launcher, shoot, copy, width):
    """One row of a picture."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(image: wp.array2d(dtype=wp.vec4), out: wp.array2d(dtype=wp.vec4)):
        copy(image, 1, out)

    image, out = colours(launcher), launcher.zeros(SIZE, wp.vec4)
    launcher.launch(kernel, 1, [image, out])
    assert np.array_equal(out.numpy()[1], image.numpy()[1])
    assert not out.numpy()[[0, 2]].any()
    yield out.numpy()


def reached(launcher, shoot, reaching, width):
    """Triangles that end at a row, begin at it, span it and miss it; from each on."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(bounds: wp.array(dtype=wp.vec2d), found: wp.array(dtype=wp.int32)):
        found[wp.tid()] = reaching(bounds, wp.tid(), wp.float64(2.0), wp.float64(3.0))

    rows = [(0.0, 1.9), (0.0, 2.0), (3.0, 9.0), (3.1, 9.0), (-np.inf, np.inf), (1e300, -1e300)]
    found = launcher.zeros(6, wp.int32)
    launcher.launch(kernel, 6, [launcher.array(rows, wp.vec2d), found])
    assert found.numpy().tolist() == [1, 1, 2, 4, 4, 6]
    yield found.numpy()


def projected(launcher, shoot, project, width):
    """All triangles of two roads, in a row of pixels that most do not reach."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        grid: Grid,
        planes: wp.array(dtype=Planes),
        previous: Previous,
        nearness: wp.array2d(dtype=wp.float32),
        places: wp.array2d(dtype=wp.vec4),
    ):
        k = wp.tid()
        project(planes[k], grid, previous, 3, k, 21, nearness, places)

    for name in ("road-drive", "road-hills"):
        shot = shoot(load(name), 3)
        planes = shot.triangles.planes
        nearness, places = (launcher.zeros((len(planes), 30), dtype) for dtype in (wp.float32, wp.vec4))
        previous = seen_from(shot, shot.sequence.view(2))
        launcher.launch(kernel, len(planes), [shot.grid(), planes, previous, nearness, places])
        assert (nearness.numpy() != 0).sum() == 21 * len(planes)
        yield from (nearness.numpy(), places.numpy())


def sighted(launcher):
    """1/w of pixels, a third of which see nothing, nor do any in the first three rows."""
    random = np.random.default_rng(0)
    nearness = random.uniform(0.05, 0.2, SIZE) * (random.random(SIZE) < 0.6)
    nearness[:3] = 0.0
    return launcher.array(nearness.astype(np.float32), wp.float32)


def placed(launcher, shoot, place, width):
    """Every pixel, at the borders too; places on the screen and beyond, of surfaces alike and unlike."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        nearness: wp.array2d(dtype=wp.float32), places: wp.array2d(dtype=wp.vec4), found: wp.array2d(dtype=wp.vec3)
    ):
        j, i = wp.tid()
        found[j, i] = place(nearness, places, nearness, i, j)

    places = np.random.default_rng(0).uniform((-3, -3, -0.02, 0), (43, 12, 0.2, 0.01), (*SIZE, 4))
    found = launcher.zeros(SIZE, wp.vec3)
    launcher.launch(kernel, SIZE, [sighted(launcher), launcher.array(places, wp.vec4), found])
    assert not found.numpy()[:2].any()
    assert 0.05 < found.numpy()[3:, :, 2].mean() < 0.95
    yield found.numpy()


def near(launcher, shoot, any_near, width):
    """Every row."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(nearness: wp.array2d(dtype=wp.float32), out: wp.array(dtype=wp.bool)):
        out[wp.tid()] = any_near(nearness, wp.tid())

    out = launcher.zeros(SIZE[0], wp.bool)
    launcher.launch(kernel, SIZE[0], [sighted(launcher), out])
    assert out.numpy().tolist() == [False] * 2 + [True] * 7
    yield out.numpy()


def colours(launcher):
    """A picture [9, 40], linear RGBA."""
    return launcher.array(np.random.default_rng(0).random((*SIZE, 4), np.float32), wp.vec4)


def read(launcher, shoot, reader, width):
    """Places on the picture and a little beyond it."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(image: wp.array2d(dtype=wp.vec4), at: wp.array(dtype=wp.vec2), out: wp.array(dtype=wp.vec4)):
        out[wp.tid()] = reader(image, at[wp.tid()][0], at[wp.tid()][1])

    at = np.random.default_rng(1).uniform((-2, -2), (42, 11), (500, 2))
    out = launcher.zeros(500, wp.vec4)
    launcher.launch(kernel, 500, [colours(launcher), launcher.array(at, wp.vec2), out])
    assert out.numpy().std() > 0.1
    yield out.numpy()


def ranged(launcher, shoot, find, width):
    """Every row of a picture whose width is, and is not, a multiple of four, at the borders too."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(fresh: wp.array2d(dtype=wp.vec4), ranges: wp.array2d(dtype=wp.vec4)):
        find(fresh, wp.tid(), wp.tid(), ranges)

    for columns in (40, 39, 3, 1):
        fresh = launcher.array(colours(launcher).numpy()[:, :columns].copy(), wp.vec4)
        ranges = launcher.zeros((2 * SIZE[0], columns), wp.vec4)
        launcher.launch(kernel, SIZE[0], [fresh, ranges])
        least, most = ranges.numpy()[0::2], ranges.numpy()[1::2]
        assert (least <= most).all()
        yield ranges.numpy()


def held(launcher, shoot, hold, width):
    """A history within a range and on both sides of it."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(given: wp.array2d(dtype=wp.vec4), out: wp.array(dtype=wp.vec4)):
        k = wp.tid()
        out[k] = hold(given[0, k], wp.min(given[1, k], given[2, k]), wp.max(given[1, k], given[2, k]))

    given = np.random.default_rng(0).uniform(-1, 1, (3, 300, 4))
    out = launcher.zeros(300, wp.vec4)
    launcher.launch(kernel, 300, [launcher.array(given, wp.vec4), out])
    assert out.numpy().std() > 0.1
    yield out.numpy()


def possible(launcher, shoot, premultiplied, width):
    """Colours with alpha under 0, within 0..1 and above."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(given: wp.array(dtype=wp.vec4), out: wp.array(dtype=wp.vec4)):
        out[wp.tid()] = premultiplied(given[wp.tid()])

    given = np.random.default_rng(0).uniform(-0.5, 1.5, (300, 4))
    out = launcher.zeros(300, wp.vec4)
    launcher.launch(kernel, 300, [launcher.array(given, wp.vec4), out])
    assert 0.0 <= out.numpy()[:, 3].min() <= out.numpy()[:, 3].max() <= 1.0
    yield out.numpy()


def resolved(launcher, shoot, resolve_lanes, width):
    """Moments of all sizes in a part of a packet, about a slope."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(rows: wp.array2d(dtype=wp.float32), chain: Chain):
        resolve_lanes(rows[0], chain, LANES - 5)

    random = np.random.default_rng(0).uniform(-0.7, 0.7, (width + 4, LANES))
    random[5] = np.abs(random[5])
    random[7] = 10.0 ** random[7]
    lanes = launcher.array(random.reshape(1, -1), wp.float32)
    chain = Chain()
    chain.centre = wp.vec2(0.1, -0.2)
    launcher.launch(kernel, 1, [lanes, chain])
    changed = lanes.numpy().reshape(-1, LANES) != random.astype(np.float32)
    assert changed[7, : LANES - 5].all()
    assert not changed[:, LANES - 5 :].any()
    yield lanes.numpy()


RUNS = {
    ("lanes", "chain", "count"): resolved,
    ("c",): possible,
    ("picture", "j"): blanked,
    ("image", "j", "out"): copied,
    ("bounds", "first", "top", "bottom"): reached,
    ("planes", "grid", "previous", "first", "j", "count", "nearness", "places"): projected,
    ("nearness", "places", "earlier", "i", "j"): placed,
    ("nearness", "j"): near,
    ("image", "x", "y"): read,
    ("fresh", "j", "row", "ranges"): ranged,
    ("history", "least", "most"): held,
}
"""Parameters of a form -> what runs a function of these parameters."""
