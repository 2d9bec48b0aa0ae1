"""Every declared native form against the plain form it stands for, on the same inputs."""

import functools
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import numpy as np
import pytest
import temporal_forms
import warp as wp
from packets import SAMPLES, in_rows, shade

import metrics.kernels
import swimlab.render
from metrics.kernels.forms import DECLARED
from metrics.kernels.splines import LINES, VECTORS
from sequences import load
from swimlab.render.catalogue import brdfs
from swimlab.render.kernels.inspection import filtered_samples
from swimlab.render.kernels.packet import PLACES, rows_of
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Grid, Planes
from swimlab.render.texture import MipChain

for package in (swimlab.render, metrics.kernels):
    for module in walk_packages(package.__path__, package.__name__ + "."):
        import_module(module.name)


def footprints(random, packets):
    """Places [packets, PLACES] of all sizes, shapes and shears, up to 1e4 : 1; the first packet's have no size."""
    count = packets * LANES
    uv = random.uniform(-3, 3, (count, 2))
    size = 10.0 ** random.uniform(-6, 0, (count, 1))
    aspect = 10.0 ** random.uniform(-4, 0, (count, 1))
    angle, turn = random.uniform(0, 2 * np.pi, (2, count))
    major = np.stack([np.cos(angle), np.sin(angle)], axis=1) * size
    minor = np.stack([-np.sin(angle), np.cos(angle)], axis=1) * size * aspect
    cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
    rows = np.concatenate([uv, major * cosine + minor * sine, minor * cosine - major * sine], axis=1)
    rows[:LANES, 2:] = 0.0
    return in_rows(rows)


def filled(launcher, shoot, fill, width):
    """Whole packets and packets of 5 lanes, from chains that repeat and that clamp."""
    for clamps in (False, True):
        random = np.random.default_rng(0)
        chain = MipChain.allocate(launcher, width=64, height=32, dtype=TEXELS[width], clamps=clamps)
        chain.texels[: 64 * 32].assign(random.random((64 * 32, width), np.float32))
        chain.reduce(launcher)
        given = footprints(random, 20)
        for count in (LANES, 5):
            out = launcher.zeros((len(given), width * LANES), wp.float32)
            inputs = [chain.texels, chain.shape, count, launcher.array(given, wp.float64), out]
            launcher.launch(filtered_samples(fill, width), len(given), inputs)
            lanes = out.numpy().reshape(len(given), width, LANES)
            assert lanes[..., :count].std() > 0.05
            assert not lanes[..., count:].any()
            yield lanes


def shaded(launcher, shoot, shade_packet, width):
    """Radiance of packets over all that a texel of `width` floats can hold."""
    samples = SAMPLES[width](np.random.default_rng(0))
    radiance = shade(launcher, shade_packet, samples)
    assert np.isfinite(radiance).all()
    assert (radiance > samples[:, :3]).any()  # there are highlights
    yield radiance


@functools.cache
def locating(locate):
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        grid: Grid,
        planes: wp.array(dtype=Planes),
        row: wp.int32,
        count: wp.int32,
        places: wp.array2d(dtype=wp.float64),
        lanes: wp.array2d(dtype=wp.float32),
    ):
        triangle = wp.tid()
        locate(planes[triangle], grid, 7, row, count, places[triangle], lanes[triangle])

    return kernel


def located(launcher, shoot, locate, width):
    """Places of all triangles, in a row of pixels that most of them do not reach."""
    for name in ("road-drive", "road-hills"):
        for jittered in (False, True):
            shot = shoot(load(name), 3)
            planes = shot.triangles.planes
            places = launcher.zeros((len(planes), PLACES), wp.float64)
            lanes = launcher.zeros((len(planes), rows_of(width) * LANES), wp.float32)
            inputs = [shot.grid(4, jittered=jittered), planes, 900, LANES, places, lanes]
            launcher.launch(locating(locate), len(planes), inputs)
            assert np.isfinite(places.numpy()).all()
            assert places.numpy().any()
            assert not lanes.numpy()[:, : width * LANES].any()
            yield from (places.numpy(), lanes.numpy())


def put(launcher, shoot, put_in, width):
    """One texel in each lane."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(texels: wp.array(dtype=TEXELS[width]), lanes: wp.array(dtype=wp.float32)):
        put_in(lanes, wp.tid(), texels[wp.tid()])

    texels = np.random.default_rng(0).random((LANES, width), np.float32)
    lanes = launcher.zeros(width * LANES, wp.float32)
    launcher.launch(kernel, LANES, [launcher.array(texels, TEXELS[width]), lanes])
    assert np.array_equal(lanes.numpy().reshape(width, LANES), texels.T)
    yield lanes.numpy()


def taken(launcher, shoot, take, width):
    """The texel of each lane."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(lanes: wp.array(dtype=wp.float32), texels: wp.array(dtype=TEXELS[width])):
        texels[wp.tid()] = take(lanes, wp.tid())

    lanes = np.random.default_rng(0).random((width, LANES), np.float32)
    texels = launcher.zeros(LANES, TEXELS[width])
    launcher.launch(kernel, LANES, [launcher.array(lanes.ravel(), wp.float32), texels])
    assert np.array_equal(texels.numpy(), lanes.T)
    yield texels.numpy()


