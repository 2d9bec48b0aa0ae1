"""The verdict on made-up scores: what it picks, what it warns of, and what it does not claim."""

from typing import Any

import pytest

from swimlab.report.verdict import BEST, FASTEST, NEAREST, Verdict, verdict

TIMES = {"pixel-point": 2.0, "pixel-aniso": 4.0, "vmf": 4.5, "tsl": 100.0, "vertex": 20.0}
ERRORS = {"pixel-point": 0.4, "pixel-aniso": 0.3, "vmf": 0.12, "tsl": 0.05, "vertex": 0.6}
FLICKER = {"pixel-point": 0.39, "pixel-aniso": 0.2, "vmf": 0.08, "tsl": 0.03, "vertex": 0.02}


def entry(
    name: str, rms: float, flicker: float, *, sequence: str = "road-shift", error: float = 1e-5
) -> dict[str, Any]:
    scores = {"budget.mse": rms**2, "budget.flicker": flicker**2, "budget.floor": 1e-6, "visible.flicker": 50 * flicker}
    return {"sequence": sequence, "technique": name, "scores": scores, "errors": {"budget.mse": error}, "absent": {}}


def entries(sequence: str = "road-shift", **changed: float) -> list[dict[str, Any]]:
    errors = ERRORS | {name.replace("_", "-"): value for name, value in changed.items()}
    return [entry(name, rms, min(rms, FLICKER[name]), sequence=sequence) for name, rms in errors.items()]


def picked(told: Verdict) -> dict[str, str]:
    return {pick.title: pick.name for pick in told.picks}


def test_it_picks_the_nearest_the_fastest_and_the_least_product() -> None:
    told = verdict(entries(), {"road-shift": TIMES})
    assert picked(told) == {BEST: "vmf", NEAREST: "tsl", FASTEST: "pixel-point"}
    assert told.picks[0].title == BEST
    assert told.lead.startswith("vmf is the best for its time: rms error 0.12 in 4.5 ms a frame")
    assert "4.5 ms a frame, 60% less error than pixel-aniso in 1.12 times its time." in told.lead
    assert told.lead.endswith("tsl has 83% less error than pixel-aniso in 25 times its time.")
    assert dict(told.picks[0].facts) == {
        "rms error": "0.12",
        "rms flicker": "0.08",
        "visible flicker": "4",
        "ms a frame": "4.5",
        "× pixel-aniso's time": "1.12",
    }
    assert "least product" in told.rule


def test_what_looks_calm_but_is_wrong_is_named() -> None:
    told = verdict(entries(), {"road-shift": TIMES})
    assert told.warnings == [
        "vertex looks calm but is wrong: visible flicker 1 (vmf 4), but 0.6 rms error, 5 times as much."
    ]
    assert verdict(entries(vertex=0.15), {"road-shift": TIMES}).warnings == []


def test_what_sparkles_is_said_to() -> None:
    fastest = verdict(entries(), {"road-shift": TIMES}).picks[2]
    assert fastest.notes == ["It sparkles: most of its error is flicker."]


@pytest.mark.parametrize(("flicker", "floor", "said"), [(0.04, 1e-6, True), (0.034, 1e-6, False), (0.04, 2e-3, False)])
def test_the_nearest_sparkles_where_most_of_its_own_error_flickers(flicker: float, floor: float, said: bool) -> None:
    """Half the energy of an error of .05 is .0354; what the reference itself errs by is no fault of a technique."""
    two = [entry("near", 0.05, flicker), entry("far", 0.3, 0.1)]
    for each in two:
        each["scores"]["budget.floor"] = floor
    for times in ({}, {"road-shift": {"near": 9.0, "far": 1.0}}):
        notes = {pick.title: pick.notes for pick in verdict(two, times).picks}[NEAREST]
        assert ("It sparkles: most of its error is flicker." in notes) is said


def test_what_sparkles_is_not_the_best_for_its_time_while_something_else_is_there() -> None:
    """Of these two pixel-point has the lesser product, .8 to 1.2."""
    two = [item for item in entries() if item["technique"] in ("pixel-point", "pixel-aniso", "tsl")]
    assert picked(verdict(two, {"road-shift": TIMES}))[BEST] == "pixel-aniso"
    noise = [entry("a", 0.05, 0.05), entry("b", 0.3, 0.29)]
    assert picked(verdict(noise, {"road-shift": {"a": 9.0, "b": 1.0}}))[BEST] == "a"


