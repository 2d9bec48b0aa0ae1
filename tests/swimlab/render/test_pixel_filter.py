"""The reference's pixel filters against closed forms."""

import numpy as np
import pytest
import warp as wp
from pydantic import ValidationError

from sequences import load
from swimlab.render.catalogue import techniques
from swimlab.render.kernels.pixel_filter import FILTERS, gaussian, mitchell

ROAD = load("road-shift").with_changes(size=(48, 32), camera={"pitch": -30.0})


@wp.kernel(enable_backward=False)
def weights(x: wp.array(dtype=wp.float32), gauss: wp.array(dtype=wp.float32), cubic: wp.array(dtype=wp.float32)):
    i = wp.tid()
    gauss[i] = gaussian(x[i])
    cubic[i] = mitchell(x[i])


@pytest.fixture(scope="module")
def sampled(launcher):
    x = np.linspace(-3, 3, 601).astype(np.float32)
    gauss, cubic = launcher.empty(len(x), wp.float32), launcher.empty(len(x), wp.float32)
    launcher.launch(weights, len(x), [launcher.array(x, wp.float32), gauss, cubic])
    return x.astype(np.float64), gauss.numpy(), cubic.numpy()


def test_gaussian_is_the_closed_form_and_ends_at_its_radius(sampled, tolerance):
    x, gauss, _ = sampled
    exact = np.maximum(np.exp(-2 * x**2) - np.exp(-2 * 1.5**2), 0)
    assert gauss == pytest.approx(exact, abs=tolerance("weights in float32"))
    assert not gauss[np.abs(x) > 1.5 + 1e-6].any()


def test_mitchell_is_a_partition_of_unity_with_negative_lobes(sampled, tolerance):
    x, _, cubic = sampled
    shifts = [cubic[(x >= k - 1e-6) & (x < k + 1 - 1e-6)][:100] for k in (-2, -1, 0, 1)]
    assert np.sum(shifts, axis=0) == pytest.approx(np.ones(100), abs=tolerance("cubic in float32"))
    assert cubic[np.abs(np.abs(x) - 1.5) < 0.01].max() < 0
    assert not cubic[np.abs(x) > 2 + 1e-6].any()


@pytest.mark.parametrize("name", sorted(FILTERS))
def test_uniform_light_stays_uniform_and_has_no_error(shoot, render, pack_maps, tolerance, name):
    flat = np.broadcast_to([0.2, 0.4, 0.6, 0.0, 0.0, 1.0, 0.0, 0.0], (64, 64, 8)).astype(np.float32)
    picture = render(shoot(ROAD, 0, pack_maps(flat), samples=16), "reference", filter=name)
    whole = picture.rgba[..., 3] == 1
    assert whole.mean() > 0.5
    sun = ROAD.scene.sun
    exact = np.array([0.2, 0.4, 0.6]) * np.sin(np.radians(sun.elevation)) * sun.diffuse
    light = picture.rgba[whole][:, :3]
    assert light == pytest.approx(np.broadcast_to(exact, light.shape), rel=tolerance("constant light"))
    assert np.abs(picture.error[whole]).max() < tolerance("constant light")


@pytest.mark.parametrize("name", sorted(FILTERS))
def test_wider_filters_keep_the_mean_and_change_the_detail(shoot, render, name):
    shot = shoot(ROAD, 0, samples=36)
    box, wide = render(shot, "reference").rgba, render(shot, "reference", filter=name).rgba
    inner = np.s_[4:-4, 4:-4, :3]
    spread = box[inner].std()
    assert abs(wide[inner].mean() - box[inner].mean()) < 0.05 * spread
    assert 0.02 * spread < np.abs(wide[inner] - box[inner]).mean() < spread


def test_a_filter_that_does_not_exist_is_refused():
    with pytest.raises(ValidationError, match="gaussian"):
        techniques()["reference"].settings(filter="sinc")
