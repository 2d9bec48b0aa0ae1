"""Runs of other settings than the baseline: what differs is named, and ceilings hold all the same."""

import json

import pytest
from gate_files import HASH, entry, write_gate, write_scores

from swimlab.runs.record import Record

OTHER = "f" * 16
TABLES = {"tsl": {"size": 1024, "inputs": "box"}, "lean": {}}


def write_run(folder, digest=HASH, size=1024, swimlab="0.1.0", samples=64, **scores):
    """A run folder without frames: its record, and its scores."""
    Record(
        sequence={
            "name": "road-shift",
            "techniques": {**TABLES, "tsl": {"size": size}},
            "viewing": {"luminance": size},
        },
        settings={"samples": samples},
        hash=digest,
        uniform_velocity=None,
        resizes=False,
        provenance={"swimlab": swimlab},
        frames=[0, 1],
    ).write(folder)
    return write_scores(folder, entry(**scores), digest=digest)


@pytest.fixture
def gate(swimlab, tmp_path):
    """A gate with a ceiling and a baseline of one run."""
    rule = 'metric = "budget.mse"\nmax = 2\nmax_increase = "5%"'
    path = write_gate(tmp_path / "gate.toml", rule, baseline='file = "b.json"')
    write_run(tmp_path / "before", budget_mse=1.0)
    assert swimlab("baseline", "update", "gate.toml", "before")[0] == 0
    return path


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"size": 128}, "baseline: techniques.tsl.size 1024 → 128; "),
        ({"size": 128, "samples": 16}, "baseline: techniques.tsl.size 1024 → 128, samples 64 → 16; "),
        ({"swimlab": "0.2.0"}, "baseline: swimlab 0.1.0 → 0.2.0; "),
        ({}, f"settings hash {OTHER} instead of {HASH}, though all settings agree: a map file has changed"),
    ],
)
def test_what_differs_is_named(swimlab, gate, tmp_path, change, named):
    write_run(tmp_path / "run", OTHER, **change, budget_mse=1.0)
    code, out, _ = swimlab("gate", "gate.toml", "run")
    assert (code, named in out, "above" in out) == (2, True, False)


def test_a_ceiling_holds_under_other_settings_too(swimlab, gate, tmp_path):
    write_run(tmp_path / "run", OTHER, size=128, budget_mse=2.5)
    code, out, _ = swimlab("gate", "gate.toml", "run", "--json", "gate.json")
    assert (code, "independent of the baseline, 2.5 is above 2" in out) == (2, True)
    (check,) = json.loads((tmp_path / "gate.json").read_text(encoding="utf-8"))["checks"]
    assert (check["status"], check["value"], check["limit"]) == ("unjudged", 2.5, "<= 2")


def test_a_baseline_without_settings_reads(swimlab, gate, tmp_path):
    """As those written before there were any."""
    content = json.loads((tmp_path / "b.json").read_text(encoding="utf-8"))
    assert content.pop("settings_by_hash")[HASH]["techniques.tsl.size"] == 1024
    (tmp_path / "b.json").write_text(json.dumps(content), encoding="utf-8")
    assert swimlab("gate", "gate.toml", "before")[0] == 0
    write_run(tmp_path / "run", OTHER, size=128, budget_mse=1.0)
    code, out, _ = swimlab("gate", "gate.toml", "run")
    assert (code, f"settings hash {OTHER} instead of {HASH}" in out) == (2, True)


def test_runs_of_one_baseline_say_what_differs(swimlab, gate, tmp_path):
    write_run(tmp_path / "run", OTHER, size=128, budget_mse=1.0)
    code, _, err = swimlab("baseline", "update", "gate.toml", "before", "run")
    assert code == 2
    assert "tsl on road-shift: cannot go into one baseline: techniques.tsl.size 1024 → 128; give runs" in err


def test_frames_of_ones_own_say_what_differs(swimlab, gate, tmp_path):
    for fps, digest in ((60.0, HASH), (30.0, OTHER)):
        content = {"version": 1, "provenance": {"hash": digest, "settings": {"fps": fps, "size": [8, 4]}}}
        content["sequences"] = [entry(budget_mse=1.0)]
        (tmp_path / f"{fps:g}.json").write_text(json.dumps(content), encoding="utf-8")
    assert swimlab("baseline", "update", "gate.toml", "60.json")[0] == 0
    code, out, _ = swimlab("gate", "gate.toml", "30.json")
    assert (code, "baseline: fps 60.0 → 30.0; " in out) == (2, True)
