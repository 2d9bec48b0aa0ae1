"""Where filtering and shading commute, and by how much they do not: the claims of Sloan & Baker, Part II: Techniques.

The filter is the product's mip chain down to one texel, the lobe its power of a cosine, both in float32.
"""

import numpy as np
import pytest
import warp as wp

from metrics.kernels.launch import Launcher
from swimlab.render.kernels.shading import power_of_cosine
from swimlab.render.texture import MipChain

SIDE = 64
SIGMA = 0.05
LIGHT = np.float32([0.36, 0.48, 0.8])
HALF = np.float32([0.28, 0.0, 0.96])
GREY = np.float32(0.5)
POWERS = (1, 2, 4, 8, 16, 64, 256, 1024)


@wp.kernel
def lobes(normals: wp.array(dtype=wp.vec3), half: wp.vec3, power: wp.float32, found: wp.array(dtype=wp.float32)):
    """sat(N.H)^power of unit normals; the half vector is taken into a frame about each."""
    normal = normals[wp.tid()]
    local = wp.vec3(wp.length(wp.cross(normal, half)), 0.0, wp.dot(normal, half))
    found[wp.tid()] = power_of_cosine(local, power)


@pytest.fixture(scope="module")
def launcher():
    with Launcher(threads=1) as launcher:
        yield launcher


@pytest.fixture(scope="module")
def filtered(launcher):
    """The one texel that a mip chain makes of a map [SIDE, SIDE, channels], channels <= 4."""

    def filtered(texels):
        chain = MipChain.allocate(launcher, width=SIDE, height=SIDE, dtype=wp.vec4, clamps=False)
        padded = np.zeros((len(chain.texels), 4), np.float32)
        padded[: SIDE * SIDE, : texels.shape[-1]] = texels.reshape(SIDE * SIDE, -1)
        chain.texels.assign(padded)
        chain.reduce(launcher)
        return chain.texels.numpy()[-1, : texels.shape[-1]]

    return filtered


@pytest.fixture(scope="module")
def lobe(launcher):
    """sat(N.H)^power [...] of normals [..., 3] of any length."""

    def lobe(normals, half, power):
        units = np.float32(normals / np.linalg.norm(normals, axis=-1, keepdims=True)).reshape(-1, 3)
        found = launcher.empty(len(units), wp.float32)
        launcher.launch(lobes, len(units), [launcher.array(units, wp.vec3), wp.vec3(*half.tolist()), power, found])
        return found.numpy().reshape(normals.shape[:-1])

    return lobe


@pytest.fixture(scope="module")
def rough():
    """Unit normals [SIDE, SIDE, 3] of Gaussian slopes of SIGMA, as even as they can be; their mean leans nowhere."""
    quantile = (np.arange(SIDE) + 0.5) / SIDE
    length = SIGMA * np.sqrt(-2 * np.log(quantile))[:, None]
    slopes = length[..., None] * np.stack([np.cos(2 * np.pi * quantile), np.sin(2 * np.pi * quantile)], axis=1)
    normals = np.concatenate([-slopes, np.ones((SIDE, SIDE, 1))], axis=2)
    return np.float32(normals / np.linalg.norm(normals, axis=2, keepdims=True))


@pytest.fixture(scope="module")
def bumps():
    """Unit normals of random bumps, all of them towards LIGHT and HALF."""
    slopes = np.random.default_rng(0).normal(0, 0.25, (SIDE, SIDE, 2)).clip(-0.9, 0.9)
    normals = np.concatenate([slopes, np.ones((SIDE, SIDE, 1))], axis=2)
    normals = np.float32(normals / np.linalg.norm(normals, axis=2, keepdims=True))
    assert (normals @ LIGHT).min() > 0
    assert (normals @ HALF).min() > 0
    return normals


def diffuse(normals, light, albedo=GREY):
    """The deck's diffuse term, [..., 1]: albedo sat(N.L), of normals as they are given."""
    return albedo * np.clip(normals @ light, 0, 1)[..., None]


