"""What a gate writes: table, JSON, JUnit, step summary, annotations, baseline."""

import json
from math import sqrt
from xml.etree import ElementTree

import numpy as np
import pytest
from gate_files import HASH, entry, write_gate, write_scores
from hypothesis import given
from hypothesis import strategies as st

from swimlab.gate.baseline import Spread


@pytest.fixture
def failing(tmp_path, monkeypatch):
    """A gate over a score that passes, one that warns, one that fails and one that is NaN."""
    monkeypatch.delenv("GITHUB_STEP_SUMMARY", raising=False)
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    rules = [f'metric = "budget.{part}"\nmax = 1' for part in ("mse", "flicker", "bias")]
    write_gate(tmp_path / "gate.toml", *rules, 'metric = "budget.detail"\nmax = 1\nlevel = "warn"')
    write_scores(tmp_path / "run", entry(budget_mse=0.5, budget_flicker=2.0, budget_bias=None, budget_detail=3.0))


def test_the_table_goes_to_standard_output(swimlab, failing):
    code, out, err = swimlab("gate", "gate.toml", "run")
    assert (code, err) == (1, "")
    rows = {words[3]: words[0] for words in map(str.split, out.splitlines()) if len(words) > 3 and words[2] == "tsl"}
    expected = {"mse": "pass", "flicker": "fail", "bias": "unjudged", "detail": "warn"}
    assert rows == {f"budget.{part}": status for part, status in expected.items()}
    why = "2 is above 1; worst in frame 1 (no picture of it: no run folder lies beside the scores); rule 2"
    assert f"fail: road-shift/tsl budget.flicker: {why}" in out
    assert out.splitlines()[-1] == "gate.toml: FAILED: 1 fail, 1 unjudged, 1 warn, 1 pass"


def test_json_junit_and_summary_are_written(swimlab, failing, tmp_path):
    words = ("--json", "new/gate.json", "--junit", "gate.xml", "--summary", "gate.md")
    assert swimlab("gate", "gate.toml", "run", *words)[0] == 1
    found = json.loads((tmp_path / "new" / "gate.json").read_text(encoding="utf-8"))
    assert (found["exit_code"], len(found["checks"])) == (1, 4)
    assert found["provenance"]["runs"] == ["run"]
    assert found["provenance"]["command"].startswith("swimlab gate gate.toml run")

    suite = ElementTree.parse(tmp_path / "gate.xml").getroot()[0]
    assert {key: suite.get(key) for key in ("tests", "failures", "errors")} == {
        "tests": "4",
        "failures": "1",
        "errors": "1",
    }
    children = {case.get("name"): [child.tag for child in case] for case in suite}
    assert children["budget.flicker"] == ["failure", "system-out"]
    assert children["budget.bias"] == ["error", "system-out"]
    assert children["budget.detail"] == children["budget.mse"] == ["system-out"]

    text = (tmp_path / "gate.md").read_text(encoding="utf-8")
    assert text.startswith("### gate.toml: FAILED")
    assert sum(line.startswith("| ") and "budget." in line for line in text.splitlines()) == 4


def test_github_gets_summary_and_annotations_unasked(swimlab, failing, tmp_path, monkeypatch):
    (tmp_path / "summary.md").write_text("before\n", encoding="utf-8")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    _, out, _ = swimlab("gate", "gate.toml", "run")
    lines = [line for line in out.splitlines() if line.startswith("::")]
    titles = [line.split("title=swimlab gate%3A road-shift/tsl ")[1].split("::")[0] for line in lines]
    levels = [line.split("::")[1].split()[0] for line in lines]
    assert dict(zip(titles, levels, strict=True)) == {
        "budget.bias": "error",
        "budget.detail": "warning",
        "budget.flicker": "error",
    }
    assert (tmp_path / "summary.md").read_text(encoding="utf-8").startswith("before\n### gate.toml: FAILED")
    assert "::error" not in swimlab("gate", "gate.toml", "run", "--no-annotations")[1]