def test_the_reference_is_never_weighed() -> None:
    reference = entry("reference", 0.0, 0.0)
    assert verdict([*entries(), reference], {"road-shift": {**TIMES, "reference": 0.1}}) == verdict(
        entries(), {"road-shift": TIMES}
    )


@pytest.mark.parametrize(("error", "resolved"), [(1e-6, True), (1e-2, False)])
def test_what_is_not_resolved_is_said_so(error: float, resolved: bool) -> None:
    """Two techniques .5 % apart; only with small standard errors is one of them nearer."""
    two = [entry("lean", 0.1, 0.05, error=error), entry("vmf", 0.1005, 0.05, error=error)]
    told = verdict(two, {"road-shift": {"lean": 5.0, "vmf": 4.0}})
    assert picked(told) == {BEST: "vmf", NEAREST: "lean", FASTEST: "vmf"}
    notes = " ".join(note for pick in told.picks for note in pick.notes)
    assert ("not resolved from that of lean, which took longer" in notes) != resolved
    assert ("not resolved from that of vmf, in less time: the cheaper choice" in notes) != resolved
    assert ("lean has 0.5% less error than vmf in 1.25 times its time" in told.lead) == resolved
    assert ("lean measured slightly nearer on this clip; other content may differ" in told.lead) != resolved


def test_no_lead_contradicts_a_card() -> None:
    """Without standard errors nothing is resolved, yet a card shows an error 1.9 times smaller."""
    two = [entry("tsl", 0.05, 0.03) | {"errors": {}}, entry("vmf", 0.095, 0.03) | {"errors": {}}]
    told = verdict(two, {"road-shift": {"vmf": 4.5, "tsl": 100.0}})
    assert picked(told)[BEST] == "vmf"
    assert told.lead.endswith("tsl measured 1.9 times nearer on this clip; other content may differ.")
    assert verdict(entries(vmf=0.01), {"road-shift": TIMES}).lead.endswith(
        "Nothing here measured closer to the reference."
    )


def test_what_is_as_good_and_as_fast_may_be_taken_as_well() -> None:
    three = [entry(name, rms, 0.05, error=1e-2) for name, rms in (("lean", 0.1), ("vmf", 0.101), ("toksvig", 0.102))]
    times = {"lean": 5.1, "vmf": 5.0, "toksvig": 5.2}
    notes = verdict(three, {"road-shift": times}).picks[0].notes
    assert notes == [
        "lean and toksvig are as good, and as fast within what times may be off by (10%): any of them will do."
    ]
    two = verdict(three[:2], {"road-shift": times})
    assert "either will do" in two.picks[0].notes[0]


def test_other_settings_under_one_name_are_not_pooled_silently() -> None:
    both = [*entries(sequence="a"), *entries(sequence="b")]
    times = dict.fromkeys("ab", TIMES)
    same, other = {"tsl": {"size": 256, "texels": "all"}}, {"tsl": {"size": 512, "texels": "all"}}
    assert verdict(both, times, {"a": same, "b": same}).warnings == verdict(both, times).warnings
    first = verdict(both, times, {"a": same, "b": other}).warnings[0]
    assert first.startswith("tsl has not the same settings")
    assert "(size 256 on a, 512 on b)" in first
    assert "texels" not in first


def test_errors_are_told_apart_by_their_means_over_sequences() -> None:
    """On b alone the difference is within two standard errors; over both it is nearly four wide."""
    told = verdict(
        [
            *(entry(name, rms, 0.05, sequence="a", error=1e-5) for name, rms in (("lean", 0.1), ("vmf", 0.12))),
            *(entry(name, rms, 0.05, sequence="b", error=1e-3) for name, rms in (("lean", 0.1), ("vmf", 0.105))),
        ],
        {sequence: {"lean": 5.0, "vmf": 4.5} for sequence in "ab"},
    )
    assert "not resolved" not in str(told.picks)


