"""The kernels of temporal reuse alone: where a surface was, whether it was seen, and how history is read."""

import numpy as np
import pytest
import warp as wp

from sequences import load
from swimlab.render.geometry import describe_geometry, seen_from
from swimlab.render.inputs import BOX
from swimlab.render.kernels.accumulation import resolve_with, sample_with
from swimlab.render.kernels.clamp import CLAMPS
from swimlab.render.kernels.history import READS
from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.technique import core_of

H, W = 12, 16
BLEND = 0.25


@pytest.fixture
def resolve(launcher):
    """The blend of pictures [H, W, 4]; everywhere the surface of 1/w = .1 that stands still, unless said otherwise."""

    def resolve(fresh, history, *, read="bicubic", clamp="none", moved=(0.0, 0.0), places=None, now=None, before=None):
        j, i = np.mgrid[:H, :W] + 0.5
        if places is None:
            places = np.stack([i - moved[0], j - moved[1], np.full((H, W), 0.1), np.zeros((H, W))], axis=-1)
        now, before = (np.full((H, W), 0.1) if each is None else each for each in (now, before))
        picture = launcher.empty((H, W), wp.vec4)
        vectors = [np.broadcast_to(each, (H, W, 4)).astype(np.float32) for each in (fresh, places, history)]
        fresh, places, history = (launcher.array(each, wp.vec4) for each in vectors)
        now, before = (launcher.array(each.astype(np.float32), wp.float32) for each in (now, before))
        kernel = resolve_with(READS[read], CLAMPS[clamp], launcher.device)
        scratch = launcher.empty((2 * H, W), wp.vec4)
        launcher.launch(kernel, H, [0, BLEND, fresh, now, places, history, before, picture, scratch])
        return picture.numpy()

    return resolve


FRESH = np.array([1.0, 2.0, 3.0, 1.0])
HISTORY = np.array([5.0, 4.0, 1.0, 1.0])
BLENDED = HISTORY + BLEND * (FRESH - HISTORY)


def test_the_history_of_the_same_surface_is_blended_in(resolve, tolerance):
    assert np.abs(resolve(FRESH, HISTORY) - BLENDED).max() <= tolerance("cubic in float32")


@pytest.mark.parametrize("factor", [0.5, 1.5])
def test_where_another_surface_was_the_new_frame_stands(resolve, tolerance, factor):
    before = np.full((H, W), 0.1)
    before[:, 8:] *= factor
    found = resolve(FRESH, HISTORY, before=before)
    assert np.array_equal(found[:, 9:], np.broadcast_to(FRESH, (H, W - 9, 4)))
    assert np.abs(found[:, :8] - BLENDED).max() <= tolerance("cubic in float32")


def test_a_steep_surface_is_still_the_same(resolve, tolerance):
    """At an edge of the road far away 1/w doubles from row to row, and only one neighbour may see it."""
    j, i = np.mgrid[:H, :W] + 0.5
    places = np.stack([i, j - 0.5, np.full((H, W), 0.05), np.full((H, W), 0.05)], axis=-1)
    found = resolve(FRESH, HISTORY, places=places)
    assert np.abs(found[1:] - BLENDED).max() <= tolerance("cubic in float32")


@pytest.mark.parametrize("moved", [(3.0, 0.0), (-3.0, 0.0), (0.0, 3.0), (0.0, -3.0)])
def test_what_comes_onto_the_screen_is_new(resolve, tolerance, moved):
    found = resolve(FRESH, HISTORY, moved=moved)
    j, i = np.mgrid[:H, :W] + 0.5
    x, y = i - moved[0], j - moved[1]
    new = (x < 0) | (x > W) | (y < 0) | (y > H)
    assert new.sum() in (3 * H, 3 * W)
    assert np.array_equal(found[new], np.broadcast_to(FRESH, found[new].shape))
    assert np.abs(found[~new] - BLENDED).max() <= tolerance("cubic in float32")


def test_what_lay_behind_the_eye_is_new(resolve):
    places = np.array([8.0, 6.0, -0.1, 0.0])
    assert np.array_equal(resolve(FRESH, HISTORY, places=places), np.broadcast_to(FRESH, (H, W, 4)))


def test_a_pixel_whose_centre_misses_goes_with_the_nearest_surface_beside_it(resolve, tolerance):
    now = np.full((H, W), 0.1)
    now[:, 6:] = 0
    now[5, 5] = 0.2
    j, i = np.mgrid[:H, :W] + 0.5
    places = np.stack([i, j, now, np.zeros((H, W))], axis=-1)
    places[5, 5, :2] += (2, 0)
    before = now.copy()
    before[5, 7] = 0.2
    ramp = np.ones((H, W, 4)) * i[..., None]
    ramp[..., 3] = 1
    found = resolve(np.ones(4), ramp, read="bilinear", now=now, places=places, before=before)
    follows = lambda x: x + BLEND * (1 - x)  # noqa: E731
    assert found[9, 6, 0] == pytest.approx(follows(6.5), rel=tolerance("cubic in float32"))
    assert found[5, 6, 0] == pytest.approx(follows(8.5), rel=tolerance("cubic in float32"))
    assert np.array_equal(found[:, 8:], np.ones((H, W - 8, 4)))


