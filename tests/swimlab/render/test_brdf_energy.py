"""What reflectance models reflect in all, by quadrature over the hemisphere, against closed forms."""

import numpy as np
import pytest
from evaluation import evaluated
from scipy.special import beta

COSINES, WEIGHTS = np.polynomial.legendre.leggauss(400)
COSINES, WEIGHTS = (COSINES + 1) / 2, WEIGHTS / 2
AROUND = 128


def hemisphere(squeeze=1):
    """Directions [N, 3] and their solid angles [N]; denser about the normal with `squeeze` > 1."""
    cosine, weight = 1 - (1 - COSINES) ** squeeze, WEIGHTS * squeeze * (1 - COSINES) ** (squeeze - 1)
    azimuth = 2 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
    z, phi = (each.ravel() for each in np.meshgrid(cosine, azimuth, indexing="ij"))
    sine = np.sqrt(1 - z**2)
    directions = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
    return directions, np.repeat(weight, AROUND) * 2 * np.pi / AROUND


@pytest.fixture
def limit(tolerance):
    """By a model's name: the quadrature's error, and the table's where there is one."""
    return lambda name: tolerance("energy by quadrature") + (tolerance("table, rms") if "factored" in name else 0)


@pytest.fixture
def reflected(launcher):
    """The integral of radiance over all directions of the light, by a weight, for an eye at one place or with it."""

    def reflected(name, *, view=None, by=lambda z: 1.0, squeeze=2, **given):
        light, solid_angle = hemisphere(squeeze)
        found = evaluated(launcher, name, light, light if view is None else np.array(view), **given)
        return float((found.astype(np.float64) * by(light[:, 2]) * solid_angle).sum())

    return reflected


UP = (0.0, 0.0, 1.0)
BLINN_PHONG = ["blinn-phong", "blinn-phong-factored"]
ASHIKHMIN = ["ashikhmin-shirley", "ashikhmin-shirley-factored"]


@pytest.mark.parametrize("power", [0.0, 10.0, 100.0, 1e3, 1e4])
@pytest.mark.parametrize("name", BLINN_PHONG)
def test_the_energy_normalisation_reflects_all_that_comes(reflected, limit, name, power):
    share = reflected(name, view=UP, by=lambda z: z, power=power, normalisation="energy")
    assert share == pytest.approx(1, abs=limit(name))


@pytest.mark.parametrize("power", [0.0, 10.0, 100.0, 1e3, 1e4])
@pytest.mark.parametrize(
    ("normalisation", "integral"), [("ndf", lambda p: 1.0), ("deck", lambda p: 2 * np.pi * p / (p + 2))]
)
@pytest.mark.parametrize("name", BLINN_PHONG)
def test_the_lobe_over_half_vectors(reflected, limit, name, normalisation, integral, power):
    """Light and eye at one place make it the half vector."""
    found = reflected(name, by=lambda z: z, power=power, normalisation=normalisation)
    assert found == pytest.approx(integral(power), rel=limit(name))


@pytest.mark.parametrize(("power", "ratio"), [(10, 1.075), (100, 1.018), (1000, 1.002)])
def test_the_usual_approximation_of_the_energy_is_off_by_what_is_known(launcher, tolerance, power, ratio):
    peak = evaluated(launcher, "blinn-phong", UP, UP, power=power, normalisation="energy")[0]
    assert (power + 8) / (8 * np.pi) / peak == pytest.approx(ratio, abs=tolerance("three decimals"))


@pytest.mark.parametrize("power", [0.0, 10.0, 100.0, 1e3])
@pytest.mark.parametrize("name", ["banks", "banks-factored"])
def test_strands_seen_from_across(reflected, limit, name, power):
    """V.T = 0: the integral of cos(a)^(p + 2) cos(phi), a from across, phi about the strand."""
    expected = 2 * beta((power + 3) / 2, 1 / 2)
    assert reflected(name, view=UP, power=power) == pytest.approx(expected, rel=limit(name))


