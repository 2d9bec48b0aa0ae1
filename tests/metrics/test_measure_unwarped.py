"""Motions that no single velocity describes: frames are unwarped by exact correspondence."""

import numpy as np
import pytest

from metrics import Clip, align, measure
from metrics.correspondence import follow
from metrics.spans import uniform_steps
from metrics.synthetic import Rotation, centres

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


def test_the_alignment_floor_is_told_for_motion_that_is_not_uniform(rotation, reference, alignment, tolerance):
    clip = Clip(reference.__getitem__, FRAMES, motion=rotation.motion, depth=lambda _: np.full((SIZE, SIZE), 7.0))
    found = measure(clip, names=["budget.alignment_floor"])
    for name in ("budget.alignment_floor", "budget.alignment_floor.mid"):
        assert 0 < found.scores[name] < tolerance("alignment floor")
    assert "no tile" in found.absent["budget.alignment_floor.near"]
    still = measure(Clip(reference.__getitem__, FRAMES), names=["budget.alignment_floor"])
    assert "moves as one" in still.absent["budget.alignment_floor"]


class Occluder:
    """A square that moves over a background, each with a texture glued to it."""

    def __init__(self, behind, before, texture):
        self.speeds, self.textures = (behind, before), [texture(seed, mean=2.0) for seed in (21, 22)]
        self.x, self.y = np.broadcast_arrays(*centres(SIZE, SIZE))

    def hidden(self, t):
        (dx, dy) = self.speeds[1]
        across, along = self.x - 30 - dx * t, self.y - 75 - dy * t
        return ((np.abs(across) < 24) & (np.abs(along) < 24))[..., None]

    def frame(self, t):
        moved = ((self.x - dx * t, self.y - dy * t) for dx, dy in self.speeds)
        back, front = (texture.at(*place) for texture, place in zip(self.textures, moved, strict=True))
        return np.where(self.hidden(t), front, back)

    def motion(self, t):
        return np.where(self.hidden(t), self.speeds[1], self.speeds[0])


@pytest.mark.parametrize("speed", [(1.1, 0.6), (4.0, 0.4), (23.0, 0.0)])
def test_an_occluder_makes_no_flicker_in_what_is_measured(speed, texture, tolerance):
    scene = Occluder((0.72, -0.3), speed, texture)
    found = measure(Clip(scene.frame, 16, motion=scene.motion), names=["residual", "measured"]).scores
    assert found["residual.flicker"] < tolerance("occluded")
    assert 0.05 < found["measured.fraction"] < 0.9


def test_a_masked_occluder_leaves_a_uniform_motion(texture, tolerance):
    scene = Occluder((0.72, -0.3), (4.0, 0.4), texture)
    clip = Clip(scene.frame, 16, motion=(0.72, -0.3), coverage=lambda t: 1.0 - scene.hidden(t)[..., 0])
    found = measure(clip, names=["residual", "covered"]).scores
    assert found["residual.flicker"] < tolerance("glued")
    assert found["covered.fraction"] < 1
