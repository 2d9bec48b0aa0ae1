"""Motions that no single velocity describes: frames are unwarped by exact correspondence."""

import numpy as np
import pytest

from metrics import Clip, align, measure
from metrics.correspondence import follow
from metrics.spans import uniform_steps
from metrics.synthetic import Rotation

FRAMES, SIZE = 24, 150
NAMES = ["budget", "residual", "measured"]


@pytest.fixture(scope="module")
def rotation():
    return Rotation(4.0, (SIZE, SIZE))


@pytest.fixture(scope="module")
def alignment(rotation):
    blank = np.zeros((SIZE, SIZE, 3))
    return align(Clip(lambda _: blank, FRAMES, motion=rotation.motion))


def flicker(rotation, reference, error, alignment):
    test = Clip(lambda t: reference[t] + error(t), FRAMES, motion=rotation.motion)
    found = measure(test, Clip(reference.__getitem__, FRAMES), names=NAMES, alignment=alignment).scores
    parts = [found[f"budget.{part}"] for part in ("bias", "detail", "flicker")]
    assert sum(parts) == pytest.approx(found["budget.mse"])
    return found["budget.flicker"] / found["budget.mse"], found


@pytest.fixture(scope="module")
def reference(rotation, texture):
    pattern = texture(11, mean=2.0)
    return np.array([pattern.at(*rotation.surface(t)) for t in range(FRAMES)], dtype=np.float32)


def test_a_glued_error_under_rotation_hardly_flickers(rotation, reference, texture, alignment, tolerance):
    wrong = texture(12)
    share, found = flicker(rotation, reference, lambda t: 0.1 * wrong.at(*rotation.surface(t)), alignment)
    assert share < tolerance("unwarped glued")
    assert found["residual.flicker.reference"] < tolerance("unwarped glued")
    assert found["measured.fraction"] > 0.2


def test_a_screen_fixed_error_and_noise_under_rotation_are_flicker(rotation, reference, texture, alignment, tolerance):
    random = np.random.default_rng(5)
    fixed = 0.1 * texture(13).at(*rotation.surface(0))
    for error in (lambda _: fixed, lambda _: random.standard_normal((SIZE, SIZE, 3))):
        assert flicker(rotation, reference, error, alignment)[0] > tolerance("moving")


def test_correspondence_is_exact(rotation, tolerance):
    blank = np.zeros((SIZE, SIZE, 3))
    places, usable = follow(Clip(lambda _: blank, 9, motion=rotation.motion), 0, 9)
    assert places[4] is None
    for t in (0, 1, 7, 8):
        x, y = rotation.surface(4 - t)
        exact = np.stack([y, x]) + SIZE / 2 - 0.5
        assert np.abs(places[t] - exact)[:, usable].max() < tolerance("correspondence")
    assert usable.mean() > 0.3


def test_a_constant_field_is_recognised_as_uniform():
    blank = np.zeros((40, 50, 3))
    field = np.broadcast_to(np.array([0.5, -0.25]), (40, 50, 2)).copy()
    steps = uniform_steps(Clip(lambda _: blank, 5, motion=lambda _: field))
    assert steps[1:] == pytest.approx(np.tile([-0.25, 0.5], (4, 1)))
    field[3, 4, 0] = 9.0
    assert uniform_steps(Clip(lambda _: blank, 5, motion=lambda _: field)) is None
    mask = np.ones((40, 50))
    mask[3, 4] = 0.5
    assert uniform_steps(Clip(lambda _: blank, 5, motion=lambda _: field, coverage=lambda _: mask)) is not None


def test_a_camera_that_shakes_is_aligned_without_interpolation(texture, centres, tolerance):
    pattern, (x, y) = texture(14), centres(110, 110)
    places = np.random.default_rng(6).uniform(-4, 4, (10, 2))

    def motion(t):
        return np.broadcast_to(places[t] - places[t - 1], (110, 110, 2))

    clip = Clip(lambda t: pattern.at(x - places[t, 0], y - places[t, 1]), 10, motion=motion)
    found = measure(clip, names=["residual", "plane"])
    assert found.scores["residual.flicker"] < tolerance("glued")
    assert "uniform" in found.absent["plane.on"]
