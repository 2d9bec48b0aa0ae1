"""Scale independence: pictures that are ideal filters of each other score nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from metrics import Clip, ClipError, measure_scales
from metrics.scale import area_filter

SCALES = [2 ** (-i / 2) for i in range(9)]


@pytest.fixture(scope="module")
def large():
    return np.random.default_rng(1).gamma(1.0, 1.0, (3, 180, 320))


def still(image, coverage=None):
    return Clip(lambda _: np.moveaxis(image, 0, 2), 1, coverage=None if coverage is None else lambda _: coverage)


def pyramid(image, coverage=None):
    clips = []
    for scale in SCALES:
        height, width = round(image.shape[1] * scale), round(image.shape[2] * scale)
        small = None if coverage is None else area_filter(coverage.astype(float), height, width)
        clips.append(still(area_filter(image, height, width), small))
    return clips


@pytest.mark.checks("scale.rmse", "scale.self_rmse", "scale.mean_drift", "scale.highlight", "scale.slope")
def test_ideal_pictures_score_nothing(large, tolerance):
    clips = pyramid(large)
    found = measure_scales(clips, clips, SCALES)
    for name in ("scale.rmse", "scale.self_rmse", "scale.mean_drift", "scale.slope"):
        assert found.scores[name] == pytest.approx(0, abs=tolerance("percent rounding"))
    assert found.scores["scale.highlight"] == pytest.approx(1, abs=tolerance("percent rounding"))
    assert found.curves["scale"]["scale"] == pytest.approx(SCALES)
    assert found.absent == {}


def test_what_is_not_covered_does_not_count(large, tolerance):
    coverage = np.zeros(large.shape[1:])
    coverage[60:, 40:280] = 1
    clips = pyramid(large, coverage)
    dirty = [still(clip.image(0) + 100 * ~clip.covered(0), clip.coverage(0)) for clip in clips]
    found = measure_scales(dirty, clips, SCALES)
    assert found.scores["scale.rmse"] == pytest.approx(0, abs=tolerance("percent rounding"))


@pytest.mark.checks("scale.rmse", "scale.mean_drift", "scale.slope")
def test_a_drift_by_a_percent_an_octave_has_that_slope(large, tolerance):
    clips = pyramid(large)
    faded = [still(clip.image(0) * (1 + 0.01 * np.log2(s))) for clip, s in zip(clips, SCALES, strict=True)]
    found = measure_scales(faded, clips, SCALES).scores
    assert found["scale.slope"] == pytest.approx(1.0, rel=tolerance("rounding of means"))
    assert found["scale.mean_drift"] == pytest.approx(4.0, rel=tolerance("rounding of means"))
    assert found["scale.rmse"] == pytest.approx(
        np.sqrt(np.mean([(0.01 * np.log2(s)) ** 2 for s in SCALES[1:]])), rel=tolerance("rounding of means")
    )


def test_without_a_reference_only_the_comparison_with_it_is_absent(large):
    found = measure_scales(pyramid(large), None, SCALES)
    assert found.absent == {"scale.rmse": "needs a reference"}


def test_a_black_picture_has_reasons(large):
    found = measure_scales(pyramid(0 * large), None, SCALES)
    assert found.absent["scale.mean_drift"] == "the scale-1 picture is black"
    assert "scale.highlight" in found.absent


def test_lists_that_do_not_match_are_refused(large):
    clips = pyramid(large)
    with pytest.raises(ClipError, match="for every scale"):
        measure_scales(clips, clips[:-1], SCALES)
    with pytest.raises(ClipError, match="start at 1"):
        measure_scales(clips[1:], None, SCALES[1:])
    with pytest.raises(ClipError, match=r"at scale 1 the test is \(320, 180\) px"):
        measure_scales(clips, [clips[1], *clips[1:]], SCALES)


@given(st.integers(1, 40), st.integers(1, 40))
def test_an_area_filter_keeps_the_mean_and_constants(height, width):
    image = np.random.default_rng(0).random((40, 40))
    small = area_filter(image, height, width)
    assert small.shape == (height, width)
    assert small.mean() == pytest.approx(image.mean())
    assert area_filter(np.ones((40, 40)), height, width) == pytest.approx(np.ones((height, width)))
