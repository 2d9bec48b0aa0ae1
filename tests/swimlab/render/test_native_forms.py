"""Native forms of packets against the plain forms they stand for."""

import numpy as np
import pytest
import warp as wp

from sequences import load
from swimlab.render.kernels.footprint import surface_at
from swimlab.render.kernels.inspection import filtered_samples
from swimlab.render.kernels.locate import PLACES, locate_before
from swimlab.render.kernels.packet import rows_of
from swimlab.render.kernels.raster import sample_position
from swimlab.render.kernels.structs import LANES, TEXELS, Grid, Planes
from swimlab.render.kernels.texture_filter import FINEST, ISOTROPIC, anisotropic_to
from swimlab.render.texture import MipChain

WIDTHS = (4, 8, 9, 10)
FILTERS = {
    "finest": FINEST,
    "isotropic": ISOTROPIC,
    "one probe": anisotropic_to(1),
    "three": anisotropic_to(3),
    "sixteen": anisotropic_to(16),
}


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
    return np.ascontiguousarray(rows.reshape(packets, LANES, 6).transpose(0, 2, 1)).reshape(packets, PLACES)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("clamps", [False, True])
def test_filters_are_the_plain_ones(launcher, tolerance, name, width, clamps):
    random = np.random.default_rng(0)
    chain = MipChain.allocate(launcher, width=64, height=32, dtype=TEXELS[width], clamps=clamps)
    chain.texels[: 64 * 32].assign(random.random((64 * 32, width), np.float32))
    chain.reduce(launcher)
    given = footprints(random, 20)
    filled = []
    for device in ("cpu", "plain"):
        out = launcher.zeros((len(given), width * LANES), wp.float32)
        kernel = filtered_samples(FILTERS[name].fill(width, device), width)
        launcher.launch(
            kernel,
            len(given),
            [chain.texels, chain.shape, LANES, launcher.array(given, wp.float64), out],
        )
        filled.append(out.numpy())
    native, plain = filled
    assert plain.std() > 0.05
    assert np.abs(native - plain).max() <= tolerance("native filter against plain")


def test_a_partial_packet_leaves_the_rest_alone(launcher):
    chain = MipChain.allocate(launcher, width=8, height=8, dtype=TEXELS[8], clamps=False)
    chain.texels.fill_(1.0)
    given = footprints(np.random.default_rng(1), 1)
    for device in ("cpu", "plain"):
        out = launcher.zeros((1, 8 * LANES), wp.float32)
        inputs = [chain.texels, chain.shape, 5, launcher.array(given, wp.float64), out]
        launcher.launch(filtered_samples(anisotropic_to(16).fill(8, device), 8), 1, inputs)
        lanes = out.numpy().reshape(8, LANES)
        assert (lanes[:, :5] == 1).all()
        assert not lanes[:, 5:].any()


locate = locate_before(8)


@wp.kernel(enable_backward=False)
def located(
    grid: Grid,
    planes: wp.array(dtype=Planes),
    row: wp.int32,
    places: wp.array2d(dtype=wp.float64),
    lanes: wp.array2d(dtype=wp.float32),
    exact_places: wp.array2d(dtype=wp.float64),
    exact_lanes: wp.array2d(dtype=wp.float32),
):
    triangle = wp.tid()
    locate(planes[triangle], grid, 7, row, LANES, places[triangle], lanes[triangle])
    for k in range(LANES):
        surface = surface_at(planes[triangle], grid, sample_position(grid, 7 + k, row))
        for axis in range(2):
            exact_places[triangle, axis * LANES + k] = surface.uv[axis]
            exact_places[triangle, (2 + axis) * LANES + k] = surface.dx[axis]
            exact_places[triangle, (4 + axis) * LANES + k] = surface.dy[axis]
        for axis in range(3):
            exact_lanes[triangle, (8 + axis) * LANES + k] = wp.float32(surface.position[axis])
        exact_lanes[triangle, 11 * LANES + k] = surface.slope


@pytest.mark.parametrize("jittered", [False, True])
@pytest.mark.parametrize("name", ["road-drive", "road-hills"])
def test_places_are_those_of_the_plain_form_to_the_bit(shoot, launcher, name, jittered):
    shot = shoot(load(name), 3)
    grid = shot.grid(4, jittered=jittered)
    count = len(shot.mesh.triangles)
    places, exact_places = (launcher.zeros((count, PLACES), wp.float64) for _ in range(2))
    lanes, exact_lanes = (launcher.zeros((count, rows_of(8) * LANES), wp.float32) for _ in range(2))
    planes = shot.triangles.planes
    launcher.launch(located, count, [grid, planes, 900, places, lanes, exact_places, exact_lanes])
    assert np.isfinite(exact_places.numpy()).all()
    assert exact_places.numpy().any()
    assert np.array_equal(places.numpy(), exact_places.numpy())
    assert np.array_equal(lanes.numpy(), exact_lanes.numpy())
