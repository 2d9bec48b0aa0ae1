"""Non-linear mip chains: what filtered moments say of the normals they came from."""

from typing import Any

import numpy as np
import pytest
import warp as wp
from scipy.special import erfcx

from sequences import load
from swimlab.render.inputs import LEAST_POWER, STEEPEST, Maps
from swimlab.render.kernels.structs import Chain
from swimlab.render.material import Material
from swimlab.render.techniques import clean, lean, toksvig, vmf

SIGMAS = (0.02, 0.1, 0.3)
POWERS = (10.0, 1000.0, 1e5)
ROAD = load("road-shift").with_changes(size=(96, 54))


def rough(sigma, power, *, lean_to=(0.0, 0.0), size=256, ratio=1.0):
    """Maps of independent Gaussian slopes about a mean, across `ratio` times as wide as along; even in number."""
    random = np.random.default_rng(0)
    half = random.normal(size=(size // 2, size, 2)) * sigma * np.array([ratio, 1.0])
    slopes = np.concatenate([half, -half]) + np.array(lean_to)
    normal = np.concatenate([slopes, np.ones((size, size, 1))], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    gloss = np.broadcast_to([0.05, power], (size, size, 2))
    return Maps(np.full((size, size, 3), 0.2, np.float32), normal.astype(np.float32), gloss.astype(np.float32))


def kernel_of(resolve):
    @wp.kernel(module="unique", enable_backward=False)
    def last(level: wp.int32, chain: Chain, texels: wp.array(dtype=Any), out: wp.array(dtype=Any)):
        out[0] = resolve(texels[chain.offsets[level]], chain)

    return last


def filtered(launcher, inputs, maps):
    """What the whole map comes to: the coarsest texel, resolved."""
    chain = Material(launcher, maps).chain(inputs)
    out = launcher.empty(1, chain.texels.dtype)
    launcher.launch(kernel_of(inputs.resolve), 1, [chain.shape.levels - 1, chain.shape, chain.texels, out])
    return out.numpy()[0].astype(np.float64)


def mean_length(sigma):
    """E[1/sqrt(1 + s^2)] for two independent Gaussian slopes."""
    a = 1 / (2 * sigma**2)
    return np.sqrt(np.pi * a) * erfcx(np.sqrt(a))


@pytest.mark.parametrize("power", POWERS)
@pytest.mark.parametrize("sigma", SIGMAS)
@pytest.mark.parametrize("lean_to", [(0.0, 0.0), (0.4, -0.7)])
def test_lean_has_the_covariance_of_the_slopes(launcher, tolerance, sigma, power, lean_to):
    texel = filtered(launcher, lean.INPUTS, rough(sigma, power, lean_to=lean_to, ratio=0.5))
    exact = [0.25 * sigma**2 + 1 / power, sigma**2 + 1 / power]
    assert texel[[5, 7]] == pytest.approx(exact, rel=tolerance("slope variance"))
    assert abs(texel[8]) <= tolerance("slope variance") * exact[1]
    assert texel[3:5] == pytest.approx(lean_to, abs=tolerance("slope variance") * sigma)


@pytest.mark.parametrize("power", POWERS)
@pytest.mark.parametrize("sigma", SIGMAS)
def test_clean_has_the_mean_variance_of_the_slopes(launcher, tolerance, sigma, power):
    texel = filtered(launcher, clean.INPUTS, rough(sigma, power, lean_to=(0.2, 0.1)))
    assert 1 / texel[7] == pytest.approx(sigma**2 + 1 / power, rel=tolerance("slope variance"))


@pytest.mark.parametrize("power", POWERS)
@pytest.mark.parametrize("sigma", SIGMAS)
def test_toksvig_and_vmf_are_their_closed_forms(launcher, tolerance, sigma, power):
    """Both are functions of the mean normal's length alone, which has a closed form for Gaussian slopes."""
    r = mean_length(sigma)
    maps = rough(sigma, power)
    exact = r * power / (r + power * (1 - r))
    assert filtered(launcher, toksvig.INPUTS, maps)[7] == pytest.approx(
        exact, rel=tolerance("closed form of a widened lobe")
    )
    kappa = (3 * r - r**3) / (1 - r**2)
    exact = power * kappa / (power + kappa)
    assert filtered(launcher, vmf.INPUTS, maps)[7] == pytest.approx(
        exact, rel=tolerance("closed form of a widened lobe")
    )


@pytest.mark.parametrize(
    ("inputs", "added"),
    [(toksvig.INPUTS, {0.1: 0.019, 0.2: 0.066, 0.3: 0.128}), (vmf.INPUTS, {0.1: 0.032, 0.2: 0.112, 0.3: 0.214})],
)
def test_the_lost_variance_is_the_published_one(launcher, tolerance, inputs, added):
    """Lengths of normals tell less of wide slopes than slopes do: the added variance is too low by known fractions."""
    for sigma, low in added.items():
        widened = 1 / filtered(launcher, inputs, rough(sigma, 1000.0))[7] - 1 / 1000
        assert 1 - widened / sigma**2 == pytest.approx(low, abs=tolerance("closed form of a widened lobe"))


@pytest.mark.parametrize("inputs", [toksvig.INPUTS, vmf.INPUTS, clean.INPUTS, lean.INPUTS])
def test_a_smooth_map_keeps_its_highlight(launcher, tolerance, inputs):
    """Also where it leans steeply, and its highlight is the sharpest: no cancellation widens it."""
    maps = rough(0.0, 1e5, lean_to=(1.2, -0.9), size=16)
    texel = filtered(launcher, inputs, maps)
    power = 1 / np.sqrt(texel[5] * texel[7] - texel[8] ** 2) if inputs is lean.INPUTS else texel[7]
    # A float32 normal has a length of 1 to 6e-8, which is .6% of a variance of 1e-5.
    assert power == pytest.approx(1e5, rel=tolerance("closed form of a widened lobe"))


@pytest.mark.parametrize("inputs", [toksvig.INPUTS, vmf.INPUTS, clean.INPUTS, lean.INPUTS])
def test_the_ends_are_finite(launcher, inputs):
    """Powers of 0, normals that lie flat, and normals that cancel to nothing."""
    random = np.random.default_rng(1)
    normal = random.normal(size=(8, 8, 3)).astype(np.float32)
    normal[4:] = -normal[:4]
    gloss = np.zeros((8, 8, 2), np.float32)
    texel = filtered(launcher, inputs, Maps(np.ones((8, 8, 3), np.float32), normal, gloss))
    assert np.isfinite(texel).all()
    assert np.abs(texel[3:5]).max() <= STEEPEST
    if inputs is not lean.INPUTS:
        assert 0 <= texel[7] <= LEAST_POWER * 1.01


@pytest.mark.parametrize("name", ["toksvig", "vmf", "clean", "lean", "specular-aa"])
def test_it_acts(shoot, render, tolerance, name):
    """It comes nearer to the reference than the inputs' means, which shows that the normals' spread gets through."""
    shot = shoot(ROAD, samples=256)
    reference = render(shot, "reference").rgba
    covered = reference[..., 3] == 1

    def error(technique):
        return np.sqrt(np.mean((render(shot, technique).rgba - reference)[covered] ** 2))

    assert error(name) < tolerance("technique that acts") * error("pixel-aniso")


def test_lean_falls_back_to_clean_where_the_lobe_is_another(shoot, render, pack_maps, maps):
    """Maps with a twist have no LEAN form: the tangents turn the lobe."""
    turned = np.concatenate([maps, np.broadcast_to(np.float32([1, 0]), (*maps.shape[:2], 2))], axis=2)
    shot = shoot(ROAD, 0, pack_maps(turned))
    one, other = (render(shot, name).rgba for name in ("lean", "clean"))
    assert np.array_equal(one, other)
    assert not np.array_equal(one, render(shoot(ROAD), "lean").rgba)
