"""Motion that is wrong in most frames: it is said so, the right reading is named, and no cure that cures nothing."""

import numpy as np
import pytest
from waves import COUNT, HEIGHT, WIDTH, Vectors, moved, surface, uniform

from swimlab.footage.convention import Convention
from swimlab.footage.motion import FieldMotion
from swimlab.footage.verify import verify

STEPS = np.array([(2.3 + 3.4 * np.cos(0.9 * t), -0.7 + 2.1 * np.sin(0.7 * t)) for t in range(COUNT)])
"""px that each frame moves since the one before: unsteady, up to 5.7."""


class Files:
    """A reader of one vector a frame, (x, y)."""

    name = "mv"

    def __init__(self, steps):
        self.numbers = tuple(range(COUNT))
        self.header = type("H", (), {"size": (WIDTH, HEIGHT)})()
        self._steps = steps

    def read(self, index, part, channels):
        return np.broadcast_to(np.float32(self._steps[index]), (HEIGHT, WIDTH, 2))


def frames(noise=0.02):
    places = np.cumsum(STEPS, axis=0)
    random = np.random.default_rng(5)
    return [surface(*place) + noise * random.standard_normal((HEIGHT, WIDTH, 1)) for place in places]


def check(motion, pictures=None):
    pictures = pictures or frames()
    return verify(motion, lambda t: pictures[t], None, list(range(COUNT)), clean=True)


def of_files(steps, convention=None):
    motion = FieldMotion(Files(steps), 0, ("motion.X", "motion.Y"), convention or Convention(), None)
    motion.vectors.survey(range(1, COUNT))
    return motion


@pytest.mark.parametrize("velocity", [(3.0, 1.0), (2.0, 0.0), (5.4, 1.0), (-3.0, -1.0), (0.5, 0.5)])
def test_one_vector_for_an_unsteady_motion_does_not_fit_most_frames(velocity):
    """Those that a shift of the whole picture happens to explain are the best ones, and are not named."""
    found = check(uniform(velocity))
    assert found.verdict == "wrong"
    assert "does not fit most frames: in " in found.error
    assert (found.frames, found.jitter) == ((), 0.0)
    assert "--motion-jitter" not in found.error


@pytest.mark.parametrize("flip", [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_channels_in_the_wrong_order_are_named(flip):
    found = check(of_files(STEPS[:, ::-1] * np.array(flip)[::-1]))
    assert found.verdict == "wrong"
    assert "x and y swapped" in found.error
    assert "Use --motion-channels motion.Y,motion.X" in found.error
    assert ("--motion-scale" in found.error or "--motion-y" in found.error) == (flip != (1, 1))


def test_a_velocity_in_the_wrong_order_is_named():
    pictures = moved((1.5, -0.5), noise=0.02)
    assert "x and y swapped" in check(uniform((-0.5, 1.5)), pictures).error
    assert "Use --motion 1.5,-0.5" in check(uniform((-0.5, 1.5)), pictures).error


@pytest.mark.parametrize(("by", "named"), [(1, "one frame late"), (-1, "forward")])
def test_files_of_other_frames_are_named(by, named):
    """Vectors that are one frame early are forward ones, where the motion does not tell them apart."""
    found = check(of_files(np.roll(STEPS, by, axis=0)))
    assert found.verdict == "wrong"
    assert f"{named} leaves 0.1" in found.error


def test_right_files_are_verified_beside_all_readings():
    assert check(of_files(STEPS)).verdict == "verified"


@pytest.mark.parametrize("wrong", ["late", "swapped", "one axis"])
def test_a_shift_of_each_frame_that_cures_nothing_is_no_jitter(wrong):
    steps = {"late": np.roll(STEPS, 1, axis=0), "swapped": STEPS[:, ::-1], "one axis": STEPS * [1, 0]}[wrong]
    found = check(Vectors([np.broadcast_to(step, (HEIGHT, WIDTH, 2)) for step in steps]))
    assert found.verdict == "wrong"
    assert found.jitter == 0.0
    assert "--motion-jitter" not in found.error
