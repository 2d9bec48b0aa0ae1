"""The shading core and the deck's Blinn-Phong."""

import numpy as np
import packets
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import unit

from swimlab.render.brdfs import blinn_phong
from swimlab.render.kernels.packet import plain_packet
from swimlab.render.kernels.shading import in_local_frame, local, power_of_cosine, shade_with
from swimlab.render.kernels.structs import Sun, Surface, Texel

BLINN_PHONG = blinn_phong.with_normalisation(blinn_phong.BlinnPhongSettings())
REFLECT = in_local_frame(BLINN_PHONG.evaluate, 8)
shade = shade_with(REFLECT, 8)


@wp.kernel(enable_backward=False)
def powers(
    h: wp.array(dtype=wp.vec3),
    p: wp.array(dtype=wp.float32),
    out: wp.array(dtype=wp.float32),
):
    i = wp.tid()
    out[i] = power_of_cosine(h[i], p[i])


@wp.kernel(enable_backward=False)
def into_local(slope: wp.float32, direction: wp.array(dtype=wp.vec3), out: wp.array(dtype=wp.vec3)):
    i = wp.tid()
    out[i] = local(slope, direction[i])


@wp.kernel(enable_backward=False)
def light(
    texels: wp.array(dtype=Texel),
    position: wp.array(dtype=wp.vec3d),
    slope: wp.float32,
    sun: Sun,
    out: wp.array(dtype=wp.vec3),
):
    i = wp.tid()
    surface = Surface()
    surface.position = position[i]
    surface.slope = slope
    out[i] = shade(texels[i], surface, sun)


def raised(launcher, h, p):
    out = launcher.empty(len(h), wp.float32)
    launcher.launch(powers, len(h), [launcher.array(h.astype(np.float32), wp.vec3), launcher.array(p, wp.float32), out])
    return out.numpy()


def radiance(launcher, texels, position, sun, *, slope=0.0, diffuse=0.6):
    """Radiance [N, 3] of texels [N, 8] at positions relative to the eye [N, 3] under a sun [3]."""
    lit = Sun()
    lit.direction, lit.diffuse = wp.vec3(*sun.tolist()), diffuse
    out = launcher.empty(len(texels), wp.vec3)
    inputs = [launcher.array(texels, Texel), launcher.array(position, wp.vec3d), slope, lit, out]
    launcher.launch(light, len(texels), inputs)
    return out.numpy()


def turn(slope, vectors):
    """World directions in the road's frame: a rotation about x by the slope's angle."""
    angle = np.arctan(slope)
    cosine, sine = np.cos(angle), np.sin(angle)
    return vectors @ np.array([[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]]).T


ANGLES = np.concatenate([[0.0], np.geomspace(1e-4, np.pi / 2 - 1e-3, 120)])
POWERS = np.concatenate([[0.0, 0.5, 1.0], np.geomspace(2, 1e5, 40)])


def test_powers_of_cosines_hold_at_any_power(launcher, tolerance):
    angle, power = (each.ravel() for each in np.meshgrid(ANGLES, POWERS))
    across = unit(np.array([0.9, -0.2, 0.0]))
    h = np.cos(angle)[:, None] * np.array([0.0, 0.0, 1.0]) + np.sin(angle)[:, None] * across
    # The exact value for the vectors as rounded to float32, in long doubles, from terms that rounding changes least.
    rounded = h.astype(np.float32).astype(np.longdouble)
    squared = (rounded[:, :2] ** 2).sum(axis=1)
    exact = np.where(squared > 0.5, rounded[:, 2] ** power, np.exp(power / 2 * np.log1p(-np.minimum(squared, 0.6))))
    found = raised(launcher, h, power)
    assert np.abs(found - exact).max() <= tolerance("power of a cosine")
    grazing = (angle > 1) & (power <= 1)
    assert np.abs(found[grazing] / exact[grazing] - 1).max() <= tolerance("power of a cosine")
    assert found.max() <= 1


def test_powers_at_their_ends(launcher):
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    pairs = [(z, 1e5), (x, 1.0), (x, 0.0), (-z, 5.0), (-z, 0.0), (z, 0.0)]
    h, p = (np.array(each) for each in zip(*pairs, strict=True))
    assert raised(launcher, h, p).tolist() == [1, 0, 1, 0, 1, 1]