def test_what_times_of_one_run_cannot_tell_apart_is_named() -> None:
    times = {"road-shift": TIMES | {"tsl": 11.0}}
    (note,) = verdict(entries(), times).picks[0].notes
    assert note == "Within 10% by the same rule, no more than times of one run may be off by: tsl."
    assert verdict(entries(), {"road-shift": TIMES}).picks[0].notes == []


def test_equal_techniques_do_not_beat_each_other() -> None:
    told = verdict([entry("a", 0.1, 0.1), entry("b", 0.1, 0.1)], {"road-shift": {"a": 1.0, "b": 1.0}})
    assert picked(told) == {BEST: "a", NEAREST: "a", FASTEST: "a"}
    assert "b is as good, and as fast" in " ".join(told.picks[0].notes)


def test_sequences_that_disagree_are_told() -> None:
    other = entries("road-drive", vmf=0.29)
    times = {"road-shift": TIMES, "road-drive": TIMES}
    told = verdict([*entries(), *entries("road-drive")], times)
    assert "Means over road-shift and road-drive; each by itself picks the same." in told.notes
    assert verdict([*entries(), *other], times).notes[1] == (
        "On road-drive by itself pixel-aniso is best for its time."
    )
    assert "Said of road-shift alone" in verdict(entries(), {"road-shift": TIMES}).notes[0]


def test_resized_pictures_are_told_apart_from_moving_ones() -> None:
    scale = [
        {"sequence": "road-scale", "technique": name, "scores": {"scale.rmse": value}}
        for name, value in {"tsl": 0.13, "vmf": 0.2, "pixel-aniso": 0.1, "reference": 0.0}.items()
    ]
    told = verdict([*entries(), *scale], {"road-shift": TIMES, "road-scale": TIMES})
    assert told.notes[-1] == (
        "Independence of size on road-scale, by scale error: vmf is 3 of 3 (0.2) and tsl is 2 of 3 (0.13), "
        "pixel-aniso the least (0.1)."
    )
    assert verdict(scale, {}).lead.startswith("pixel-aniso depends least on the picture's size: scale error 0.1.")


def test_without_times_there_is_no_cost() -> None:
    told = verdict(entries(), {})
    assert picked(told) == {NEAREST: "tsl"}
    assert "What it costs cannot be said" in told.lead
    assert told.rule == ""
    some = verdict(entries(), {"road-shift": {"tsl": 100.0, "vmf": 4.5}})
    assert "No time is known for pixel-point, pixel-aniso and vertex." in some.notes


def test_one_technique_leaves_no_choice() -> None:
    told = verdict([entry("tsl", 0.05, 0.03)], {"road-shift": TIMES})
    assert told.picks == []
    assert told.lead.startswith("Only tsl was measured")
    assert "rms error 0.05" in told.lead


def test_without_a_reference_nobody_knows_what_is_true() -> None:
    own = [
        {"sequence": "mine", "technique": name, "scores": {"residual.flicker": value}}
        for name, value in {"a": 0.04, "b": 0.01}.items()
    ]
    told = verdict(own, {})
    assert told.lead.startswith("b changes least on the surface: rms 0.1.")
    assert "calm may be wrong" in told.lead
    assert "No error is known" in verdict([], {}).lead


def test_a_technique_of_one_sequence_only_is_left_out() -> None:
    told = verdict([*entries(), entry("vmf", 0.1, 0.1, sequence="b"), entry("tsl", 0.05, 0.01, sequence="b")], {})
    assert picked(told) == {NEAREST: "tsl"}
    assert any("Left out" in note and "vertex" in note and "vmf" not in note for note in told.notes)
    apart = verdict([entry("a", 0.1, 0.1), entry("b", 0.1, 0.1, sequence="other")], {})
    assert "nothing to weigh" in apart.lead


def test_errors_of_zero_divide_nothing() -> None:
    told = verdict(
        [entry("a", 0.0, 0.0), entry("pixel-aniso", 0.0, 0.0)], {"road-shift": {"a": 1.0, "pixel-aniso": 2.0}}
    )
    assert "nan" not in str(told)
    assert "inf" not in str(told)