@pytest.mark.parametrize(("read", "degree"), [("bilinear", 1), ("bicubic", 2)])
def test_polynomials_are_read_as_they_are(resolve, tolerance, read, degree):
    """Catmull-Rom weights keep parabolas, linear ones straight lines."""
    moved = (0.3, -0.45)
    j, i = np.mgrid[:H, :W] + 0.5

    def values(x, y):
        line = 1 + 0.05 * x + 0.03 * y + 0.01 * x * y
        return line + (0.004 * x**2 - 0.006 * y**2 if degree == 2 else 0)

    history = np.repeat(values(i, j)[..., None], 4, axis=2)
    history[..., 3] = 1
    found = resolve(np.ones(4), history, read=read, moved=moved)[..., 0]
    expected = 1 + (1 - BLEND) * (values(i - moved[0], j - moved[1]) - 1)
    inner = (slice(2, -2), slice(2, -2))
    assert np.abs(found - expected)[inner].max() <= tolerance("cubic in float32")


@pytest.mark.parametrize("clamp", ["box", "variance"])
def test_grey_history_is_held_to_what_is_seen_nearby(resolve, tolerance, clamp):
    random = np.random.default_rng(0)
    fresh, history = (np.ones((H, W, 4)) * random.uniform(0, high, (H, W, 1)) for high in (1, 5))
    fresh[..., 3] = history[..., 3] = 1
    around = np.stack([np.roll(fresh[..., 0], (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)])
    low, high = around.min(axis=0), around.max(axis=0)
    if clamp == "variance":
        low, high = (around.mean(axis=0) + sign * around.std(axis=0) for sign in (-1, 1))
    expected = np.clip(history[..., 0], np.maximum(low, 0), high)
    expected += BLEND * (fresh[..., 0] - expected)
    inner = (slice(1, -1), slice(1, -1))
    found = resolve(fresh, history, clamp=clamp)
    assert np.abs(found - expected[..., None])[inner][..., :3].max() <= tolerance("cubic in float32")
    assert (expected != history[..., 0])[inner].mean() > 0.5


def test_overshoot_makes_no_colour_that_cannot_be(resolve):
    """Beside an edge a cubic gives alpha above 1 and under 0; premultiplied, the colour stays the edge's."""
    history = np.zeros((H, W, 4))
    history[:, 8:] = (0.5, 0.25, 2.0, 1.0)
    found = resolve(history, history, moved=(0.5, 0.0))
    assert found.min() >= 0
    assert found[..., 3].max() <= 1
    assert np.allclose(found[..., :3], found[..., 3:] * (0.5, 0.25, 2.0), rtol=0, atol=1e-6)
    assert not found[:, :6].any()


@pytest.mark.parametrize("name", ["road-shift", "road-drive", "road-hills"])
def test_places_are_where_motion_leads_back_to(launcher, shoot, tolerance, name):
    shot = shoot(load(name).with_changes(size=(64, 36)), 2)
    geometry = describe_geometry(shot)
    size = (36, 64)
    core, triangles, grid = core_of(shot, anisotropic_to(16), BOX), shot.triangles, shot.grid()
    nearness, places = launcher.empty(size, wp.float32), launcher.empty(size, wp.vec4)
    picture, shaded, scratch = (launcher.empty(*of) for of in ((size, wp.vec4), (36, wp.int32), (size, wp.int32)))
    inputs = [0, grid.origin, grid, seen_from(shot, shot.sequence.view(1)), triangles.edges, triangles.planes]
    inputs += [triangles.bounds, *core.arguments, picture, shaded, nearness, places, scratch]
    launcher.launch(sample_with(core.fill, core.shade, core.width, launcher.device), 36, inputs)
    hit = geometry.depth > 0
    j, i = np.mgrid[:36, :64] + 0.5
    nearness, places = nearness.numpy(), places.numpy()
    assert np.array_equal(nearness > 0, hit)
    assert np.abs(nearness * geometry.depth - 1)[hit].max() <= tolerance("depth")
    expected = np.stack([i, j], axis=-1) - geometry.motion
    assert np.abs(places[hit, :2] - expected[hit]).max() <= tolerance("motion")
    forward = 0.1 if name != "road-shift" else 0.0
    assert (1 / places[..., 2][hit] - geometry.depth[hit]).mean() == pytest.approx(forward, abs=0.02)
