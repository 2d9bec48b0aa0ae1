"""What passes a gate and what does not, on scores made for it."""

import json
from fnmatch import fnmatchcase

import pytest
from gate_files import entry, write_gate, write_scores
from hypothesis import given
from hypothesis import strategies as st

from swimlab.gate.judge import governed, judge
from swimlab.gate.outcome import Outcome, run_gate, update_baseline
from swimlab.gate.rules import Gate, GateError, load_gate
from swimlab.runs.entries import Entry, Settings, read_all

BASELINE = 'file = "baseline.json"'
INFINITE = float("inf")


@pytest.fixture
def outcome(tmp_path):
    """Run a gate of some rules over a run of some entries; with `before`, against a baseline of those runs."""

    def outcome(rules, *entries, before=(), missing="error", **settings) -> Outcome:
        baseline = f'{BASELINE}\nmissing = "{missing}"' if before else ""
        gate = write_gate(tmp_path / "gate.toml", *rules, baseline=baseline)
        runs = [write_scores(tmp_path / f"before{number}", *each) for number, each in enumerate(before)]
        if runs:
            update_baseline(gate, runs, count=None, provenance={})
        return run_gate(gate, [write_scores(tmp_path / "run", *entries, **settings)], provenance={})

    return outcome


def statuses(outcome: Outcome) -> list[str]:
    return [check.status for check in outcome.checks]


@pytest.mark.parametrize(
    ("value", "status", "code"), [(0.0, "pass", 0), (0.0012, "pass", 0), (0.00120001, "fail", 1), (1e300, "fail", 1)]
)
def test_a_ceiling_holds_up_to_itself(outcome, value, status, code):
    found = outcome(['metric = "budget.flicker"\nmax = 0.0012'], entry(budget_flicker=value))
    assert (statuses(found), found.exit_code) == ([status], code)


@pytest.mark.parametrize(("value", "status"), [(0.91, "pass"), (0.9, "pass"), (0.89, "fail")])
def test_a_floor_holds_down_to_itself(outcome, value, status):
    assert statuses(outcome(['metric = "plane.on"\nmin = 0.9'], entry(plane_on=value))) == [status]


@pytest.mark.parametrize(("metric", "wrong", "right"), [("plane.on", "max", "min"), ("budget.mse", "min", "max")])
def test_a_limit_on_the_better_side_alone_is_none(outcome, metric, wrong, right):
    found = outcome([f'metric = "{metric}"\n{wrong} = 0.5'], entry(plane_on=0.5, budget_mse=0.5))
    assert statuses(found) == ["unjudged"]
    assert f"the rule has to give {right}" in found.checks[0].reason


@pytest.mark.parametrize(
    ("increase", "limit"),
    [
        ('"5%"', 2.1),
        ("0.3", 2.3),
        ("0", 2.0),
        ('["5%", 0.3]', 2.3),
        ('["20%", 0.3]', 2.4),
        ('[0.3, "20%"]', 2.4),
    ],
)
def test_an_increase_is_the_larger_of_share_and_amount(outcome, increase, limit, tolerance):
    rules = [f'metric = "budget.mse"\nmax_increase = {increase}']
    inside, outside = limit * (1 - tolerance("closed form")), limit * (1 + tolerance("closed form"))
    before = [[entry(budget_mse=2.0)]]
    assert statuses(outcome(rules, entry(budget_mse=inside), before=before)) == ["pass"]
    assert statuses(outcome(rules, entry(budget_mse=outside), before=before)) == ["fail"]


@pytest.mark.parametrize(("value", "status"), [(2.0, "pass"), (0.97, "pass"), (0.95, "pass"), (0.94, "fail")])
def test_where_higher_is_better_the_inequality_turns(outcome, value, status):
    rules = ['metric = "plane.on"\nmax_increase = "5%"']
    assert statuses(outcome(rules, entry(plane_on=value), before=[[entry(plane_on=1.0)]])) == [status]


@pytest.mark.parametrize(("value", "status"), [(1.06, "fail"), (1.04, "pass"), (0.96, "pass"), (0.94, "fail")])
def test_where_neither_is_better_it_binds_both_ways(outcome, value, status):
    rules = ['metric = "scale.highlight"\nmax_increase = "5%"']
    assert statuses(outcome(rules, entry(scale_highlight=value), before=[[entry(scale_highlight=1.0)]])) == [status]