@pytest.mark.parametrize("slope", [-2.0, -0.1, 0.0, 0.5, 30.0])
def test_the_slopes_frame_is_orthonormal(launcher, tolerance, slope):
    tangents = np.array([[1, 0, 0], [0, 1, slope], [0, -slope, 1]])
    world = np.concatenate([unit(tangents), unit(np.random.default_rng(0).normal(size=(20, 3)))])
    out = launcher.empty(len(world), wp.vec3)
    launcher.launch(into_local, len(world), [slope, launcher.array(world, wp.vec3), out])
    found = out.numpy()
    assert found[:3] == pytest.approx(np.eye(3), abs=tolerance("weights in float32"))
    assert found == pytest.approx(turn(slope, world), abs=tolerance("weights in float32"))
    assert found @ found.T == pytest.approx(world @ world.T, abs=tolerance("weights in float32"))


def test_a_mirror_shows_the_power_itself(launcher, tolerance):
    sun = unit(np.array([0.0, 0.6, 0.8]))
    position = np.array([[0.0, 3.0, -4.0]])
    texel = np.array([[0.1, 0.2, 0.3, 0.0, 0.0, 2.0, 0.05, 100.0]])
    exact = 0.05 * 100 + np.array([0.1, 0.2, 0.3]) * 0.8 * 0.6
    found = radiance(launcher, texel, position, sun)[0]
    assert found == pytest.approx(exact, rel=tolerance("radiance in float32"))


def test_the_highlight_outlives_the_diffuse_light(launcher, tolerance):
    """The sun is behind the tilted normal, the half vector before it: the deck does not gate the highlight by N.L."""
    normal = unit(np.array([0.0, -0.5, 0.9]))
    sun = unit(np.array([0.0, 0.95, 0.3]))
    half = unit(sun + np.array([0.0, 0.0, 1.0]))
    position = np.array([[0.0, 0.0, -1.0]])
    assert normal @ sun < 0 < normal @ half
    found = radiance(launcher, np.array([[0.5, 0.5, 0.5, *normal, 0.2, 3.0]]), position, sun)[0]
    assert found == pytest.approx(np.full(3, (normal @ half) ** 3 * 3 * 0.2), rel=tolerance("radiance in float32"))


directions = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(0.05, 1))


@settings(derandomize=True)
@given(
    sun=directions,
    to_eye=directions,
    normal=directions,
    colour=st.tuples(*[st.floats(0, 1)] * 3),
    ks=st.floats(0, 1),
    power=st.floats(0, 200),
    slope=st.floats(-2, 2),
    diffuse=st.floats(0, 2),
)
def test_radiance_is_the_decks_formula_in_the_turned_frame(
    launcher, tolerance, sun, to_eye, normal, colour, ks, power, slope, diffuse
):
    sun, to_eye, n = (unit(np.array(each)) for each in (sun, to_eye, normal))
    half = unit(sun + to_eye)
    specular = max(n @ half, 0.0) ** power * power * ks
    exact = np.array(colour) * max(n @ sun, 0.0) * diffuse + specular
    texel = np.array([[*colour, *normal, ks, power]])
    # What stands upright over a flat road stands turned over a slope.
    world = [turn(-slope, each) for each in (-7.5 * to_eye, sun)]
    limit = tolerance("radiance in float32") * (1 + power * ks)
    for position, light_from, tilt in ((-7.5 * to_eye, sun, 0.0), (*world, slope)):
        found = radiance(launcher, texel, position[None], light_from, slope=tilt, diffuse=diffuse)[0]
        assert found == pytest.approx(exact, abs=limit)


def test_packets_are_shaded_lane_by_lane(launcher, tolerance):
    samples = packets.materials(np.random.default_rng(1)).astype(np.float32)
    samples[:, 11] = 0.5
    packed = packets.shade(launcher, plain_packet(REFLECT, 8), samples)
    single = radiance(launcher, samples[:, :8], samples[:, 8:11].astype(np.float64), packets.SUN, slope=0.5)
    assert np.isfinite(single).all()
    assert np.abs(packed - single).max() <= tolerance("weights in float32")
