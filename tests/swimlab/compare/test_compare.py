"""Runs side by side: changes, their significance in closed form, what differs, what is refused."""

import json
from math import erf, inf, isinf, sqrt

import pytest
from gate_files import entry, write_scores

from swimlab.compare.change import as_normal, change, change_in_history, expected_by_chance, in_errors
from swimlab.compare.pick import MAIN, Pick
from swimlab.compare.runs import compare_runs
from swimlab.runs.differences import Difference, differences
from swimlab.runs.entries import Entry, Settings
from swimlab.runs.record import Record, RunError

METRIC = "budget.flicker"


def measured(value=1.0, error=None, metric=METRIC, *, hash="a", domain="linear", extent="0-7", **more):
    """An entry with one score."""
    errors = {} if error is None else {metric: error}
    scores = {} if value is None else {metric: value}
    return Entry("road", "tsl", scores, {}, Settings(hash, domain, extent), errors=errors, **more)


def write(folder, *entries, errors=None, **options):
    """A folder with scores.json; errors: a standard error for every score of every entry."""
    made = [{**each, "errors": {} if errors is None else dict.fromkeys(each["scores"], errors)} for each in entries]
    return write_scores(folder, *made, **options)


def test_a_change_is_told_in_units_in_percent_and_in_standard_errors(tolerance):
    found = change(measured(2.0, 0.3), measured(5.0, 0.4), METRIC)
    assert found.absolute == 3.0
    assert found.relative == 1.5
    assert found.sigmas == pytest.approx(3 / 0.5, rel=tolerance("closed form"))
    assert found.verdict == "worse"


@pytest.mark.parametrize(
    ("metric", "after", "verdict"),
    [
        ("budget.flicker", 2.0, "worse"),
        ("budget.flicker", 0.5, "better"),
        ("plane.on", 2.0, "better"),
        ("plane.on", 0.5, "worse"),
        ("scale.slope", 2.0, "changed"),
        ("flip.mean", 2.0, "changed"),
    ],
)
def test_the_direction_is_the_metrics_own(metric, after, verdict):
    found = change(measured(1.0, 0.01, metric), measured(after, 0.01, metric), metric)
    assert found.verdict == verdict


def test_a_change_within_chance_is_unresolved_until_the_threshold_says_otherwise():
    before, after = measured(1.0, 0.3), measured(2.0, 0.4)
    assert change(before, after, METRIC).verdict == "unresolved"
    assert change(before, after, METRIC, threshold=1.9).verdict == "worse"


@pytest.mark.parametrize("errors", [(None, 0.1), (0.1, None), (None, None), (0.1, float("nan"))])
def test_without_both_standard_errors_the_significance_is_unknown(errors):
    found = change(measured(1.0, errors[0]), measured(2.0, errors[1]), METRIC)
    assert found.verdict == "unknown"
    assert found.sigmas is None
    assert "no standard error" in found.reason


def test_errors_of_nothing_make_any_change_certain_but_rounding():
    found = change(measured(1.0, 0.0), measured(1.01, 0.0), METRIC)
    assert (found.sigmas, found.verdict) == (inf, "worse")
    assert found.as_json()["sigmas"] is None
    assert change(measured(1.0, 0.0), measured(1.0 + 1e-12, 0.0), METRIC).verdict == "same"
    assert change(measured(0.0, 0.0), measured(0.0, 0.0), METRIC).verdict == "same"


def test_what_the_references_own_error_explains_is_unresolved():
    floor = {"budget.floor": 0.5}
    before, after = measured(1.0, 0.001), measured(1.4, 0.001)
    assert change(before, after, METRIC).verdict == "worse"
    after.scores.update(floor)
    found = change(before, after, METRIC)
    assert (found.verdict, found.reason) == ("unresolved", "within the reference's own error")


def test_scores_that_come_and_go_have_their_reason():
    gone = measured(None)
    gone.absent[METRIC] = "too few frames"
    assert (change(measured(), gone, METRIC).verdict, change(measured(), gone, METRIC).reason) == (
        "gone",
        "too few frames",
    )
    assert change(gone, measured(), METRIC).verdict == "new"
    assert change(measured(), measured(float("nan")), METRIC).reason == "is not a number"
    assert change(measured(0.0, 0.1), measured(1.0, 0.1), METRIC).relative is None


@pytest.mark.parametrize("threshold", [1.0, 2.0, 3.0])
def test_chance_is_the_normal_distributions_tails(threshold, tolerance):
    expected = 400 * (1 - erf(threshold / sqrt(2)))
    assert expected_by_chance(400, threshold) == pytest.approx(expected, rel=tolerance("closed form"))