def gathered(launcher, shoot, gather, width):
    """Packets that begin and end within pixels, of 1, 3 x 3 and 4 x 4 cells."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        n: wp.int32,
        rows: wp.array2d(dtype=wp.float32),
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
    ):
        for y in range(n):
            gather(rows[y], 2, LANES - 5, n, y, 1, picture, error)

    for n in (1, 3, 4):
        given = np.random.default_rng(0).random((n, 3 * LANES), np.float32)
        sums = [launcher.zeros((3, LANES), wp.vec4) for _ in range(2)]
        launcher.launch(kernel, 1, [n, launcher.array(given, wp.float32), *sums])
        assert sums[0].numpy()[..., 3].sum() == n * (LANES - 5)
        yield from (each.numpy() for each in sums)


def reduced(launcher, shoot, reduce, width):
    """Levels of a target some of whose tiles are needed."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        level: wp.int32,
        tile_level: wp.int32,
        need: wp.array2d(dtype=wp.int32),
        chain: Chain,
        texels: wp.array(dtype=wp.vec4),
    ):
        reduce(wp.tid(), level, tile_level, need, chain, texels)

    random = np.random.default_rng(0)
    chain = MipChain.allocate(launcher, width=64, height=64, dtype=wp.vec4, clamps=True)
    chain.texels.assign(random.random((len(chain.texels), 4), np.float32))
    before = chain.texels.numpy().copy()
    need = launcher.array(random.choice([0, 1, 2, 127], (4, 4)), wp.int32)
    for level in (1, 2, 3):
        launcher.launch(kernel, 64 >> level, [level, 4, need, chain.shape, chain.texels])
    changed = np.any(chain.texels.numpy() != before, axis=1)
    assert changed.any()
    assert not changed.all()
    yield chain.texels.numpy()


def claimed(launcher, shoot, claim, width):
    """Runs of a row in which nothing, something and everything is taken."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(visible: wp.array2d(dtype=wp.int32), whole: wp.array(dtype=wp.bool)):
        for run in range(3):
            whole[run] = claim(visible, 1, 2 + 10 * run, 10 + 10 * run, 7)

    cells = np.full((3, 40), -1, np.int32)
    cells[1, 15:17] = cells[1, 20:32] = 3
    visible, whole = launcher.array(cells, wp.int32), launcher.zeros(3, wp.bool)
    launcher.launch(kernel, 1, [visible, whole])
    assert whole.numpy().tolist() == [True, False, False]
    assert np.sum(visible.numpy() == 7) == 8 + 6
    yield visible.numpy()


def cleared(launcher, shoot, clear, width):
    """A part of one row."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(visible: wp.array2d(dtype=wp.int32)):
        clear(visible, 1, 30)

    visible = launcher.zeros((3, 40), wp.int32)
    launcher.launch(kernel, 1, [visible])
    assert visible.numpy().sum() == -30
    yield visible.numpy()


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


RUNS = temporal_forms.RUNS | {
    ("texels", "chain", "places", "count", "lanes"): filled,
    ("lanes", "sun"): shaded,
    ("planes", "grid", "first", "row", "count", "places", "lanes"): located,
    ("lanes", "lane", "texel"): put,
    ("lanes", "lane"): taken,
    ("lanes", "first", "count", "n", "y", "j", "picture", "error"): gathered,
    ("visible", "row", "first", "last", "value"): claimed,
    ("visible", "row", "cells"): cleared,
    ("j", "level", "tile_level", "need", "chain", "texels"): reduced,
    ("first", "values"): filtered,
    ("field", "row", "column", "away"): looked_up,
    ("line", "picture", "away", "usable", "top", "seen"): unwarped,
    ("row", "planes", "picture"): interleaved,
    ("row", "across", "along", "frequency", "amplitude", "away", "values"): waves,
}
"""Parameters of a form -> what runs a function of these parameters and yields its results."""


@pytest.mark.parametrize("declared", DECLARED, ids=lambda declared: declared.name)
def test_native_form_agrees_with_the_plain_one(launcher, shoot, tolerance, declared):
    form = declared.make()
    parameters = tuple(form.plain.input_types)
    assert parameters in RUNS, f"no inputs for a form of {parameters}: add what runs it to RUNS"
    run = RUNS[parameters]
    pairs = zip(*(run(launcher, shoot, each, form.width) for each in (form.native, form.plain)), strict=True)
    for native, plain in pairs:
        if form.agrees is None:
            assert np.array_equal(native, plain)
            continue
        scale = 1.0 if form.agrees.floor is None else np.abs(plain) + form.agrees.floor
        assert (np.abs(native - plain) / scale).max() <= tolerance(form.agrees.tolerance)


TABLES = [(name, k) for name, brdf in brdfs().items() for k in range(len(brdf.model(brdf.settings()).tables))]


@pytest.mark.parametrize(("name", "k"), TABLES)
def test_tables_are_read_as_on_the_host(launcher, name, k):
    """To the bit, also beyond the ends."""
    brdf = brdfs()[name]
    table = brdf.model(brdf.settings()).tables[k]
    lookup = table.lookup

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(u: wp.array(dtype=wp.float32), v: wp.array(dtype=wp.float32), out: wp.array(dtype=wp.float32)):
        out[wp.tid()] = lookup(u[wp.tid()], v[wp.tid()])

    u, v = np.random.default_rng(0).uniform(-0.1, 1.1, (2, 10000)).astype(np.float32)
    out = launcher.zeros(len(u), wp.float32)
    launcher.launch(kernel, len(u), [launcher.array(u, wp.float32), launcher.array(v, wp.float32), out])
    assert np.array_equal(out.numpy(), table.at(u, v))


def test_no_native_code_stands_without_a_plain_form():
    roots = [Path(package.__path__[0]) for package in (swimlab.render, metrics.kernels)]
    found = {path.name for root in roots for path in root.rglob("*.py") if "func_native" in path.read_text()}
    assert found == {"forms.py", "table.py"}