def test_a_negative_baseline_has_a_positive_allowance(outcome):
    rules = ['metric = "scale.slope"\nmax_increase = "10%"']
    before = [[entry(scale_slope=-2.0)]]
    assert statuses(outcome(rules, entry(scale_slope=-1.9), before=before)) == ["pass"]
    assert statuses(outcome(rules, entry(scale_slope=-1.7), before=before)) == ["fail"]


def test_noise_is_granted_by_the_spread_of_the_baseline(outcome, tolerance):
    """Runs of 1, 2 and 3: mean 2, sigma 1. With 10% and 3 sigma the ceiling is 2 + .2 + 3."""
    rules = ['metric = "budget.mse"\nmax_increase = "10%"\nnoise_sigma = 3']
    before = [[entry(budget_mse=value)] for value in (1.0, 2.0, 3.0)]
    found = outcome(rules, entry(budget_mse=5.19), before=before)
    assert statuses(found) == ["pass"]
    assert found.checks[0].base == pytest.approx(2.0, rel=tolerance("closed form"))
    assert found.checks[0].sigma == pytest.approx(1.0, rel=tolerance("closed form"))
    assert statuses(outcome(rules, entry(budget_mse=5.21), before=before)) == ["fail"]


def test_the_spread_of_one_run_is_unknown_and_not_zero(outcome):
    rules = ['metric = "budget.mse"\nmax_increase = "10%"\nnoise_sigma = 3']
    found = outcome(rules, entry(budget_mse=2.19), before=[[entry(budget_mse=2.0)]])
    assert statuses(found) == ["pass"]
    assert found.checks[0].sigma is None
    assert "sigma unknown" in found.checks[0].reason
    assert statuses(outcome(rules, entry(budget_mse=2.21), before=[[entry(budget_mse=2.0)]])) == ["fail"]


def test_ceiling_and_increase_bind_both(outcome):
    rules = ['metric = "budget.mse"\nmax = 2.05\nmax_increase = "10%"']
    before = [[entry(budget_mse=2.0)]]
    assert statuses(outcome(rules, entry(budget_mse=2.1), before=before)) == ["fail"]
    assert statuses(outcome(rules, entry(budget_mse=2.04), before=before)) == ["pass"]


def test_warnings_do_not_fail(outcome):
    found = outcome(['metric = "budget.mse"\nlevel = "warn"\nmax = 1'], entry(budget_mse=2.0))
    assert (statuses(found), found.exit_code) == (["warn"], 0)


def test_the_last_match_wins(outcome):
    rules = [
        'metric = "budget.*"\nmax = 1',
        'technique = "lod-*"\nmetric = "budget.mse"\nlevel = "warn"\nmax = 1',
        'sequence = "road-drive"\nmetric = "budget.mse"\nmax = 5',
        'technique = "pixel-point"\nmetric = "*"\nlevel = "off"',
    ]
    techniques = ("tsl", "lod-hack", "pixel-point")
    entries = [entry(s, t, budget_mse=2.0) for s in ("road-shift", "road-drive") for t in techniques]
    found = outcome(rules, *entries)
    assert {(check.sequence, check.technique): (check.status, check.rule) for check in found.checks} == {
        ("road-shift", "tsl"): ("fail", 1),
        ("road-shift", "lod-hack"): ("warn", 2),
        ("road-drive", "tsl"): ("pass", 3),
        ("road-drive", "lod-hack"): ("pass", 3),
    }


MISSING = {
    "a score that is null": (entry(budget_mse=None), "is not a number"),
    "a score that is NaN": (entry(budget_mse=float("nan")), "is not a number"),
    "a score that is infinite": (entry(budget_mse=INFINITE), "is not a number"),
    "a score that is text": (entry(budget_mse="0.1"), "is not a number"),
    "a score that is true": (entry(budget_mse=True), "is not a number"),
    "a score that is absent": ({**entry(), "absent": {"budget.mse": "needs a reference"}}, "needs a reference"),
    "a score that is not there": (entry(budget_mes=1.0), "has not been measured"),
    "a technique that is not there": (entry(technique="tls", budget_mse=0.0), "was not measured"),
    "a sequence that is not there": (entry(sequence="rood", budget_mse=0.0), "was not measured"),
}


@pytest.mark.parametrize("level", ["warn", "error"])
@pytest.mark.parametrize("what", MISSING)
def test_nothing_missing_passes(outcome, what, level):
    """Not even where the rule only warns: that softens a limit, not a broken gate."""
    given, message = MISSING[what]
    rule = f'sequence = "road-*"\ntechnique = "tsl"\nmetric = "budget.mse"\nlevel = "{level}"\nmax = 1'
    found = outcome([rule], given)
    assert (statuses(found), found.exit_code) == (["unjudged"], 2)
    assert message in found.checks[0].reason


