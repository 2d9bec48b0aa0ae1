"""Standard errors, what they resolve, and the budget by octave."""

import numpy as np
import pytest

from metrics import METRICS, Clip, Measurement, measure, measure_scales, quantisation, resolved, synthetic
from metrics.octaves import OCTAVES
from metrics.ratios import BLOCKS, RUN, Ratios, difference_error, jackknife, logarithmic_mean, overlap

MOTION = (23 / 32, 19 / 32)


def noise(seed, count=4, height=130, width=160):
    return np.random.default_rng(seed).standard_normal((count, height, width, 3), dtype=np.float32)


def compare(error, **options):
    nothing = np.zeros_like(error)
    clip = Clip(error.__getitem__, len(error), motion=MOTION)
    return measure(clip, Clip(nothing.__getitem__, len(error)), **options)


def glued(seed, motion, count, height=130, width=160):
    """A white picture without the highest frequencies, shifted by their phases: wraps round."""
    kx, ky = np.fft.rfftfreq(width)[None, :], np.fft.fftfreq(height)[:, None]
    spectrum = np.fft.rfft2(noise(seed, 1, height, width)[0], axes=(0, 1)) * (np.hypot(kx, ky) < 0.4)[..., None]
    turns = [np.exp(-2j * np.pi * t * (kx * motion[0] + ky * motion[1]))[..., None] for t in range(count)]
    return np.stack([np.fft.irfft2(spectrum * turn, (height, width), axes=(0, 1)) for turn in turns])


def test_standard_errors_are_the_spread_of_many_clips(tolerance):
    found = [compare(noise(seed) + glued(seed + 100, MOTION, 4), names=["budget"]) for seed in range(60)]
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


def plates(seed, count=8, width=200, height=130):
    """A point-sampled zone plate, next to even, against a filtered one, both noisy; and the latter's noise."""
    motion = (0.375, 0.0)
    options = {"count": count, "size": (width, height), "motion": motion}
    test, reference = (synthetic.zone_plate(0.7, 0.35, samples=n, **options) for n in (1, 3))
    grain, half = noise(seed, count, height, width), 0.3 * noise(seed + 1000, count, height, width)
    grain += glued(seed + 2000, motion, count, height, width)
    depth = np.linspace(1, 30, height)[:, None] * np.ones(width)
    return measure(
        Clip(lambda t: test.frame(t) + grain[t], count, motion=motion, depth=lambda _: depth, pixels_per_degree=40),
        Clip(lambda t: reference.frame(t) + half[t], count, motion=motion),
        reference_error=lambda t: half[t],
    )


def test_every_standard_error_is_the_spread_of_noisy_zone_plates(monkeypatch, tolerance):
    monkeypatch.setattr(synthetic, "CHIRP", 1e-6)
    found = [plates(seed) for seed in range(20)]
    names = set(found[0].scores)
    assert {"moire.excess", "moire.peak_frequency", "moire.peak_strength", "plane.order1", "visible.flicker"} <= names
    for name in names:
        spread = np.std([m.scores[name] for m in found], ddof=1)
        stated = np.mean([m.errors[name] for m in found])
        if name == "edges.floor" or name.endswith(".fraction"):
            assert stated == 0
            assert len({m.scores[name] for m in found}) == 1
        else:
            assert abs(np.log2(stated / spread)) < tolerance("octave of a standard error"), name


def test_a_peak_is_followed_where_a_part_of_the_picture_does_not_show_it(tolerance):
    """A faint wave in one upright strip only: without that strip no peak stands out, yet its error is known."""
    error = noise(7, count=2, width=320)
    across = np.exp(-(((np.arange(320) - 60) / 30) ** 2)) * np.cos(2 * np.pi * 0.3125 * np.arange(320))
    error += 1.2 * across.astype(np.float32)[:, None]
    found = compare(error, names=["moire"])
    assert found.scores["moire.peak_frequency"] == pytest.approx(0.3125, rel=tolerance("peak"))
    assert 0 < found.errors["moire.peak_frequency"] < 1 / 32
    assert found.errors["moire.peak_strength"] > 1


def test_a_picture_that_is_black_but_for_one_strip_has_an_excess_of_unknown_error():
    error = noise(2, width=320)
    light = np.zeros_like(error)
    light[:, :, 10:50] = noise(3, width=40) + 2
    clips = [Clip(each.__getitem__, len(each), motion=MOTION) for each in (light + error, light)]
    found = measure(*clips, names=["moire"])
    assert found.scores["moire.excess"] > 0
    assert "moire.excess" not in found.errors


