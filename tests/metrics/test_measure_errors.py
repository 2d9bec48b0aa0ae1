"""Standard errors, what they resolve, and the budget by octave."""

import numpy as np
import pytest

from metrics import METRICS, Clip, measure, measure_scales, resolved
from metrics.ratios import Ratios, overlap
from metrics.spectra import OCTAVES

MOTION = (23 / 32, 19 / 32)


def noise(seed, count=4, height=130, width=160):
    return np.random.default_rng(seed).standard_normal((count, height, width, 3), dtype=np.float32)


def compare(error, **options):
    nothing = np.zeros_like(error)
    clip = Clip(error.__getitem__, len(error), motion=MOTION)
    return measure(clip, Clip(nothing.__getitem__, len(error)), **options)


def test_standard_errors_are_the_spread_of_many_clips(tolerance):
    found = [compare(noise(seed), names=["budget"]) for seed in range(60)]
    for name in ("budget.mse", "budget.flicker", "budget.detail", "budget.bias"):
        spread = np.std([m.scores[name] for m in found], ddof=1)
        stated = np.mean([m.errors[name] for m in found])
        assert stated / spread == pytest.approx(1, abs=tolerance("spread of 60")), name


def test_every_score_has_its_standard_error():
    error = noise(0, count=30)
    error += np.cos(2.6 * np.arange(160))[:, None]
    depth = np.linspace(1, 30, 130)[:, None] * np.ones(160)
    test = Clip((5 + error).__getitem__, 30, motion=MOTION, depth=lambda _: depth, pixels_per_degree=40)
    reference = np.random.default_rng(1).standard_normal((30, 130, 160, 3)) + 5
    found = measure(test, Clip(reference.__getitem__, 30), reference_error=lambda t: error[t] / 9)
    assert len(found.scores) > 20
    assert set(found.errors) == set(found.scores) <= set(METRICS)
    assert all(np.isfinite(error) and error >= 0 for error in found.errors.values())


def test_a_single_tile_has_no_known_error():
    found = compare(noise(0, height=70, width=70), names=["budget.mse"])
    assert found.scores
    assert not found.errors


def test_a_ratio_and_its_error_in_closed_form(tolerance):
    ratios = Ratios()
    weight, part = np.array([1.0, 2.0, 1.0, 4.0]), np.array([1.0, 3.0, 2.0, 2.0])
    ratios.add(64, weight[:1], {"part": part[:1]})
    ratios.add(64, weight[1:], {"part": part[1:]})
    away = part - weight
    variance = overlap(64) * 4 / 3 * np.sum(away**2) / 64
    assert ratios.value("part") == 1
    assert ratios.error("part") == pytest.approx(np.sqrt(variance), rel=tolerance("closed form"))


def entry(score, value, error, floor=None):
    scores = {score: value} | ({} if floor is None else {"budget.floor": floor})
    return {"scores": scores, "errors": {} if error is None else {score: error}}


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        (entry("budget.mse", 1.0, 0.1), entry("budget.mse", 1.5, 0.1), True),
        (entry("budget.mse", 1.0, 0.2), entry("budget.mse", 1.5, 0.2), False),
        (entry("budget.mse", 1.0, 0.1, floor=0.6), entry("budget.mse", 1.5, 0.1, floor=0.1), False),
        (entry("plane.on", 1.0, 0.1, floor=0.6), entry("plane.on", 1.5, 0.1), True),
        (entry("budget.mse", 1.0, None), entry("budget.mse", 1.5, 0.1), False),
        (entry("budget.mse", 1.0, 0.0), entry("budget.mse", 1.0, 0.0), False),
    ],
)
def test_a_difference_is_resolved_beyond_two_sigma_and_the_floor(one, other, expected):
    (score,) = set(one["scores"]) - {"budget.floor"}
    assert resolved(score, one, other) is expected
    assert resolved(score, other, one) is expected


def test_one_clip_is_not_resolved_from_another_of_its_kind_but_from_one_twice_as_wrong():
    one, other, twice = (vars(compare(e, names=["budget"])) for e in (noise(1), noise(2), 2 * noise(3)))
    assert not resolved("budget.flicker", one, other)
    assert resolved("budget.flicker", one, twice)


def test_octaves_add_up_to_the_squared_error_and_to_its_parts(tolerance):
    found = compare(noise(4) + 0.3, names=["budget"])
    octaves, scores = found.curves["budget.bands"], found.scores
    assert octaves["frequency"] == list(OCTAVES)
    total = sum(octaves["static"]) + sum(octaves["flicker"])
    assert total == pytest.approx(scores["budget.mse"], rel=tolerance("budget"))
    assert sum(octaves["flicker"]) == pytest.approx(scores["budget.flicker"], rel=tolerance("budget"))
    assert sum(octaves["static"][:2]) == pytest.approx(scores["budget.bias"], rel=tolerance("budget"))
    assert sum(octaves["static"][2:]) == pytest.approx(scores["budget.detail"], rel=tolerance("budget"))


@pytest.mark.parametrize(("frequency", "octave"), [(0.008, 0), (0.045, 1), (0.09, 2), (0.18, 3), (0.36, 4)])
def test_a_wave_is_in_its_octave(frequency, octave, tolerance):
    x = np.arange(160) + 0.5
    wave = np.array([np.cos(2 * np.pi * frequency * (x - t * MOTION[0])) for t in range(4)], dtype=np.float32)
    glued = np.broadcast_to(wave[:, None, :, None], (4, 130, 160, 3))
    signs = np.array([1, -1, 1, -1], dtype=np.float32)[:, None, None, None]
    for error, part in ((glued, "static"), (glued * signs, "flicker")):
        octaves = compare(error, names=["budget"]).curves["budget.bands"][part]
        assert octaves[octave] > tolerance("wave in its octave") * sum(octaves)


def test_scores_over_scales_have_the_spread_of_many_pictures(tolerance):
    def pictures(seed):
        random = np.random.default_rng(seed)
        return [1 + random.standard_normal((128 // n, 256 // n, 3)) / 4 for n in (1, 2, 4, 8)]

    def clips(seed):
        return [Clip(lambda _, p=picture: p, 1) for picture in pictures(seed)]

    found = [measure_scales(clips(2 * i), clips(2 * i + 1), [1, 1 / 2, 1 / 4, 1 / 8]) for i in range(40)]
    for name in ("scale.rmse", "scale.self_rmse"):
        spread = np.std([m.scores[name] for m in found], ddof=1)
        stated = np.mean([m.errors[name] for m in found])
        assert stated / spread == pytest.approx(1, abs=tolerance("spread of 60")), name
    assert set(found[0].errors) == set(found[0].scores)