@pytest.mark.parametrize("power", [0.0, 1.0, 10.0, 1e3])
@pytest.mark.parametrize("name", ["banks", "banks-factored"])
def test_normalised_strands_seen_from_across_reflect_what_comes(reflected, tolerance, name, power):
    found = reflected(name, view=UP, power=power, normalisation="energy")
    assert found == pytest.approx(1, abs=tolerance("normalised strands"))


@pytest.mark.parametrize("power", [1.0, 40.0, 4e3])
def test_a_normalised_mirror_lobe_of_lafortune(reflected, tolerance, power):
    found = reflected("lafortune", view=UP, power=power, normalisation="energy") / np.pi
    assert found == pytest.approx(1, rel=tolerance("energy by quadrature"))


@pytest.mark.parametrize("power", [1.0, 40.0, 400.0])
def test_a_mirror_lobe_of_lafortune(reflected, tolerance, power):
    """f = cos^n at normal incidence, n = power / 4, gives 2 pi / (n + 2)."""
    found = reflected("lafortune", view=UP, power=power) / np.pi
    assert found == pytest.approx(2 * np.pi / (power / 4 + 2), rel=tolerance("energy by quadrature"))


@pytest.mark.parametrize("anisotropy", [1.0, 4.0, 0.25])
@pytest.mark.parametrize("power", [10.0, 1e3])
@pytest.mark.parametrize("name", ASHIKHMIN)
def test_ashikhmin_and_shirleys_lobe_is_a_density_of_half_vectors(reflected, limit, name, power, anisotropy):
    """Light and eye at one place: C = Ks D pi / 4, with D of integral 1."""
    found = reflected(name, power=power, ks=0.5, anisotropy=anisotropy, squeeze=3)
    assert found == pytest.approx(np.pi / 8, rel=limit(name))


@pytest.mark.parametrize("name", ASHIKHMIN)
def test_ashikhmin_and_shirleys_body_seen_from_above(reflected, limit, name):
    """31/32 of Kd (1 - Ks), what is left as the eye is at N.V = 1. At Ks = 0 there is only F's (1 - H.V)^5 besides."""
    lobe = reflected(name, view=UP, power=100.0, ks=0.0)
    body = (reflected(name, view=UP, power=100.0, ks=0.0, albedo=0.8) - lobe) / np.pi
    assert body == pytest.approx(0.8 * 31 / 32, rel=limit(name))


@pytest.mark.parametrize("elevation", [0.1, 0.4, 1.0, np.pi / 2])
@pytest.mark.parametrize("ks", [0.05, 1.0])
@pytest.mark.parametrize("name", ["ashikhmin-shirley", "cook-torrance"])
def test_no_more_light_leaves_than_comes(reflected, tolerance, name, ks, elevation):
    view = (0.0, np.cos(elevation), np.sin(elevation))
    albedo = 0.5 if ks < 1 else 0.0
    share = reflected(name, view=view, power=20.0, ks=ks, albedo=albedo, squeeze=1) / np.pi
    assert 0.1 < share <= 1 + tolerance("energy by quadrature")


def test_cook_and_torrances_constant_is_four(reflected, tolerance):
    """At F = 1 and m = .3 a quarter of the 3.98 that the constants of 1982 give from above."""
    found = reflected("cook-torrance", view=UP, power=2 / 0.3**2 - 2) / np.pi
    assert found == pytest.approx(3.98 / 4, abs=tolerance("three decimals"))


def test_beckmanns_distribution_is_normalised(reflected, tolerance):
    """Light and eye at one place: C = pi D / (4 N.V) while the grooves cast no shadow, as about a narrow peak."""
    found = reflected("cook-torrance", by=lambda z: z**2, power=2e3, squeeze=3) * 4 / np.pi
    assert found == pytest.approx(1, rel=tolerance("energy by quadrature"))
