"""Every declared native form against the plain form it stands for, on the same inputs."""

from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import measuring_forms
import numpy as np
import pytest
import spectral_forms
import temporal_forms
import warp as wp
from packets import SAMPLES, in_rows, shade

import metrics.kernels
import swimlab.render
from metrics.kernels.forms import DECLARED
from metrics.kernels.making import made_once
from sequences import load
from swimlab.render.catalogue import brdfs
from swimlab.render.kernels.inspection import filtered_samples
from swimlab.render.kernels.packet import PLACES, rows_of
from swimlab.render.kernels.structs import LANES, TEXELS, Grid, Pages, Planes
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
    """Whole packets and packets of 5 lanes, from chains that repeat and that clamp, or as `paged`."""
    if fill.input_types["chain"] is Pages:
        yield from paged(launcher, shoot, fill, width)
        return
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


@made_once
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


def pages(launcher, width, table):
    """The shape of a target whose tiles lie as a table says."""
    found = Pages()
    found.width = found.height = width
    found.levels = width.bit_length()
    found.clamps, found.tile_level, found.first = 1, min(found.levels - 1, 5), 1
    found.table = launcher.array(table, wp.int32)
    return found


def paged(launcher, shoot, fill, width):
    """Packets from a target of 8 x 8 tiles that lie in no order."""
    tile = (4**6 - 1) // 3
    random = np.random.default_rng(0)
    order = 1000 + tile * random.permutation(64)
    texels = launcher.array(random.random((1000 + 64 * tile, 4), np.float32), wp.vec4)
    shape, given = pages(launcher, 256, [5, *order]), footprints(random, 20)
    out = launcher.zeros((len(given), width * LANES), wp.float32)
    inputs = [texels, shape, LANES, launcher.array(given, wp.float64), out]
    launcher.launch(filtered_samples(fill, width, Pages), len(given), inputs)
    assert out.numpy().std() > 0.05
    yield out.numpy()


def aligned(launcher, shoot, fill, width):
    """Runs of texels of several levels."""
    random = np.random.default_rng(0)
    chain = MipChain.allocate(launcher, width=64, height=64, dtype=TEXELS[width], clamps=False)
    chain.texels[: 64 * 64].assign(random.random((64 * 64, width), np.float32))
    chain.reduce(launcher)
    for level in (0, 2, 6):
        side = 64 >> level
        column, row = np.arange(LANES) % side, np.arange(LANES) // side % side
        step = np.full(LANES, 1 / side)
        rows = [(column + 0.5) / side, (row + 0.5) / side, step, 0 * step, 0 * step, step]
        given = np.concatenate(rows)[None]
        for count in (LANES, 13):
            out = launcher.zeros((1, width * LANES), wp.float32)
            inputs = [chain.texels, chain.shape, count, launcher.array(given, wp.float64), out]
            launcher.launch(filtered_samples(fill, width), 1, inputs)
            lanes = out.numpy().reshape(width, LANES)
            first = int(chain.shape.offsets.numpy()[level])
            exact = chain.texels.numpy()[first + row * side + column].T
            assert np.array_equal(lanes[:, :count], exact[:, :count])
            assert not lanes[:, count:].any()
            yield lanes


def marked(launcher, shoot, mark, width):
    """Footprints of all shapes on targets of many tiles and of one."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(pages: Pages, places: wp.array2d(dtype=wp.float64), need: wp.array2d(dtype=wp.int32)):
        mark(pages, places[wp.tid()], LANES - 3, need[wp.tid()])

    for side in (512, 16):
        given = footprints(np.random.default_rng(0), 20)
        given[:, : 2 * LANES] /= 3
        shape = pages(launcher, side, [0])
        need = launcher.array(np.full((20, max(1, side // 32) ** 2 + 1), 127), wp.int32)
        launcher.launch(kernel, 20, [shape, launcher.array(given, wp.float64), need])
        found = need.numpy()
        assert (found[:, 0] == 127).all()
        assert found[:, 1:].min() == 0
        yield found


def located_texels(launcher, shoot, locate, width):
    """Texels of one tile, and of several that share a packet."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        planes: Planes,
        tiles: wp.array(dtype=wp.int32),
        pages: Pages,
        level: wp.int32,
        s: wp.int32,
        places: wp.array(dtype=wp.float64),
        lanes: wp.array(dtype=wp.float32),
    ):
        locate(planes, tiles, 1, pages, level, s, 3, LANES - 2, places, lanes)

    planes = Planes(*np.random.default_rng(0).uniform(-1, 1, 21))
    tiles = launcher.array([1, *np.random.default_rng(0).permutation(64) + 1], wp.int32)
    for level, s in ((0, 2 * LANES), (2, 0), (3, 0), (5, 0)):
        places, lanes = launcher.zeros(PLACES, wp.float64), launcher.zeros(rows_of(width) * LANES, wp.float32)
        launcher.launch(kernel, 1, [planes, tiles, pages(launcher, 256, [0]), level, s, places, lanes])
        inside = places.numpy().reshape(6, LANES)
        assert inside[:, 3:-2].any(axis=0).all()
        assert not inside[:, :3].any()
        yield from (places.numpy(), lanes.numpy())