def test_diffuse_light_of_the_unnormalised_filtered_normal_is_the_shaded_average(bumps, filtered, tolerance):
    exact = filtered(diffuse(bumps, LIGHT))
    normal = filtered(bumps)
    assert diffuse(normal, LIGHT) == pytest.approx(exact, rel=tolerance("mip in float32"))
    # The length that normalising takes away is the error that it makes.
    length = np.linalg.norm(normal)
    assert length < 0.97
    assert diffuse(normal / length, LIGHT) == pytest.approx(exact / length, rel=tolerance("mip in float32"))


def test_shadowed_normals_break_it(bumps, filtered):
    low = np.float32([0.995, 0.0, 0.0998749])
    assert (bumps @ low).min() < 0
    assert filtered(diffuse(bumps, low)) > 1.01 * diffuse(filtered(bumps), low)


def test_albedo_that_goes_with_the_normals_breaks_it_by_their_covariance(filtered, tolerance):
    """A chequerboard of two normals and two albedos: the gap is (a - b)(M.L - N.L)/4, by hand."""
    odd = np.indices((SIDE, SIDE)).sum(axis=0)[..., None] % 2 == 1
    first, second = np.float32([0.6, 0.0, 0.8]), np.float32([-0.6, 0.0, 0.8])
    normals = np.where(odd, first, second)
    for bright, dark in ((0.9, 0.1), (0.1, 0.9), (0.5, 0.5)):
        albedo = np.where(odd, np.float32(bright), np.float32(dark))
        gap = filtered(diffuse(normals, LIGHT, albedo)) - diffuse(filtered(normals), LIGHT, filtered(albedo))
        covariance = (bright - dark) * ((first - second) @ LIGHT) / 4
        assert gap == pytest.approx(covariance, abs=tolerance("mip in float32"))


def test_any_albedo_breaks_it_by_its_covariance_with_the_cosine(bumps, filtered, tolerance):
    cosine = np.float64(bumps) @ np.float64(LIGHT)
    free = np.random.default_rng(1).random((SIDE, SIDE))
    free = free - np.cov(free.ravel(), cosine.ravel())[0, 1] / cosine.var(ddof=1) * (cosine - cosine.mean())
    for share, least in ((0.0, 0.0), (0.5, 0.002)):
        albedo = 0.4 * free + share * cosine
        covariance = np.mean((albedo - albedo.mean()) * (cosine - cosine.mean()))
        assert abs(covariance) >= least
        albedo = np.float32(albedo)[..., None]
        gap = filtered(diffuse(bumps, LIGHT, albedo)) - diffuse(filtered(bumps), LIGHT, filtered(albedo))
        assert gap == pytest.approx(covariance, abs=tolerance("mip in float32"))


def test_a_first_power_commutes_without_normalising_and_no_other_does(bumps, filtered, lobe, tolerance):
    """log mean((N.H)^p) - p log mean(N.H) is convex in p and 0 at 0 and 1 (Lyapunov): the gap grows from p = 1 on."""
    cosine = float(filtered(bumps) @ HALF)
    gaps = []
    for power in POWERS:
        exact = filtered(lobe(bumps, HALF, power)[..., None])[0]
        double = np.mean((np.float64(bumps) @ np.float64(HALF)) ** power)
        assert exact == pytest.approx(double, rel=tolerance("power of a filtered lobe"))
        gaps.append(np.log(exact) - power * np.log(cosine))
    assert gaps[0] == pytest.approx(0, abs=tolerance("mip in float32"))
    assert gaps[1] > 1e-3
    assert np.all(np.diff(gaps) > 0)


def test_shading_the_normalised_filtered_normal_is_off_at_every_power(bumps, rough, filtered, lobe, tolerance):
    exact = filtered(lobe(bumps, HALF, 1)[..., None])[0]
    normal = filtered(bumps)
    shaded = lobe(normal, HALF, 1)
    assert shaded * np.linalg.norm(normal) == pytest.approx(exact, rel=tolerance("mip in float32"))
    # About the peak the average of a lobe over Gaussian slopes is 1/(1 + p sigma^2), and the flat normal's is 1.
    up = np.float32([0, 0, 1])
    overshoots = []
    for power in POWERS:
        exact = filtered(lobe(rough, up, power)[..., None])[0]
        overshoots.append(lobe(filtered(rough), up, power) / exact - 1)
        assert overshoots[-1] == pytest.approx(power * SIGMA**2, rel=tolerance("lobe over Gaussian slopes"))
    assert np.all(np.diff(overshoots) > 0)
