"""A picture that stands still while its light changes."""

import json
from pathlib import Path

import numpy as np
import pytest

from sequences import load
from swimlab.render.geometry import describe_geometry

SWEPT = load("road-sun").with_changes(size=(64, 36))


@pytest.mark.parametrize("technique", ["pixel-aniso", "tsl", "vertex", "reference"])
def test_a_frame_is_lit_by_its_own_sun(shoot, render, technique):
    """Frame 6 is, bit by bit, a still picture under the sun of frame 6."""
    given = {"size": 64} if technique == "tsl" else {}
    sun = {"azimuth": -3.5 + 6.0, "elevation": 14.0, "diffuse": 0.6}
    still = SWEPT.with_changes(scene={"sun": sun}, motion={"kind": "shift"})
    swept, fixed = (render(shoot(*each), technique, **given).rgba for each in ((SWEPT, 6), (still, 0)))
    assert np.array_equal(swept, fixed)
    assert not np.array_equal(swept, render(shoot(SWEPT), technique, **given).rgba)


def test_nothing_moves(shoot, tolerance):
    first, later = (describe_geometry(shoot(SWEPT, frame)) for frame in (0, 9))
    assert np.abs(later.motion).max() <= tolerance("motion")
    assert np.array_equal(first.depth, later.depth)
    assert np.array_equal(first.coverage, later.coverage)


def test_its_error_is_measured_and_what_needs_motion_is_absent(swimlab):
    words = ["study", "road-sun", "--size", "128x72", "--frames", "0-3", "--samples", "16", "-t", "pixel-aniso,tsl"]
    code, _, err = swimlab(*words, "-o", "run", "-q")
    assert code == 0, err
    aniso, tsl = json.loads(Path("run/scores.json").read_text(encoding="utf-8"))["sequences"]
    for entry in (aniso, tsl):
        assert {"budget.mse", "budget.flicker", "residual.flicker"} <= set(entry["scores"])
        assert "nothing moves" in entry["absent"]["plane.on"] + entry["absent"]["plane.order1"]
    assert tsl["scores"]["budget.mse"] < aniso["scores"]["budget.mse"]
    # The light's own change is flicker of the reference too, and no error.
    assert tsl["scores"]["residual.flicker.reference"] > 0.1 * tsl["scores"]["budget.flicker"]
