"""A reference that several tests share, held or made again."""

import numpy as np
import pytest

from metrics import Clip, ReferenceFrames, align, measure
from metrics.synthetic import Rotation

FRAMES, SIZE = 6, 120
FRAME_BYTES = 2 * 3 * 4 * SIZE**2


@pytest.fixture(scope="module", params=["rotation", "shift"])
def frames(request, texture):
    """Test frames, reference frames, its half-differences, and the motion."""
    random = np.random.default_rng(3)
    if request.param == "shift":
        exact, wrong, half = random.random((3, FRAMES, SIZE, SIZE, 3), np.float32)
        return wrong, exact, half, (0.7, 0.3)
    turning = Rotation(4.0, (SIZE, SIZE))
    pattern = texture(11, mean=2.0)
    exact = np.array([pattern.at(*turning.surface(t)) for t in range(FRAMES)], np.float32)
    noise, half = 0.1 * random.standard_normal((2, *exact.shape), np.float32)
    return exact + noise, exact, half, turning.motion


@pytest.mark.parametrize("room", [0, 2.5 * FRAME_BYTES, 1e9])
def test_what_is_held_changes_no_bit(frames, room):
    wrong, exact, half, motion = frames
    test, reference = (Clip(each.__getitem__, FRAMES, motion=motion) for each in (wrong, exact))
    alone = measure(test, reference, reference_error=half.__getitem__)
    exact, alignment = ReferenceFrames(reference, error=half.__getitem__, room=room), align(test)
    for _ in range(2):
        assert measure(test, exact, alignment=alignment).scores == alone.scores


def test_frames_that_fit_are_read_once():
    count = [0] * FRAMES
    random = np.random.default_rng(4).random((FRAMES, SIZE, SIZE, 3), np.float32)

    def read(t):
        count[t] += 1
        return random[t]

    test = Clip(random.__getitem__, FRAMES)
    reference = Clip(read, FRAMES)
    exact, alignment = ReferenceFrames(reference, room=1e9), align(test)
    for _ in range(3):
        measure(test, exact, alignment=alignment, names=["budget"])
    assert count == [1] * FRAMES


def test_a_reference_of_another_domain_is_refused():
    flat = Clip(lambda _: np.ones((32, 32, 3), np.float32), 2)
    with pytest.raises(ValueError, match="reference is of another domain"):
        measure(flat, ReferenceFrames(flat), domain="display")


def test_an_error_of_no_reference_is_refused():
    flat = Clip(lambda _: np.ones((32, 32, 3), np.float32), 2)
    for reference in (None, ReferenceFrames(flat)):
        with pytest.raises(ValueError, match="needs a clip as reference"):
            measure(flat, reference, reference_error=lambda _: np.zeros((32, 32, 3)))
