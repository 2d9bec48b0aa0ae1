"""Few pixels that rule a squared error are told; many, and errors as a screen shows them, are not."""

import numpy as np
import pytest

from metrics import Clip, measure
from metrics.glints import SHARE, Glints, count
from metrics.kernels.launch import Launcher

SIZE, COUNT = 96, 4


def test_the_largest_errors_are_those_of_a_sorted_list(tolerance):
    """To within the width of a bin, a quarter of an octave."""
    random = np.random.default_rng(1)
    error = random.pareto(1.2, (7, 90, 80)).astype(np.float32)
    covered, reached = random.random((2, 7, 90, 80)) < 0.7
    reached &= covered
    glints = Glints()
    with Launcher() as launcher:
        for frame, *masks in zip(error, covered, reached, strict=True):
            glints.take(count(np.stack([frame] * 3), *masks, launcher))
    for name, where in (("budget.mse", reached), ("frame.mse", covered)):
        squared = np.sort(error[where].astype(np.float64) ** 2)[::-1]
        exact = squared[: round(SHARE * len(squared))].sum()
        few = glints.few()[name]
        assert few.share == pytest.approx(exact / squared.sum(), rel=tolerance("bin of squares"))
        assert few.rms == pytest.approx(np.sqrt(exact / (SHARE * len(squared))), rel=tolerance("bin of squares"))
    assert Glints().few()["frame.mse"].share == 0.0


def notes(glint, domain="linear", every=2000):
    """Noise of .01 rms; `glint` is added to every so many pixels, elsewhere in each frame."""
    random = np.random.default_rng(2)

    def frame(t):
        return np.full((SIZE, SIZE, 3), 0.2)

    def test(t):
        picture = frame(t) + 0.01 * random.standard_normal((SIZE, SIZE, 3))
        picture.reshape(-1, 3)[5 + 7 * t :: every] += glint
        return picture

    found = measure(Clip(test, COUNT), Clip(frame, COUNT), domain=domain, names=("frame", "budget"))
    return [note for note in found.notes if "thousandth" in note]


def test_glints_are_said_with_the_display_domain_as_the_way_out():
    (note,) = notes(100.0)
    assert "rms error 74, makes 100% of budget.mse and 100% of frame.mse: glints or fireflies" in note
    assert "--domain display" in note


def test_a_few_pixels_that_are_wrong_are_no_glints():
    (note,) = notes(0.7)
    assert "a few places rule" in note
    assert "display" not in note


@pytest.mark.parametrize(
    "options", [{"glint": 0.1}, {"glint": 100.0, "domain": "display"}, {"glint": 1.0, "every": 20}]
)
def test_what_many_pixels_make_is_not(options):
    assert notes(**options) == []