def collected(launcher, shoot, collect, width):
    """Packets within a large tile and over small ones, some of whose lanes see nothing."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        lanes: wp.array(dtype=wp.float32),
        owners: wp.array(dtype=wp.int32),
        s: wp.int32,
        depth: wp.int32,
        texels: wp.array(dtype=wp.vec4),
        found: wp.array(dtype=wp.int32),
    ):
        found[0] = collect(lanes, owners, s, LANES, depth, texels)

    random = np.random.default_rng(0)
    lanes = launcher.array(random.random(3 * LANES, np.float32), wp.float32)
    for s, depth in ((LANES, 5), (0, 2), (0, 0)):
        for missing in (0, 9):
            owners = np.where(np.arange(LANES) < missing, -1, 4)
            texels, found = launcher.zeros(1365, wp.vec4), launcher.zeros(1, wp.int32)
            launcher.launch(kernel, 1, [lanes, launcher.array(owners, wp.int32), s, depth, texels, found])
            assert found.numpy()[0] == texels.numpy()[:, 3].sum() == LANES - missing
            yield texels.numpy()


def kept(launcher, shoot, keep, width):
    """One tile of which coarse levels are kept, and several of which not all are."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        texels: wp.array(dtype=wp.vec4),
        tiles: wp.array(dtype=wp.int32),
        kept: wp.array(dtype=wp.int32),
        count: wp.int32,
        level: wp.int32,
        pages: Pages,
        held: wp.array(dtype=wp.vec4),
    ):
        keep(texels, tiles, kept, 0, count, level, pages, held)

    random = np.random.default_rng(0)
    for level, wanted in ((0, [2]), (0, [0]), (3, [3, 4, 127, 5])):
        texels = random.random((1365, 4), np.float32)
        tiles = launcher.array(np.arange(len(wanted)) + 2, wp.int32)
        shape, held = pages(launcher, 256, [10, *1365 * np.arange(64)]), launcher.zeros(8000, wp.vec4)
        inputs = [launcher.array(texels, wp.vec4), tiles, launcher.array(wanted, wp.int32), len(wanted), level]
        launcher.launch(kernel, 1, [*inputs, shape, held])
        side = 32 >> level
        mean = texels[: side * side].mean(axis=0)
        assert held.numpy()[10 + 1] == pytest.approx(mean, rel=1e-5)
        yield held.numpy()


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


RUNS = (
    temporal_forms.RUNS
    | {
        ("texels", "chain", "places", "count", "lanes"): filled,
        ("lanes", "sun"): shaded,
        ("planes", "grid", "first", "row", "count", "places", "lanes"): located,
        ("lanes", "lane", "texel"): put,
        ("lanes", "lane"): taken,
        ("lanes", "first", "count", "n", "y", "j", "picture", "error"): gathered,
        ("visible", "row", "first", "last", "value"): claimed,
        ("visible", "row", "cells"): cleared,
        ("texels", "chain", "centres", "count", "lanes"): aligned,
        ("pages", "places", "count", "need"): marked,
        ("planes", "tiles", "first", "pages", "level", "s", "begin", "end", "places", "lanes"): located_texels,
        ("lanes", "owners", "s", "count", "depth", "texels"): collected,
        ("texels", "tiles", "kept", "first", "count", "level", "pages", "held"): kept,
    }
    | measuring_forms.RUNS
    | spectral_forms.RUNS
)
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
    assert found == {"forms.py", "strips.py", "table.py"}