def test_each_sequence_needs_the_technique(outcome):
    rule = 'sequence = "road-*"\ntechnique = "tsl"\nmetric = "budget.mse"\nmax = 1'
    found = outcome([rule], entry(budget_mse=0.5), entry("road-drive", "lod-hack", budget_mse=0.5))
    assert [(check.sequence, check.status) for check in found.checks] == [
        ("road-drive", "unjudged"),
        ("road-shift", "pass"),
    ]


def test_a_pattern_that_matches_no_score_is_not_judged(outcome):
    found = outcome(['metric = "plane.*"\nmax = 1'], entry(budget_mse=0.5))
    assert (statuses(found), found.checks[0].metric) == (["unjudged"], "plane.*")


def test_what_cannot_be_had_is_switched_off_by_a_rule(outcome):
    rules = ['metric = "budget.mse"\nmax = 1', 'sequence = "road-scale"\nmetric = "budget.*"\nlevel = "off"']
    found = outcome(rules, entry(budget_mse=0.5), entry("road-scale", scale_rmse=0.1))
    assert (statuses(found), found.exit_code) == (["pass"], 0)


@pytest.mark.parametrize(
    ("metric", "guess"), [("budget.flickr", "did you mean 'budget.flicker' or "), ("x", "`swimlab list metrics`")]
)
def test_a_mistyped_score_gets_close_guesses_alone(outcome, metric, guess):
    (check,) = outcome([f'metric = "{metric}"\nmax = 1'], entry(budget_flicker=0.5)).checks
    assert guess in check.reason
    assert len(check.reason) < 200
    assert not check.absent


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"digest": "f" * 16}, "settings hash ffffffffffffffff"),
        ({"digest": None}, "carry no settings hash"),
        ({"domain": "display"}, "domain display"),
    ],
)
@pytest.mark.parametrize("rule", ['max_increase = "5%"', "max = 10"])
@pytest.mark.parametrize("missing", ["error", "warn"])
def test_other_settings_never_pass(outcome, change, message, rule, missing):
    rules = [f'metric = "budget.mse"\n{rule}']
    found = outcome(rules, entry(budget_mse=1.0), before=[[entry(budget_mse=1.0)]], missing=missing, **change)
    assert (statuses(found), found.exit_code) == (["unjudged"], 2)
    assert message in found.checks[0].reason


def test_other_frames_never_pass(outcome):
    fewer = entry(frames=[{"frame": 0, "mse": 1.0}], budget_mse=1.0)
    found = outcome(['metric = "budget.mse"\nmax_increase = "5%"'], fewer, before=[[entry(budget_mse=1.0)]])
    assert statuses(found) == ["unjudged"]
    assert "frames 0 instead of 0-1" in found.checks[0].reason


@pytest.mark.parametrize(("missing", "status", "code"), [("error", "unjudged", 2), ("warn", "warn", 0)])
def test_what_the_baseline_lacks_passes_only_where_the_gate_says_so(outcome, missing, status, code):
    rules = ['metric = "budget.mse"\nmax_increase = "5%"']
    entries = [entry(budget_mse=1.0), entry("road-new", budget_mse=1.0)]
    found = outcome(rules, *entries, before=[[entry(budget_mse=1.0)]], missing=missing)
    assert ([check.status for check in found.checks], found.exit_code) == ([status, "pass"], code)
    assert "not in the baseline" in found.checks[0].reason


@pytest.mark.parametrize("missing", ["error", "warn"])
def test_what_only_the_baseline_has_never_passes(outcome, missing):
    rules = ['metric = "budget.*"\nmax_increase = "5%"']
    before = [[entry(budget_mse=1.0, budget_bias=1.0), entry("road-old", budget_mse=1.0)]]
    found = outcome(rules, entry(budget_mse=1.0), before=before, missing=missing)
    assert [check.name for check in found.checks if check.status == "unjudged"] == [
        "road-old/tsl budget.mse",
        "road-shift/tsl budget.bias",
    ]
    assert found.exit_code == 2


def test_a_new_sequence_still_has_its_ceiling(outcome):
    rules = ['metric = "budget.mse"\nmax = 1\nmax_increase = "5%"']
    entries = [entry(budget_mse=0.5), entry("road-new", budget_mse=1.5)]
    found = outcome(rules, *entries, before=[[entry(budget_mse=0.5)]], missing="warn")
    assert statuses(found) == ["fail", "pass"]


