"""What may make scores wrong is told wherever they are judged, recorded or compared; it changes no verdict."""

import json
from xml.etree import ElementTree

import pytest
from gate_files import entry, write_gate, write_scores

WRONG = "motion not verified: goes the other way"


@pytest.fixture
def doubtful(tmp_path, monkeypatch):
    """A run of two techniques with the same warning and one of another sequence without; a gate that both pass."""
    monkeypatch.delenv("GITHUB_STEP_SUMMARY", raising=False)
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    entries = [entry(technique=name, budget_mse=0.5) | {"warnings": [WRONG]} for name in ("tsl", "vmf")]
    write_scores(tmp_path / "run", *entries, entry(sequence="calm", budget_mse=0.5))
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    return tmp_path


def test_a_gate_that_passes_warns_in_all_that_it_writes(swimlab, doubtful):
    words = ("--json", "g.json", "--junit", "g.xml", "--summary", "g.md", "--annotations")
    code, out, _ = swimlab("gate", "gate.toml", "run", *words)
    line = f"tsl, vmf on road-shift: {WRONG}"
    assert code == 0
    assert out.splitlines().count(f"warning: {line}") == 1
    assert [text for text in out.splitlines() if text.startswith("::")] == [
        f"::warning file=gate.toml,title=swimlab gate::{line}"
    ]
    assert json.loads((doubtful / "g.json").read_text(encoding="utf-8"))["warnings"] == [line]
    suite = ElementTree.parse(doubtful / "g.xml").getroot()[0]
    assert (suite.get("failures"), suite.get("errors")) == ("0", "0")
    assert suite.findtext("system-err") == f"warning: {line}"
    assert f"- warning: {line}" in (doubtful / "g.md").read_text(encoding="utf-8").splitlines()


def test_of_what_no_rule_speaks_there_is_no_warning(swimlab, doubtful):
    write_gate(doubtful / "gate.toml", 'sequence = "calm"\nmetric = "budget.mse"\nmax = 1')
    assert "warning" not in swimlab("gate", "gate.toml", "run")[1]


def test_the_fixture_warns(swimlab_gate, doubtful):
    with pytest.warns(pytest.PytestWarning, match=WRONG):
        assert swimlab_gate(doubtful / "run", doubtful / "gate.toml").exit_code == 0


def test_a_baseline_and_a_comparison_warn_on_standard_error(swimlab, doubtful):
    write_gate(doubtful / "gate.toml", 'metric = "budget.mse"\nmax_increase = 0', baseline='file = "b.json"')
    write_scores(doubtful / "other", entry(budget_mse=0.5))
    for words in (("baseline", "update", "gate.toml", "run"), ("compare", "other", "run")):
        code, _, err = swimlab(*words)
        assert code == 0
        assert err.splitlines().count(f"swimlab: warning: tsl, vmf on road-shift: {WRONG}") == 1