@pytest.mark.parametrize(
    ("gate", "run", "message"),
    [
        ("none.toml", "run", "none.toml: cannot be read"),
        ("lost.toml", "run", "b.json: cannot be read"),
        ("gate.toml", "nowhere", "nowhere/scores.json: is missing"),
    ],
)
def test_a_gate_that_cannot_run_is_an_error_in_junit(swimlab, failing, tmp_path, gate, run, message):
    write_gate(tmp_path / "lost.toml", 'metric = "budget.mse"\nmax_increase = 0', baseline='file = "b.json"')
    assert swimlab("gate", gate, run, "--junit", "new/gate.xml")[0] == 2
    root = ElementTree.parse(tmp_path / "new" / "gate.xml").getroot()
    assert (root.get("errors"), root[0].get("name")) == ("1", gate)
    assert message in root.findall(".//testcase/error")[0].get("message")


def test_nothing_but_the_table_unasked_elsewhere(swimlab, failing, tmp_path):
    before = set(tmp_path.rglob("*"))
    assert "::error" not in swimlab("gate", "gate.toml", "run")[1]
    assert set(tmp_path.rglob("*")) == before
    assert "::error" in swimlab("gate", "gate.toml", "run", "--annotations")[1]


def test_odd_names_break_no_format(swimlab, tmp_path):
    name = "a|b<c>,d:e\x07%\n*"
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    write_scores(tmp_path / "run", entry(sequence=name, budget_mse=2.0))
    code, out, _ = swimlab("gate", "gate.toml", "run", "--junit", "g.xml", "--summary", "g.md", "--annotations")
    assert code == 1
    ElementTree.parse(tmp_path / "g.xml")
    (row,) = [line for line in (tmp_path / "g.md").read_text(encoding="utf-8").splitlines() if "budget.mse |" in line]
    assert row.replace("\\|", "").count("|") == 9
    (line,) = [line for line in out.splitlines() if line.startswith("::")]
    assert "title=swimlab gate%3A a|b<c>%2Cd%3Ae\x07%25%0A*/tsl budget.mse::" in line


def test_a_baseline_is_made_of_several_runs(swimlab, tmp_path, tolerance):
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax_increase = "5%"', baseline='file = "b/main.json"')
    for number, value in enumerate((1.0, 2.0, 6.0)):
        write_scores(tmp_path / f"run{number}", entry(budget_mse=value, budget_bias=7.0))
    code, out, _ = swimlab("baseline", "update", "gate.toml", "run0", "run1", "run2", "--runs", "3")
    assert code == 0
    assert out.splitlines()[0] == "road-shift tsl budget.mse = 3, sigma 2.646 (3 runs)"
    content = json.loads((tmp_path / "b" / "main.json").read_text(encoding="utf-8"))
    assert content["provenance"]["command"] == "swimlab baseline update gate.toml run0 run1 run2 --runs 3"
    (found,) = content["entries"]
    assert (found["hash"], found["runs"], found["extent"]) == (HASH, 3, "0-1")
    assert set(found["scores"]) == {"budget.mse"}
    assert found["scores"]["budget.mse"]["sigma"] == pytest.approx(sqrt(7), rel=tolerance("closed form"))
    # What was there before is gone: the file is written anew.
    assert swimlab("baseline", "update", "gate.toml", "run1")[0] == 0
    (found,) = json.loads((tmp_path / "b" / "main.json").read_text(encoding="utf-8"))["entries"]
    assert (found["runs"], found["scores"]["budget.mse"]) == (1, {"mean": 2.0, "sigma": None})
    assert [path.name for path in (tmp_path / "b").iterdir()] == ["main.json"]


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=20), st.sampled_from([0.0, 1e9]))
def test_the_spread_is_the_standard_deviation(tolerance, values, level):
    spread = Spread()
    for value in values:
        spread.add(level + value)
    shifted = np.array(values) + level
    scale = 1.0 + float(np.abs(shifted).max())
    assert spread.mean == pytest.approx(shifted.mean(), abs=tolerance("closed form") * scale)
    assert spread.sigma == pytest.approx(shifted.std(ddof=1), abs=tolerance("closed form") * scale)