def test_a_single_tile_has_no_known_error_and_says_so():
    found = compare(noise(0, height=70, width=70), names=["budget", "residual"])
    assert found.scores
    assert not found.errors
    assert any("no standard error of budget.bias" in note and "more" in note for note in found.notes)
    assert not any("no standard error" in note for note in compare(noise(0), names=["budget"]).notes)


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


def test_what_the_surface_does_to_both_cancels_in_a_difference():
    """Energies of tiles differ by decades, as on a road; the second technique errs a twentieth more on each."""
    random = np.random.default_rng(8)
    scale = np.exp(random.normal(0, 1.5, 400))
    ratios = {name: Ratios() for name in ("one", "more", "elsewhere")}
    for _ in range(2):
        ratios["one"].add(32, np.ones(200), {"part": scale[:200]})
        ratios["more"].add(32, np.ones(200), {"part": 1.05 * scale[:200] * random.normal(1, 0.05, 200)})
        ratios["elsewhere"].add(32, np.ones(200), {"part": scale[200:]})
    found = {}
    for name, each in ratios.items():
        measured = Measurement()
        measured.put("plane.off", each.value("part"), "", error=each.error("part"), replicates=each.replicates("part"))
        found[name] = vars(measured)
    paired = difference_error("plane.off", found["one"], found["more"])
    assert 0 < paired < 0.1 * np.hypot(found["one"]["errors"]["plane.off"], found["more"]["errors"]["plane.off"])
    assert resolved("plane.off", found["one"], found["more"])
    assert not resolved("plane.off", found["one"], found["elsewhere"])


def test_one_bright_tile_does_not_hide_that_everything_is_five_times_as_wrong():
    """Of a difference nearly all is that tile's; of a ratio it has the same as all others."""
    random = np.random.default_rng(10)
    scale = np.r_[1000.0, random.uniform(0.5, 1.5, 399)]
    found = []
    for wrong in (1.0, 5.0):
        ratios = Ratios()
        ratios.add(64, np.ones(400), {"part": wrong * scale * random.normal(1, 0.1, 400)})
        measured = Measurement()
        measured.put("plane.off", ratios.value("part"), "", replicates=ratios.replicates("part"))
        found.append(vars(measured))
    assert jackknife(np.subtract(*(each["replicates"]["plane.off"] for each in found))) > 1
    assert resolved("plane.off", *found)
    assert difference_error("plane.off", *found) == pytest.approx(difference_error("plane.off", *found[::-1]))


def test_scores_about_0_are_told_apart_by_their_difference():
    entries = [
        {"scores": {"scale.slope": value}, "replicates": {"scale.slope": [value + each for each in (-0.1, 0.0, 0.2)]}}
        for value in (-0.5, 0.5)
    ]
    assert difference_error("scale.slope", *entries) == pytest.approx(0, abs=1e-12)
    assert resolved("scale.slope", *entries)


def test_a_logarithmic_mean_lies_between(tolerance):
    assert logarithmic_mean(2.0, 2.0) == 2
    assert logarithmic_mean(1.0, np.e) == pytest.approx(np.e - 1, rel=tolerance("closed form"))
    assert logarithmic_mean(np.e, 1.0) == pytest.approx(np.e - 1, rel=tolerance("closed form"))


def test_replicates_leave_out_runs_of_tiles_and_do_not_depend_on_parts(tolerance):
    random = np.random.default_rng(9)
    weight, part = random.uniform(1, 2, 600), random.uniform(0, 1, 600)
    whole, cut = Ratios(), Ratios()
    whole.add(16, weight, {"part": part})
    for some in (slice(0, 5), slice(5, 321), slice(321, 600)):
        cut.add(16, weight[some], {"part": part[some]})
    block = np.arange(600) // RUN % BLOCKS
    expected = [part[block != k].sum() / weight[block != k].sum() for k in range(BLOCKS)]
    assert whole.replicates("part") == pytest.approx(expected, rel=tolerance("closed form"))
    assert cut.replicates("part") == pytest.approx(expected, rel=tolerance("closed form"))
    spread = np.sqrt(overlap(16)) * jackknife(expected) / whole.error("part")
    assert abs(np.log2(spread)) < tolerance("octave of a standard error")
    assert not Ratios().replicates("part")


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


@pytest.mark.checks("quantisation.floor")
def test_the_quantisation_floor_is_a_mean_over_frames_with_the_error_of_a_sample(tolerance):
    found = quantisation([1.0, 3.0, None], 8)
    assert found.scores == {"quantisation.floor": 2.0}
    error = np.sqrt(2 * (1 - 2 / 8) / 2)
    assert found.errors["quantisation.floor"] == pytest.approx(error, rel=tolerance("closed form"))
    assert quantisation([1.0, 3.0], 2).errors == {"quantisation.floor": 0}
    assert "32-bit" in quantisation([None], 8).absent["quantisation.floor"]
