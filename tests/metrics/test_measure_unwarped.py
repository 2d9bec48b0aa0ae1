"""Motions that no single velocity describes: frames are unwarped by exact correspondence."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from occluder import Occluder

from metrics import Clip, align, measure
from metrics.correspondence import Correspondence
from metrics.geometry import Geometry
from metrics.kernels.launch import Launcher
from metrics.plan import uniform_steps
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


def test_clips_that_share_an_alignment_may_be_measured_at_once(rotation, reference, alignment):
    random = np.random.default_rng(6)
    errors = [0.1 * random.standard_normal((FRAMES, SIZE, SIZE, 3)) for _ in range(3)]

    def scores(error):
        return flicker(rotation, reference, error.__getitem__, alignment)[1]

    one_by_one = [scores(error) for error in errors]
    for _ in range(3):
        with ThreadPoolExecutor(len(errors)) as pool:
            assert list(pool.map(scores, errors)) == one_by_one


def test_what_clips_of_one_alignment_share_is_whole_whoever_finds_it(rotation, reference, alignment):
    names = ["budget.alignment_floor"]
    clip = Clip(reference.__getitem__, FRAMES, motion=rotation.motion)
    expected = measure(clip, names=names).scores
    for order in ((3e6, None), (None, 3e6)):
        shared = align(clip)
        for memory in order:
            assert measure(clip, names=names, alignment=shared, memory=memory).scores == expected
    shared = align(clip)
    span = next(span for span in shared.spans if span.start <= FRAMES // 2 < span.stop)

    def slow(t):
        # In the midst of the span another clip is measured from beginning to end.
        if t == span.stop - 1:
            assert measure(clip, names=names, alignment=shared).scores == expected
        return reference[t]

    interrupted = Clip(slow, FRAMES, motion=rotation.motion)
    for _ in range(2):
        assert measure(interrupted, names=names, alignment=shared).scores == expected


@pytest.mark.parametrize("far", [3e9, 3e38])
def test_motion_beyond_all_bounds_is_not_measured(far):
    motion = np.full((96, 96, 2), 0.3, np.float32)
    motion[:8, :8] = far
    grey = np.full((96, 96, 3), 0.5, np.float32)
    found = measure(Clip(lambda _: grey, 4, motion=lambda _: motion), names=["measured", "budget"])
    assert found.scores["measured.fraction"] < 0.9


@pytest.mark.parametrize("room", [0, 1e9])
def test_correspondence_is_exact(rotation, tolerance, room):
    blank = np.zeros((SIZE, SIZE, 3))
    geometry = Geometry(Clip(lambda _: blank, 9, motion=rotation.motion), room=room)
    with Launcher() as launcher:
        found = Correspondence(geometry, launcher, 0, 9, room=room)
        places, back = (np.array([*map(np.array, each)]) for each in (found.places(slice(0, SIZE)), found.glue()))
    assert not places[4].any()
    for t in range(9):
        for seen, other in ((places[t], 4 - t), (back[t], t - 4)):
            x, y = rotation.surface(other)
            exact = np.stack([x, y], axis=2) + SIZE / 2 - centres_of(SIZE)
            assert np.abs(seen - exact)[found.usable].max() < tolerance("correspondence")
    assert found.usable.mean() > 0.3


def centres_of(size):
    return np.stack(np.broadcast_arrays(*centres(size, size)), axis=2)


def steps_of(clip):
    return uniform_steps(Geometry(clip, room=0))


def test_a_constant_field_is_recognised_as_uniform():
    blank = np.zeros((40, 50, 3))
    field = np.broadcast_to(np.array([0.5, -0.25]), (40, 50, 2)).copy()
    steps = steps_of(Clip(lambda _: blank, 5, motion=lambda _: field))
    assert steps[1:] == pytest.approx(np.tile([-0.25, 0.5], (4, 1)))
    field[3, 4, 0] = 9.0
    assert steps_of(Clip(lambda _: blank, 5, motion=lambda _: field)) is None
    mask = np.ones((40, 50))
    mask[3, 4] = 0.5
    assert steps_of(Clip(lambda _: blank, 5, motion=lambda _: field, coverage=lambda _: mask)) is not None


def test_a_camera_that_shakes_is_aligned_without_interpolation(texture, centres, tolerance):
    pattern, (x, y) = texture(14), centres(110, 110)
    places = np.random.default_rng(6).uniform(-4, 4, (10, 2))

    def motion(t):
        return np.broadcast_to(places[t] - places[t - 1], (110, 110, 2))

    clip = Clip(lambda t: pattern.at(x - places[t, 0], y - places[t, 1]), 10, motion=motion)
    found = measure(clip, names=["residual", "plane"])
    assert found.scores["residual.flicker"] < tolerance("glued")
    assert "uniform" in found.absent["plane.on"]


@pytest.mark.checks("budget.alignment_floor")
def test_the_alignment_floor_is_told_for_motion_that_is_not_uniform(rotation, reference, alignment, tolerance):
    clip = Clip(reference.__getitem__, FRAMES, motion=rotation.motion, depth=lambda _: np.full((SIZE, SIZE), 7.0))
    found = measure(clip, names=["budget.alignment_floor"])
    for name in ("budget.alignment_floor", "budget.alignment_floor.mid"):
        assert 0 < found.scores[name] < tolerance("alignment floor")
    assert "no tile" in found.absent["budget.alignment_floor.near"]
    still = measure(Clip(reference.__getitem__, FRAMES), names=["budget.alignment_floor"])
    assert "moves as one" in still.absent["budget.alignment_floor"]


@pytest.mark.parametrize("speed", [(1.1, 0.6), (4.0, 0.4), (23.0, 0.0)])
def test_an_occluder_makes_no_flicker_in_what_is_measured(speed, tolerance):
    scene = Occluder((0.72, -0.3), speed, SIZE)
    found = measure(Clip(scene.frame, 16, motion=scene.motion), names=["residual", "measured"]).scores
    assert found["residual.flicker"] < tolerance("occluded")
    assert 0.05 < found["measured.fraction"] < 0.9


def test_a_masked_occluder_leaves_a_uniform_motion(tolerance):
    scene = Occluder((0.72, -0.3), (4.0, 0.4), SIZE)
    clip = Clip(scene.frame, 16, motion=(0.72, -0.3), coverage=lambda t: 1.0 - scene.hidden(t)[..., 0])
    found = measure(clip, names=["residual", "covered"]).scores
    assert found["residual.flicker"] < tolerance("glued")
    assert found["covered.fraction"] < 1
