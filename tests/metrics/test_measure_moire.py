"""Moire against zone plates, and its silence over noise."""

import numpy as np
import pytest
from scipy import ndimage

from metrics import Clip, measure
from metrics.display import encode

CHIRP = 1 / 9000
HEIGHT, WIDTH = 128, 160


def zone_plate(frequency, angle, samples):
    """A crop of cos(pi CHIRP r^2) round the place where its local frequency is as given, [H, W, 3]."""
    kx, ky = frequency * np.cos(angle), frequency * np.sin(angle)
    x, y = np.meshgrid(
        np.arange(WIDTH) + 0.5 - WIDTH / 2 + kx / CHIRP, np.arange(HEIGHT) + 0.5 - HEIGHT / 2 + ky / CHIRP
    )
    parts = (np.arange(samples) + 0.5) / samples - 0.5
    plates = [np.cos(np.pi * CHIRP * ((x + a) ** 2 + (y + b) ** 2)) for a in parts for b in parts]
    return np.repeat(2 + np.mean(plates, axis=0)[..., None], 3, axis=2)


def compare(test, reference):
    return measure(Clip(lambda _: test, 1), Clip(lambda _: reference, 1), names=["moire"])


@pytest.mark.parametrize("frequency", [0.62, 0.7, 0.85, 1.2])
@pytest.mark.parametrize("samples", [1, 2, 3])
@pytest.mark.checks("moire.peak_frequency")
def test_peaks_stand_at_the_alias_frequencies_of_a_zone_plate(frequency, samples, tolerance):
    angle = np.radians(20)
    k = frequency * np.array([np.cos(angle), np.sin(angle)])
    alias = np.hypot(*(k - np.round(k)))
    found = compare(zone_plate(frequency, angle, samples), zone_plate(frequency, angle, 12)).scores
    assert found["moire.peak_frequency"] == pytest.approx(alias, rel=tolerance("peak"))
    assert found["moire.peak_strength"] > 20


def test_a_picture_within_the_pixel_nyquist_has_no_moire():
    plate = zone_plate(0.3, 0.4, 1)
    found = compare(plate, plate)
    assert found.scores["moire.excess"] == 0
    assert "no peak" in found.absent["moire.peak_frequency"]
    assert "no peak" in found.absent["moire.peak_strength"]


@pytest.mark.checks("moire.peak_strength")
def test_filtered_noise_shows_no_peaks():
    found = 0
    for seed in range(40):
        random = np.random.default_rng(seed)
        test, reference = (ndimage.gaussian_filter(random.standard_normal((96, 96, 3)), (s, s, 0)) for s in (1.0, 1.5))
        found += "moire.peak_frequency" in compare(test, reference).scores
    assert found == 0


@pytest.mark.checks("moire.excess")
def test_excess_counts_what_the_reference_has_not(tolerance):
    x = np.arange(WIDTH) * np.ones((HEIGHT, 1))
    reference = np.repeat(np.cos(2 * np.pi * 0.125 * x)[..., None], 3, axis=2)
    extra = np.repeat(0.5 * np.cos(2 * np.pi * 0.375 * x)[..., None], 3, axis=2)
    assert compare(reference + extra, reference).scores["moire.excess"] == pytest.approx(
        0.25, rel=tolerance("window leak")
    )
    assert compare(reference / 2, reference).scores["moire.excess"] == pytest.approx(0, abs=tolerance("rounding"))


def test_the_display_curve_is_srgb(tolerance):
    known = {0.0: 0.0, 0.0031308: 0.04045, 0.2140411: 0.5, 1.0: 1.0, 7.0: 1.0, -1.0: 0.0}
    assert encode(np.array(list(known))) == pytest.approx(list(known.values()), abs=tolerance("srgb"))
