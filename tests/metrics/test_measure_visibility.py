"""Visible flicker against Kelly's published curve and closed forms."""

import numpy as np
import pytest

from metrics import Clip, measure
from metrics.visibility import SEGMENT, kelly

SIZE, COUNT, FPS, PPD = 128, 16, 64.0, 32.0


@pytest.mark.parametrize(("temporal", "spatial", "value"), [(5, 1, 179.473), (10, 1, 105.555), (15, 4, 26.645)])
def test_sensitivity_is_that_of_kelly(temporal, spatial, value, tolerance):
    assert float(kelly(temporal, spatial)) == pytest.approx(value, rel=tolerance("kelly"))


def test_sensitivity_is_finite_and_vanishes_at_rest():
    f = np.array([0.0, 1e-9, 1e-3, 1.0, 60.0, 1e4])
    values = kelly(f[:, None], f[None, :])
    assert np.isfinite(values).all()
    assert (values >= 0).all()
    assert not values[0].any()
    assert not values[:, 0].any()


def clips(contrast, *, temporal=8.0, cycles=8, motion=(0.0, 0.0), **viewing):
    """A grating on the surface whose contrast swings at `temporal` Hz about a level of 1, and that level."""
    x = np.arange(SIZE) + 0.5
    level = np.ones((SIZE, SIZE, 3), np.float32)

    def frame(t):
        swing = contrast * np.cos(2 * np.pi * temporal * t / FPS)
        wave = swing * np.cos(2 * np.pi * cycles / SIZE * (x - motion[0] * t))
        return level + np.broadcast_to(wave[None, :, None], level.shape).astype(np.float32)

    given = {"fps": FPS, "motion": motion, "pixels_per_degree": PPD} | viewing
    return Clip(frame, COUNT, **given), Clip(lambda t: level, COUNT, **given)


def visible(contrast, **given):
    return measure(*clips(contrast, **given), names=["visible"]).scores["visible.flicker"]


@pytest.mark.parametrize("motion", [(0.0, 0.0), (0.37, 0.0)])
@pytest.mark.checks("visible.flicker")
def test_a_swinging_grating_has_its_contrast_over_threshold(motion, tolerance):
    """cos cos is two waves that travel apart, each of half the contrast; the taper spreads them over three bins."""
    taper = np.sin(np.pi * (np.arange(SEGMENT) + 0.5) / SEGMENT) ** 2
    wave = taper * np.cos(2 * np.pi * np.arange(SEGMENT) / SEGMENT)
    power = np.abs(np.fft.fft(wave)) ** 2 / (SEGMENT * np.sum(taper**2))
    f = np.abs(np.fft.fftfreq(SEGMENT, 1 / FPS))
    exact = 0.1 * np.sqrt(np.sum(power * kelly(f, 8 / SIZE * PPD) ** 2))
    assert visible(0.1, motion=motion) == pytest.approx(exact, rel=tolerance("visible grating"))


def test_visibility_is_proportional_to_contrast(tolerance):
    assert visible(0.2) == pytest.approx(2 * visible(0.1), rel=tolerance("weights in float32"))


def test_what_the_eye_cannot_resolve_counts_little():
    assert visible(0.1, cycles=48) < 0.05 * visible(0.1, cycles=8)


def test_a_glued_error_is_not_flicker():
    assert visible(0.1, temporal=0.0, motion=(0.37, 0.0)) < 1e-2 * visible(0.1)


@pytest.mark.parametrize(
    ("given", "domain", "reason"), [({"pixels_per_degree": None}, "linear", "per degree"), ({}, "display", "linear")]
)
def test_without_viewing_geometry_it_is_absent(given, domain, reason):
    found = measure(*clips(0.1, **given), names=["visible"], domain=domain)
    assert reason in found.absent["visible.flicker"]


def test_dim_pictures_are_noted():
    assert any("cd/m^2" in note for note in measure(*clips(0.1, luminance=2.0), names=["visible"]).notes)
    assert not any("cd/m^2" in note for note in measure(*clips(0.1, luminance=200.0), names=["visible"]).notes)