def test_a_failure_outweighs_what_could_not_be_judged(outcome):
    assert outcome(['metric = "budget.*"\nmax = 1'], entry(budget_mse=2.0, budget_bias=None)).exit_code == 1


def test_a_gate_with_every_rule_off_is_none(outcome):
    with pytest.raises(GateError, match="every rule is off"):
        outcome(['metric = "budget.mse"\nlevel = "off"'], entry(budget_mse=2.0))


def test_a_study_has_a_hash_for_each_sequence(tmp_path):
    entries = [entry("a", "tsl"), entry("a", "lod-hack"), entry("b", "tsl")]
    found = read_all([write_scores(tmp_path, *entries, digest="11, 22")])
    assert [(each.sequence, each.settings.hash) for each in found] == [("a", "11"), ("a", "11"), ("b", "22")]
    assert [each.key for each in read_all([tmp_path / "scores.json"])] == [each.key for each in found]


NAMES = st.sampled_from(["road-shift", "road-drive", "tsl", "lod-hack", "budget.mse", "budget.bias", "plane.on"])
PATTERNS = st.one_of(NAMES, st.sampled_from(["*", "road-*", "budget.*", "*.on", "t?l"]))
RULES = st.builds(
    dict,
    sequence=PATTERNS,
    technique=PATTERNS,
    metric=PATTERNS,
    level=st.sampled_from(["off", "warn", "error"]),
    max=st.just(1.0),
)


def matches(rule, measured):
    """What a rule speaks of; at each level, the pattern itself where nothing matches."""

    def matching(pattern, names):
        return [name for name in names if fnmatchcase(name, pattern)] or [pattern]

    for s in matching(rule["sequence"], {s for s, _ in measured}):
        for t in matching(rule["technique"], {t for one, t in measured if one == s}):
            yield from ((s, t, name) for name in matching(rule["metric"], measured.get((s, t), [])))


@given(
    st.lists(RULES, min_size=1, max_size=5),
    st.dictionaries(st.tuples(NAMES, NAMES), st.lists(NAMES, min_size=1), max_size=4),
)
def test_every_rule_that_is_on_is_heard(rules, measured):
    """Each score that a rule matches is governed by the last match, and no rule is passed over in silence."""
    gate = Gate.model_validate({"version": 1, "rule": rules})
    settings = Settings("0", "linear", "0-1")
    entries = [Entry(s, t, dict.fromkeys(names, 0.5), {}, settings) for (s, t), names in measured.items()]
    cells = dict(governed(gate, entries, None))
    for (sequence, technique), names in measured.items():
        for name in names:
            found = [
                number
                for number, rule in enumerate(rules)
                if all(
                    map(fnmatchcase, (sequence, technique, name), (rule["sequence"], rule["technique"], rule["metric"]))
                )
            ]
            expected = found[-1] if found and rules[found[-1]]["level"] != "off" else None
            assert cells.get((sequence, technique, name)) == expected
    for number, rule in enumerate(rules):
        if rule["level"] != "off" and number not in cells.values():
            # Overruled wherever it matches, or where nothing does, for its very pattern.
            assert all(gate.governing(*cell) != number for cell in matches(rule, measured))
    known = {(s, t, name) for (s, t), names in measured.items() for name in names}
    for check in judge(gate, entries, None):
        assert (check.status == "unjudged") >= ((check.sequence, check.technique, check.metric) not in known)


def test_the_example_of_the_format_reads(tmp_path):
    (tmp_path / "gate.toml").write_text(
        """
version = 1
[baseline]
file = "baselines/main.json"   # values, spread, settings hash
missing = "error"
[[rule]]
sequence = "road-*"            # last match wins
technique = "tsl"
metric = "budget.flicker"
level = "error"                # off | warn | error
max = 0.0012                   # absolute ceiling
max_increase = "5%"            # against the baseline, or absolute
noise_sigma = 3
""",
        encoding="utf-8",
    )
    gate = load_gate(tmp_path / "gate.toml")
    assert gate.baseline_path == tmp_path / "baselines" / "main.json"
    assert gate.rule[0].max_increase == (0.05, 0.0)


def test_the_outcome_is_json(outcome):
    found = outcome(['metric = "budget.*"\nmax = 1'], entry(budget_mse=2.0, budget_bias=None))
    text = json.dumps(found.as_json(), allow_nan=False)
    checks = {check["metric"]: check for check in json.loads(text)["checks"]}
    assert checks["budget.mse"]["evidence"] == {"frame": 1, "region": None, "crop": None}
    assert checks["budget.bias"]["value"] is None
