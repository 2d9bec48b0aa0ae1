"""Clips, bad frames, and the registry of scores."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import metrics
from metrics import METRICS, Clip, ClipError, measure
from metrics.registry import collect

GREY = np.full((64, 80, 3), 0.5, dtype=np.float32)


def bad(**options):
    options = {"frame": lambda _: GREY, "count": 3, "motion": (0.3, 0.2)} | options
    return Clip(**options)


def at(t, broken):
    """Grey frames but for one."""
    return lambda u: broken if u == t else GREY


NAN = GREY.copy()
NAN[5, 7, 1] = np.nan
INF = GREY.copy()
INF[0, 0, 0] = np.inf


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"frame": at(2, NAN)}, "frame 2 holds 1 NaN or infinite values, the first at pixel x 7, y 5"),
        ({"frame": at(1, INF)}, "frame 1 holds"),
        ({"frame": at(1, GREY[:50])}, "frame 1 is 80x50 px, but the clip is 80x64 px"),
        ({"frame": at(1, GREY[..., 0])}, "frame 1 has shape"),
        ({"frame": at(0, GREY[..., :2])}, "3 channels"),
        ({"coverage": lambda _: np.ones((3, 3))}, "coverage of frame . is 3x3 px"),
        ({"coverage": lambda _: np.full((64, 80), np.nan)}, "coverage of frame . holds"),
        ({"depth": lambda _: np.ones((3, 3))}, "depth of frame . is 3x3 px"),
        ({"motion": lambda _: np.zeros((64, 80))}, "motion of frame 1 has shape"),
        ({"motion": lambda _: np.full((64, 80, 2), np.nan)}, "motion of frame 1 holds"),
        ({"motion": lambda _: np.zeros((9, 8, 2))}, "motion of frame 1 is 8x9 px"),
    ],
)
def test_a_bad_frame_is_named(options, words):
    with pytest.raises(ClipError, match=words):
        measure(bad(**options))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"count": 0}, "at least one frame"),
        ({"fps": 0.0}, "fps is 0"),
        ({"fps": float("nan")}, "fps is nan"),
        ({"motion": (float("inf"), 0.0)}, "motion is"),
        ({"motion": (1.0,)}, "motion is"),
    ],
)
def test_a_clip_that_makes_no_sense_is_refused(options, words):
    with pytest.raises(ClipError, match=words):
        bad(**options)


def test_a_reference_must_match():
    with pytest.raises(ClipError, match="the test has 3, the reference 2 frames"):
        measure(bad(), bad(count=2))
    with pytest.raises(ClipError, match="80x64 px and the reference 80x60 px"):
        measure(bad(), bad(frame=lambda _: GREY[:60]))
    with pytest.raises(ClipError, match="reference's error of frame 0"):
        measure(bad(), bad(), reference_error=lambda _: GREY[:60])


@pytest.mark.checks("covered.fraction")
def test_motion_where_nothing_is_covered_may_be_anything(tolerance):
    covered = np.ones((64, 80))
    covered[:, :10] = 0
    motion = np.where(covered[..., None] == 1, 0.25, np.nan) * np.ones(2)
    found = measure(bad(motion=lambda _: motion, coverage=lambda _: covered), names=["residual", "covered"])
    assert found.scores["residual.flicker"] < tolerance("glued")
    assert found.scores["covered.fraction"] == 70 / 80


def test_scores_are_asked_for_by_name():
    assert set(measure(bad(), names=["residual.flicker"]).scores) == {"residual.flicker"}
    with pytest.raises(ValueError, match="no score is named plain"):
        measure(bad(), names=["plain"])


def test_an_unknown_domain_is_refused():
    with pytest.raises(ValueError, match="choose one of linear, display"):
        measure(bad(), domain="gamma")


def test_progress_is_told():
    told = []
    measure(bad(), names=["residual"], progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 3), (2, 3), (3, 3)]


def test_every_score_is_registered_and_explained():
    found = measure(bad(), bad())
    assert set(found.scores) | set(found.absent) == {
        name for name in METRICS if not name.startswith(("scale.", "quantisation."))
    }
    assert not set(found.scores) & set(found.absent)
    json.dumps(found.__dict__, allow_nan=False)
    for name, metric in METRICS.items():
        assert metric.unit, name
        assert metric.description, name
        assert metric.source, name
        assert metric.better in ("lower", "higher", "information")


def test_two_measures_may_not_share_a_name():
    one, other = (SimpleNamespace(__name__=n, SCORES={"budget.mse": METRICS["budget.mse"]}) for n in "ab")
    with pytest.raises(ValueError, match="defined in a and in b"):
        collect([one, other])


def test_exported_names_exist():
    assert all(hasattr(metrics, name) for name in metrics.__all__)


@pytest.mark.parametrize("cuts", [(0,), (4,), (2, 2), (3, 1)])
def test_cuts_are_frames_of_the_clip_in_order(cuts):
    with pytest.raises(ClipError, match="give frames of 1 to 3, each once and in order"):
        Clip(frame=lambda t: np.zeros((4, 4, 3)), count=4, cuts=cuts)
