"""Brute force: more samples come nearer to the reference."""

from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError

from sequences import load
from swimlab.render.techniques.supersample import SupersampleSettings

ROAD = load("road-shift").with_changes(size=(64, 36))


def test_the_error_falls_as_samples_grow(shoot, render):
    shot = shoot(ROAD, samples=1024)
    reference = render(shot, "reference").rgba
    errors = [
        np.sqrt(np.mean((render(shot, "supersample", samples=samples).rgba - reference) ** 2))
        for samples in (1, 4, 16, 64)
    ]
    assert all(more < 0.8 * fewer for fewer, more in pairwise(errors))
    assert errors[-1] < 0.25 * errors[0]


def test_one_sample_is_pixel_aniso(shoot, render):
    shot = shoot(ROAD, 3)
    one = render(shot, "supersample", samples=1, anisotropy=8)
    assert one.rgba.tobytes() == render(shot, "pixel-aniso", anisotropy=8).rgba.tobytes()


def test_the_error_of_a_run_is_the_references_alone(shoot, render):
    picture = render(shoot(ROAD), "supersample")
    assert picture.error is None
    assert picture.shaded == pytest.approx(4 * render(shoot(ROAD), "pixel-aniso").shaded, rel=0.05)


@pytest.mark.parametrize(("samples", "named"), [(2, "1 or 4"), (8, "4 or 9"), (0, "greater"), (1025, "less")])
def test_what_makes_no_grid_is_refused(samples, named):
    with pytest.raises(ValidationError, match=named):
        SupersampleSettings(samples=samples)
