"""The shading core and the deck's Blinn-Phong."""

import functools

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import unit

from swimlab.render.brdfs import blinn_phong
from swimlab.render.catalogue import brdfs
from swimlab.render.kernels.packet import LANES, plain_packet, rows_of
from swimlab.render.kernels.shading import in_local_frame, local, power_of_cosine, shade_with
from swimlab.render.kernels.structs import Sun, Surface, Texel

BLINN_PHONG = blinn_phong.with_normalisation(blinn_phong.BlinnPhongSettings())
REFLECT = in_local_frame(BLINN_PHONG.evaluate, 8)
shade = shade_with(REFLECT, 8)
ROWS = rows_of(8)
PACKET = LANES * ROWS


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
    # The truth of the vectors as they are once rounded to float32, by long doubles, from what rounding changed least.
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


@settings(derandomize=True, deadline=None)
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


@functools.cache
def packets_with(shade_packet):
    @wp.kernel(module="unique", enable_backward=False)
    def kernel(samples: wp.array2d(dtype=wp.float32), sun: Sun, out: wp.array2d(dtype=wp.float32)):
        packet = wp.tid()
        lanes = wp.zeros(shape=(PACKET,), dtype=wp.float32)
        for k in range(PACKET):
            lanes[k] = samples[packet, k]
        shade_packet(lanes, sun)
        for k in range(3 * LANES):
            out[packet, k] = lanes[k]

    return kernel


def in_packets(launcher, shade_packet, samples, sun):
    """Radiance [N, 3] of samples [N, 12], N a multiple of LANES, by packets."""
    lit = Sun()
    lit.direction, lit.diffuse = wp.vec3(*sun.tolist()), 0.6
    rows = samples.reshape(-1, LANES, ROWS).transpose(0, 2, 1).reshape(-1, PACKET)
    out = launcher.empty((len(rows), 3 * LANES), wp.float32)
    launcher.launch(packets_with(shade_packet), len(rows), [launcher.array(rows, wp.float32), lit, out])
    return out.numpy().reshape(-1, 3, LANES).transpose(0, 2, 1).reshape(-1, 3)


def samples_to_shade(random, sun):
    """Samples [N, 12] over all that can occur; the last ones at the ends of powers and angles."""
    count = 40 * LANES
    albedo = random.uniform(0, 1, (count, 3))
    slope = random.uniform(-2, 2, (count, 1))
    to_eye = unit(random.normal(size=(count, 3)) * [1, 1, 0.3] + [0, 0, 0.4])
    power = np.concatenate([[0.0, 0.5, 1.0], np.geomspace(2, 1e5, count - 3)])[:, None]
    # Near the peak of the highlight, where powers matter, in the frame of the slope.
    half = np.array([turn(s, h) for s, h in zip(slope[:, 0], unit(sun + to_eye), strict=True)])
    normal = unit(half + random.normal(size=(count, 3)) / np.sqrt(power + 1)) * random.uniform(0.2, 1, (count, 1))
    normal[-LANES:] = half[-LANES:]
    normal[-2 * LANES : -LANES] *= -1
    to_eye[-3 * LANES] = -sun
    strength = 1 / np.maximum(power, 1)
    position = -to_eye * random.uniform(0.5, 300, (count, 1))
    return np.concatenate([albedo, normal, strength, power, position, slope], axis=1).astype(np.float32)


NATIVE = [("blinn-phong", {"normalisation": kind}) for kind in blinn_phong.FACTORS]


def test_native_forms_are_all_tested():
    assert {n for n, brdf in brdfs().items() if brdf.model(brdf.settings()).native} == {name for name, _ in NATIVE}


@pytest.mark.parametrize(("name", "parameters"), NATIVE)
def test_native_forms_are_the_plain_ones(launcher, tolerance, name, parameters):
    sun = unit(np.array([0.1, 0.9, 0.4]))
    samples = samples_to_shade(np.random.default_rng(0), sun)
    brdf = brdfs()[name]
    model = brdf.model(brdf.settings(**parameters))
    native = in_packets(launcher, model.native, samples, sun)
    plain = in_packets(launcher, plain_packet(in_local_frame(model.evaluate, 8), 8), samples, sun)
    assert (plain.mean(axis=1) > samples[:, :3].mean(axis=1)).any()  # there are highlights
    assert np.abs(native - plain).max() <= tolerance("native against plain")


def test_packets_are_shaded_lane_by_lane(launcher, tolerance):
    sun = unit(np.array([0.1, 0.9, 0.4]))
    samples = samples_to_shade(np.random.default_rng(1), sun)
    samples[:, 11] = 0.5
    packed = in_packets(launcher, plain_packet(REFLECT, 8), samples, sun)
    single = radiance(launcher, samples[:, :8], samples[:, 8:11].astype(np.float64), sun, slope=0.5)
    assert np.isfinite(single).all()
    assert np.abs(packed - single).max() <= tolerance("weights in float32")
