"""Attributes, their analytic derivatives, and the axes of the footprint."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import Oracle
from probe import see

from sequences import load
from swimlab.render.kernels.footprint import ellipse, isotropic_level
from swimlab.render.kernels.structs import Chain, Surface

ROAD = load("road-shift").with_changes(size=(64, 36))
VIEWS = {
    "shift": (ROAD, 3),
    "scale": (load("road-scale").with_changes(size=(64, 36)), 5),
    "drive": (load("road-drive").with_changes(size=(64, 36)), 7),
    "turned": (ROAD.with_changes(camera={"yaw": 25.0, "pitch": -15.0, "lateral": 1.0, "distance": 13.7}), 2),
}


@wp.kernel(enable_backward=False)
def measure(
    dx: wp.array(dtype=wp.vec2d),
    dy: wp.array(dtype=wp.vec2d),
    chain: Chain,
    lengths: wp.array(dtype=wp.vec3d),
    axis: wp.array(dtype=wp.vec2d),
):
    i = wp.tid()
    surface = Surface()
    surface.dx = dx[i]
    surface.dy = dy[i]
    shape = ellipse(surface, chain)
    lengths[i] = wp.vec3d(shape.major, shape.minor, isotropic_level(surface, chain))
    axis[i] = shape.axis


def axes(launcher, jacobians, width=1, height=1):
    """Major, minor, trilinear level [N] and major axis [N, 2] of Jacobians [N, 2, 2] with columns d/dx and d/dy."""
    chain = Chain()
    chain.width, chain.height = width, height
    lengths, axis = launcher.empty(len(jacobians), wp.vec3d), launcher.empty(len(jacobians), wp.vec2d)
    columns = [launcher.array(jacobians[:, :, k], wp.vec2d) for k in (0, 1)]
    launcher.launch(measure, len(jacobians), [*columns, chain, lengths, axis])
    return *lengths.numpy().T, axis.numpy()


@pytest.mark.parametrize("view", VIEWS)
def test_derivatives_are_those_of_the_projection(shoot, maps, tolerance, view):
    sequence, frame = VIEWS[view]
    shot = shoot(sequence, frame)
    seen = see(shot.launcher, shot.triangles, shot.grid())
    oracle = Oracle(sequence, maps, frame)
    x, y = oracle.centres()
    hit, position, uv, dx, dy = oracle.surface(x, y)
    assert np.array_equal(seen.hit, hit)
    for found, exact in ((seen.dx, dx), (seen.dy, dy), (seen.position, position)):
        error = np.abs(found - exact)[hit]
        assert error.max() <= tolerance("surface in double") * np.abs(exact[hit]).max()
    segment = np.round((uv - seen.uv)[hit])
    assert np.array_equal(segment[:, 0], np.zeros(len(segment)))
    assert np.abs((uv - seen.uv)[hit] - segment).max() <= tolerance("surface in double")

    step = 1e-4
    near = hit & (position[..., 1] < 30)
    pitch = sequence.view(frame).pitch
    for found, (right, down) in ((seen.dx, (step, 0.0)), (seen.dy, (0.0, step))):
        ahead = oracle.surface(x + right * pitch[0], y + down * pitch[1])[2]
        behind = oracle.surface(x - right * pitch[0], y - down * pitch[1])[2]
        difference = (ahead - behind)[near] / (2 * step)
        scale = np.abs(difference).max()
        assert np.abs(found[near] - difference).max() <= tolerance("derivative by differences") * scale


angles = st.floats(0, 2 * np.pi)
shapes = st.tuples(angles, st.floats(-12, 14), st.floats(0, np.log2(1e4)), angles, st.booleans())


@settings(derandomize=True)
@given(drawn=st.lists(shapes, min_size=1, max_size=24))
def test_axes_are_the_singular_ones(launcher, tolerance, drawn):
    jacobians = []
    for first, size, aspect, second, mirrored in drawn:
        turn, back = (np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) for a in (first, second))
        major = 2.0**size
        jacobians.append(turn @ np.diag([major, major / 2.0**aspect * (-1 if mirrored else 1)]) @ back)
    jacobians = np.array(jacobians)
    major, minor, level, axis = axes(launcher, jacobians)
    left, singular, _ = np.linalg.svd(jacobians)
    assert major == pytest.approx(singular[:, 0], rel=tolerance("ellipse"))
    assert minor == pytest.approx(singular[:, 1], rel=tolerance("ellipse"))
    assert np.linalg.norm(axis, axis=1) == pytest.approx(1, rel=tolerance("ellipse"))
    # Whatever the axis of a circle may be, the image of the unit circle reaches `major` along it.
    reach = np.linalg.norm(np.einsum("nik,ni->nk", jacobians, axis), axis=1)
    assert reach == pytest.approx(singular[:, 0], rel=tolerance("ellipse"))
    stretched = singular[:, 0] > 1.01 * singular[:, 1]
    along = np.abs(np.sum(axis * left[:, :, 0], axis=1))
    assert along[stretched] == pytest.approx(1, rel=tolerance("ellipse"))
    longest = np.log2(np.linalg.norm(jacobians, axis=1).max(axis=1))
    assert level == pytest.approx(longest, abs=tolerance("ellipse"))


def test_a_sheared_footprint_is_longer_than_its_derivatives(launcher, tolerance):
    major, minor, level, axis = axes(launcher, np.array([[[1.0, 1.0], [0.0, 1.0]]]))
    golden = (1 + 5**0.5) / 2
    assert (major[0], minor[0]) == pytest.approx((golden, 1 / golden), rel=tolerance("ellipse"))
    assert level[0] == pytest.approx(0.5, rel=tolerance("ellipse"))
    assert axis[0][1] / axis[0][0] == pytest.approx(1 / golden, rel=tolerance("ellipse"))


def test_lengths_are_in_texels_of_each_side(launcher, tolerance):
    major, minor, level, axis = axes(launcher, np.array([[[0.5, 0.0], [0.0, 0.5]]]), width=8, height=32)
    assert (major[0], minor[0], level[0]) == pytest.approx((16, 4, 4), rel=tolerance("ellipse"))
    assert np.abs(axis[0]) == pytest.approx([0, 1], abs=tolerance("ellipse"))


def test_a_footprint_without_extent_has_no_nan(launcher):
    major, minor, _, axis = axes(launcher, np.zeros((1, 2, 2)))
    assert (major[0], minor[0]) == (0, 0)
    assert axis[0].tolist() == [1, 0]


def test_a_line_is_a_footprint_too(launcher, tolerance):
    major, minor, _, axis = axes(launcher, np.array([[[3.0, 0.0], [4.0, 0.0]]]))
    assert major[0] == pytest.approx(5, rel=tolerance("ellipse"))
    assert minor[0] == 0
    assert np.abs(axis[0]) == pytest.approx([0.6, 0.8], rel=tolerance("ellipse"))