def test_students_t_of_one_degree_is_cauchys(tolerance):
    """Its tail beyond 1 is a quarter on each side, as the normal one's is beyond 0.6744897501960817."""
    assert as_normal(1.0, 1) == pytest.approx(0.6744897501960817, rel=tolerance("closed form"))
    assert as_normal(-1.0, 1) == pytest.approx(-0.6744897501960817, rel=tolerance("closed form"))
    assert as_normal(3.0, 10**9) == pytest.approx(3.0, rel=tolerance("slope of a power"))
    assert as_normal(-inf, 2) == -inf
    assert isinf(in_errors(1.0, 0.0))


def test_three_earlier_runs_tell_what_chance_does(tolerance):
    """Values 1, 2, 3 have mean 2 and spread 1; t = (v - 2) / sqrt(1 + 1/3) of 2 degrees."""
    earlier = [measured(value, 1e-6) for value in (1.0, 2.0, 3.0)]
    found = change_in_history(earlier, measured(6.0, 1e-6), METRIC)
    assert found.by == "spread of 3 runs"
    assert found.sigmas == pytest.approx(as_normal(4 / sqrt(4 / 3), 2), rel=tolerance("closed form"))
    assert found.verdict == "unresolved"
    assert change_in_history(earlier, measured(200.0, 1e-6), METRIC).verdict == "worse"
    assert change_in_history(earlier[:2], measured(6.0, 1e-6), METRIC).by == "standard errors"


def test_runs_that_all_agree_make_any_change_certain():
    earlier = [measured(1.0, 0.5)] * 3
    assert change_in_history(earlier, measured(0.9, 0.5), METRIC).verdict == "better"
    assert change_in_history(earlier, measured(1.0, 0.5), METRIC).verdict == "same"


def test_a_change_against_its_distance_from_the_mean_is_unresolved():
    """Far below the mean of all, though above the last."""
    earlier = [measured(value, 0.1) for value in (100.0, 100.1, 99.9, 100.0, 100.0, 1.0)]
    found = change_in_history([*earlier[:5], measured(99.0, 0.1)], measured(99.01, 0.1), METRIC)
    assert found.sigmas < 0 < found.absolute
    assert found.verdict == "unresolved"


def record(folder, hash, **sequence):
    about = {"name": "road", "viewing": {"luminance": 1}, **sequence}
    folder.mkdir()
    Record(about, {"samples": 64}, hash, None, False, {}).write(folder)
    return folder


def test_settings_that_differ_are_named_and_concern_whom_they_concern(tmp_path):
    one = record(tmp_path / "one", "a", size=[640, 360], techniques={"tsl": {"size": 1024}})
    other = record(tmp_path / "other", "b", size=[640, 360], techniques={"tsl": {"size": 512}})
    (found,) = differences(measured(folder=one), measured(hash="b", folder=other))
    assert str(found) == "techniques.tsl.size 1024 → 512"
    assert found.concerns("tsl")
    assert not found.concerns("pixel-aniso")
    assert Difference("techniques.reference.filter", "box", "mitchell").concerns("pixel-aniso")
    assert Difference("size", [1, 2], [3, 4]).concerns("pixel-aniso")


def test_only_sizes_are_written_with_an_x():
    assert str(Difference("size", [640, 360], [320, 180])) == "size 640x360 → 320x180"
    motion = Difference("motion", ["motion.X", "motion.Y"], None)
    assert str(motion) == "motion motion.X, motion.Y → none"


def test_a_hash_that_nothing_explains_stands_for_itself():
    assert [str(each) for each in differences(measured(), measured(hash="b"))] == ["settings hash a → b"]
    assert [each.key for each in differences(measured(hash=None), measured(hash=None))] == ["settings hash"]
    assert differences(measured(), measured()) == []


def test_domain_frames_and_versions_are_told_apart():
    before = measured(provenance={"swimlab": "1", "warp": "2"})
    after = measured(domain="display", extent="0-3", provenance={"swimlab": "2", "warp": "2"})
    found = {each.key: each for each in differences(before, after)}
    assert list(found) == ["domain", "frames measured", "swimlab"]
    assert found["domain"].concerns("tsl")
    assert not found["swimlab"].concerns("tsl")


def test_the_command_shows_runs_side_by_side(swimlab, tmp_path):
    for name, value in (("a", 1.0), ("b", 2.0), ("c", 1.0)):
        write(tmp_path / name, entry(budget_flicker=value, budget_mse=5.0), errors=0.1)
    code, out, _ = swimlab("compare", "a", "b", "c")
    assert code == 0
    (row,) = [line.split() for line in out.splitlines() if line.strip().startswith("tsl")]
    assert " ".join(row[1:]) == "budget.flicker radiance^2 1 2 +1 +100.0 +7.1 worse 1 +0 +0.0 +0.0 same"
    assert "#1: 2 scores: 1 worse, 1 same. Beyond 3 σ: 1 of 2; chance alone would bring 0.0054." in out


