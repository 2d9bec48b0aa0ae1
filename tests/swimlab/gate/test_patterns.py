"""Metrics with wildcards: what they leave out, what they never do, and the rules that switch off the rest."""

import tomllib

import pytest
from gate_files import entry, write_gate, write_scores

INCREASE = 'metric = "budget.*"\nmax_increase = "5%"'
NO_DEPTH = {"budget.bias.far": "needs depth", "budget.floor.far": "needs depth"}


@pytest.fixture
def rules(tmp_path):
    """Write a gate with a baseline and these rules."""
    return lambda *rules: write_gate(tmp_path / "gate.toml", *rules, baseline='file = "b.json"')


def lacking(absent, *names, **scores):
    return {**entry(*names, **scores), "absent": absent}


def tables(text):
    """The rules in what was printed."""
    lines = text.splitlines()
    found = [
        line
        for line in lines
        if line == "[[rule]]" or line.split(" = ")[0] in ("sequence", "technique", "metric", "level")
    ]
    return tomllib.loads("\n".join(found))["rule"]


def test_a_pattern_leaves_out_information_and_what_cannot_be_had(swimlab, rules, tmp_path):
    rules(INCREASE)
    write_scores(tmp_path / "run", lacking(NO_DEPTH, budget_mse=1.0, budget_floor=0.1))
    assert swimlab("baseline", "update", "gate.toml", "run")[0] == 0
    # Twice the floor is no worse picture.
    write_scores(tmp_path / "run", lacking(NO_DEPTH, budget_mse=1.0, budget_floor=0.2))
    code, out, _ = swimlab("gate", "gate.toml", "run")
    assert (code, out.splitlines()[-1]) == (0, "gate.toml: passed: 1 pass")


def test_information_is_judged_by_its_full_name(swimlab, rules, tmp_path):
    rules('metric = "budget.floor"\nmax_increase = "5%"')
    write_scores(tmp_path / "run", entry(budget_floor=0.1))
    assert swimlab("baseline", "update", "gate.toml", "run")[0] == 0
    write_scores(tmp_path / "run", entry(budget_floor=0.2))
    assert swimlab("gate", "gate.toml", "run")[0] == 1


def test_what_the_baseline_has_may_not_get_lost(swimlab, rules, tmp_path):
    rules(INCREASE)
    write_scores(tmp_path / "run", entry(budget_mse=1.0, **{"budget_bias.far": 1.0}))
    assert swimlab("baseline", "update", "gate.toml", "run")[0] == 0
    write_scores(tmp_path / "run", lacking(NO_DEPTH, budget_mse=1.0))
    code, out, _ = swimlab("gate", "gate.toml", "run")
    assert code == 2
    assert "unjudged: road-shift/tsl budget.bias.far: is absent: needs depth" in out
    assert tables(out) == [{"sequence": "road-shift", "metric": "budget.bias.far", "level": "off"}]


@pytest.mark.parametrize(
    ("absent", "scores", "reason"),
    [
        (NO_DEPTH, {}, "matches nothing to judge: needs depth"),
        ({}, {"budget_floor": 0.1}, "matches nothing to judge: mere information"),
        ({}, {"plane_on": 0.9}, "matches nothing to judge: none of it has been measured"),
    ],
)
def test_a_pattern_that_leaves_nothing_does_not_pass(swimlab, rules, tmp_path, absent, scores, reason):
    write_gate(tmp_path / "gate.toml", 'metric = "budget.*"\nmax = 1')
    write_scores(tmp_path / "run", lacking(absent, **scores))
    code, out, _ = swimlab("gate", "gate.toml", "run")
    assert (code, reason in out) == (2, True)
    assert tables(out) == [{"sequence": "road-shift", "metric": "budget.*", "level": "off"}]


def test_a_score_that_is_null_is_not_left_out(swimlab, rules, tmp_path):
    write_gate(tmp_path / "gate.toml", 'metric = "budget.*"\nmax = 1')
    write_scores(tmp_path / "run", entry(budget_mse=0.5, budget_bias=None))
    code, out, _ = swimlab("gate", "gate.toml", "run")
    assert (code, "budget.bias: is not a number" in out, "[[rule]]" in out) == (2, True, False)


def test_all_that_a_baseline_lacks_is_named_at_once_with_rules_that_mend_it(swimlab, rules, tmp_path):
    given = [INCREASE, 'metric = "budget.bias.far"\nmax = 1', 'metric = "plane.on"\nmin = 0.5']
    path = rules(*given)
    write_scores(
        tmp_path / "run",
        lacking(NO_DEPTH, budget_mse=1.0, plane_on=0.9),
        lacking(NO_DEPTH, "road-shift", "lean", budget_mse=1.0),
        lacking({"plane.on": "needs a uniform motion"}, "road-drive", **{"budget_bias.far": 1.0}),
    )
    code, out, err = swimlab("baseline", "update", "gate.toml", "run")
    assert (code, out, (tmp_path / "b.json").exists()) == (2, "", False)
    for lost in (
        "tsl on road-shift: budget.bias.far",
        "lean on road-shift: budget.bias.far",
        "lean on road-shift: plane",
    ):
        assert f"swimlab: {lost}" in err
    assert "tsl on road-drive: plane.on cannot go into a baseline: is absent: needs a uniform motion" in err
    # All of road-shift lack the far bias; the stability of the plane, one technique of it.
    assert tables(err) == [
        {"sequence": "road-drive", "metric": "plane.on", "level": "off"},
        {"sequence": "road-shift", "metric": "budget.bias.far", "level": "off"},
        {"sequence": "road-shift", "technique": "lean", "metric": "plane.on", "level": "off"},
    ]
    pasted = err[err.index("[[rule]]") :]
    path.write_text(path.read_text(encoding="utf-8") + pasted, encoding="utf-8")
    assert swimlab("baseline", "update", "gate.toml", "run")[0] == 0
    assert swimlab("gate", "gate.toml", "run")[0] == 0