def test_the_command_prints_json(swimlab, tmp_path):
    write(tmp_path / "a", entry(budget_flicker=1.0), entry(technique="lean", budget_flicker=1.0), errors=0.0)
    write(tmp_path / "b", entry(budget_flicker=2.0), entry("road-hills", budget_flicker=1.0), errors=0.0)
    code, out, _ = swimlab("compare", "a", "b", "--json")
    assert code == 0
    (run,) = json.loads(out)["runs"]
    assert (run["beyond"], run["compared"]) == (1, 1)
    assert [(each["technique"], each["sequence"], each["in"]) for each in run["only"]] == [
        ("lean", "road-shift", "base"),
        ("tsl", "road-hills", "run"),
    ]
    (found,) = run["changes"]
    assert (found["before"], found["after"], found["change"], found["share"]) == (1.0, 2.0, 1.0, 1.0)
    assert (found["sigmas"], found["verdict"], found["better"], found["unit"]) == (None, "worse", "lower", "radiance^2")


def test_runs_of_other_settings_are_compared_and_marked(swimlab, tmp_path):
    write(tmp_path / "a", entry(budget_flicker=1.0), errors=0.01)
    write(tmp_path / "b", entry(budget_flicker=2.0), errors=0.01, digest="feedfeedfeedfeed", domain="display")
    code, out, _ = swimlab("compare", "a", "b")
    assert code == 0
    assert "worse*" in out
    assert "OTHER SETTINGS: domain linear → display; settings hash 0123456789abcdef → feedfeedfeedfeed" in out


def test_one_clip_each_is_compared_whatever_the_files_are_called(swimlab, tmp_path):
    write(tmp_path / "a", entry("shot_v1", "test", budget_flicker=1.0), errors=0.01)
    write(tmp_path / "b", entry("shot_v2", "test", budget_flicker=2.0), errors=0.01)
    code, out, _ = swimlab("compare", "a", "b")
    assert code == 0
    assert " worse " in out
    assert "other names: sequence shot_v1 → shot_v2" in out


def test_one_sequence_each_is_paired_by_technique_whatever_it_is_called(swimlab, tmp_path):
    """As two run folders of a sweep are: the varied setting is named and marks whom it concerns."""
    for name, digest, size, flicker in (("a", "1" * 16, 1024, 1.0), ("b", "2" * 16, 128, 2.0)):
        record(tmp_path / name, digest, name=f"road_{size}", techniques={"tsl": {"size": size}})
        found = entry(f"road_{size}", budget_flicker=flicker)
        write(tmp_path / name, found, entry(f"road_{size}", "lean", budget_flicker=flicker), errors=0.01, digest=digest)
    code, out, _ = swimlab("compare", "a", "b")
    assert code == 0
    verdicts = [line.split()[-1] for line in out.splitlines() if line.startswith(("  tsl", "  lean"))]
    assert verdicts == ["worse*", "worse"]
    assert "#1: road_1024: OTHER SETTINGS: techniques.tsl.size 1024 → 128\n" in out
    assert "#1: road_1024: other names: sequence road_1024 → road_128\n" in out


def test_another_name_alone_explains_another_hash(tmp_path):
    one, other = (record(tmp_path / name, name, name=name) for name in ("a", "b"))
    assert differences(measured(folder=one), measured(hash="b", folder=other)) == []


def test_patterns_choose_techniques_and_scores(tmp_path):
    for name in ("a", "b"):
        entries = [entry(technique=t, budget_flicker=1.0, plane_off=1.0) for t in ("tsl", "pixel-point", "pixel-aniso")]
        write(tmp_path / name, *entries)
    runs = [tmp_path / "a", tmp_path / "b"]
    for pick, count in [(Pick(), 3), (Pick.of("pixel-*", None), 2), (Pick.of("tsl", "*"), 2), (Pick.of(None, "*"), 6)]:
        (found,) = compare_runs(runs, pick=pick, provenance={}).runs
        assert len(found.changes) == count
    assert Pick.of(None, None).metrics == MAIN


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["a"], "name two runs or more"),
        (["a", "nowhere"], "nowhere/scores.json: is missing"),
        (["a", "other"], "other: has no technique on a sequence in common with the base"),
        (["a", "a", "-t", "tls"], "-t tls: matches no technique; there are tsl"),
        (["a", "a", "--metric", "flick*"], "--metric flick*: matches no score; there are budget.flicker"),
        (["a", "a", "--metric", ","], "give names or patterns"),
        (["a", "a", "--sigma", "0"], "--sigma 0: must be above 0"),
        (["a", "--save"], "--save: adds to a folder"),
    ],
)
def test_what_cannot_be_compared_is_refused(swimlab, tmp_path, words, said):
    write(tmp_path / "a", entry(budget_flicker=1.0))
    hills = [entry("road-hills", technique, budget_flicker=1.0) for technique in ("vmf", "lean")]
    write(tmp_path / "other", *hills)
    code, out, err = swimlab("compare", *words)
    assert (code, out) == (2, "")
    assert said in err


def test_an_empty_pattern_list_is_a_run_error():
    with pytest.raises(RunError, match="-t"):
        Pick.of("", None)
