"""Bad gates, baselines and scores: each ends with exit code 2 and a message that names the file and the key."""

import json

import pytest
from gate_files import HASH, entry, write_gate, write_scores

RULE = 'metric = "budget.mse"\nmax = 1'
COMPARING = 'metric = "budget.mse"\nmax_increase = "5%"'

BAD_GATES = {
    "no TOML": ("version = 1\n[[rule]\n", "gate.toml: not TOML"),
    "no version": (f"[[rule]]\n{RULE}", "gate.toml: version: missing"),
    "another version": (f"version = 2\n[[rule]]\n{RULE}", "gate.toml: version: should be 1, got 2"),
    "no rules": ("version = 1", "gate.toml: rule: missing"),
    "an empty list of rules": ("version = 1\nrule = []", "gate.toml: rule: List should have at least 1 item"),
    "a table for a list": (f"version = 1\n[rule]\n{RULE}", "gate.toml: rule: should be a valid list"),
    "an unknown table": (f"version = 1\n[baselin]\n[[rule]]\n{RULE}", "baselin: unknown key (did you mean 'baseline'?"),
    "an unknown key": ('version = 1\n[[rule]]\nmetric = "budget.mse"\nmaxx = 1', "rule 1.maxx: unknown key (did you"),
    "no metric": ("version = 1\n[[rule]]\nmax = 1", "gate.toml: rule 1.metric: missing"),
    "an empty pattern": ('version = 1\n[[rule]]\nmetric = ""\nmax = 1', "rule 1.metric: should not be empty"),
    "no limit": ('version = 1\n[[rule]]\nmetric = "budget.mse"', "gate.toml: rule 1: limits nothing"),
    "an unknown level": (f'version = 1\n[[rule]]\n{RULE}\nlevel = "fatal"', "rule 1.level: should be 'off', 'warn'"),
    "a limit that is text": ('version = 1\n[[rule]]\nmetric = "a"\nmax = "1"', "rule 1.max: should be a valid number"),
    "a limit that is NaN": ('version = 1\n[[rule]]\nmetric = "a"\nmax = nan', "rule 1.max: should be a finite number"),
    "limits crossed": (f"version = 1\n[[rule]]\n{RULE}\nmin = 2", "rule 1: min is 2 and max 1: no value passes"),
    "an increase without unit": ('version = 1\n[[rule]]\nmetric = "a"\nmax_increase = "5"', "max_increase: should be"),
    "an increase below 0": ('version = 1\n[[rule]]\nmetric = "a"\nmax_increase = -1', "should be 0 or more, got -1"),
    "a share below 0": ('version = 1\n[[rule]]\nmetric = "a"\nmax_increase = "-5%"', "max_increase: should be"),
    "an infinite share": ('version = 1\n[[rule]]\nmetric = "a"\nmax_increase = "inf%"', "max_increase: should be"),
    "two shares": ('version = 1\n[[rule]]\nmetric = "a"\nmax_increase = ["5%", "6%"]', "max_increase: should be"),
    "an increase of true": ('version = 1\n[[rule]]\nmetric = "a"\nmax_increase = true', "max_increase: should be"),
    "an increase over nothing": (
        f"version = 1\n[[rule]]\n{COMPARING}",
        "rule 1: max_increase compares with a baseline",
    ),
    "noise over nothing": (
        f"version = 1\n[[rule]]\n{RULE}\nnoise_sigma = 3",
        "noise_sigma says nothing without max_inc",
    ),
    "noise below 0": (f"version = 1\n[[rule]]\n{COMPARING}\nnoise_sigma = -1", "rule 1.noise_sigma: should be greater"),
    "a baseline without file": (f"version = 1\n[baseline]\n[[rule]]\n{RULE}", "gate.toml: baseline.file: missing"),
    "an unknown word for missing": (
        f'version = 1\n[baseline]\nfile = "b.json"\nmissing = "ok"\n[[rule]]\n{RULE}',
        "baseline.missing: should be 'error' or 'warn'",
    ),
    "every rule off": ('version = 1\n[[rule]]\nmetric = "a"\nlevel = "off"', "gate.toml: every rule is off"),
}


@pytest.mark.parametrize("what", BAD_GATES)
def test_bad_gates_are_refused_by_file_and_key(swimlab, tmp_path, what):
    text, message = BAD_GATES[what]
    (tmp_path / "gate.toml").write_text(text, encoding="utf-8")
    write_scores(tmp_path / "run", entry(budget_mse=0.5))
    code, out, err = swimlab("gate", "gate.toml", "run")
    assert (code, out) == (2, "")
    assert message in err
    assert all(line.startswith("swimlab: ") for line in err.splitlines())


def test_every_mistake_is_named_at_once(swimlab, tmp_path):
    write_gate(tmp_path / "gate.toml", 'metric = ""\nmaxx = 1', 'metric = "a"\nlevel = "of"', baseline="fil = 1")
    code, _, err = swimlab("gate", "gate.toml", "run")
    assert code == 2
    keys = ("rule 1.metric", "rule 1.maxx", "rule 2.level", "baseline.file", "baseline.fil")
    assert all(f"gate.toml: {key}: " in err for key in keys)
    assert len(err.splitlines()) == len(keys)


BAD_SCORES = {
    "no folder": (None, "scores.json: is missing"),
    "no JSON": ("{", "scores.json: is not JSON"),
    "a list": ("[]", "scores.json: has version None"),
    "another version": ('{"version": 9}', "scores.json: has version 9, this swimlab reads 1"),
    "no sequences": ('{"version": 1, "provenance": {}}', "scores.json: is not a file of scores"),
    "no entry": ('{"version": 1, "provenance": {}, "sequences": []}', "scores.json: holds no scores"),
    "an entry without scores": (
        '{"version": 1, "provenance": {}, "sequences": [{"sequence": "a", "technique": "b"}]}',
        "scores.json: is not a file of scores (KeyError('scores'))",
    ),
    "more hashes than sequences": (
        json.dumps({"version": 1, "provenance": {"hash": "1, 2"}, "sequences": [entry()]}),
        "scores.json: has 2 settings hashes for 1 sequences",
    ),
}


@pytest.mark.parametrize("what", BAD_SCORES)
def test_bad_scores_are_refused_by_file(swimlab, tmp_path, what):
    text, message = BAD_SCORES[what]
    write_gate(tmp_path / "gate.toml", RULE)
    if text is not None:
        (tmp_path / "run").mkdir()
        (tmp_path / "run" / "scores.json").write_text(text, encoding="utf-8")
    code, out, err = swimlab("gate", "gate.toml", "run")
    assert (code, out) == (2, "")
    assert message in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["gate", "nowhere.toml", "run"], "nowhere.toml: cannot be read"),
        (["gate", "plain.toml"], "name at least one run folder"),
        (["gate", "plain.toml", "run", "run"], "tsl on road-shift is in run already"),
        (["gate"], "GATE"),
        (["gate", "gate.toml", "run", "--jsn", "x"], "--jsn"),
        (["baseline", "updat", "gate.toml", "run"], "updat"),
        (["baseline", "update", "gate.toml"], "name at least one run folder"),
        (["baseline", "update", "plain.toml", "run"], "plain.toml: names no baseline"),
        (["baseline", "update", "gate.toml", "run", "--runs", "2"], "tsl on road-shift: has 1 run, --runs asks for 2"),
        (["baseline", "update", "gate.toml", "nan"], "budget.mse cannot go into a baseline: is not a number"),
        (["baseline", "update", "gate.toml", "other"], "budget.mse cannot go into a baseline: has not been measured"),
        (["baseline", "update", "gate.toml", "absent"], "cannot go into a baseline: is absent: needs a reference"),
        (["baseline", "update", "gate.toml", "run", "renewed"], "cannot go into one baseline: settings hash ffff"),
        (["baseline", "update", "gate.toml", "unhashed"], "carry no settings hash"),
        (["baseline", "update", "off.toml", "run"], "off.toml: every rule is off"),
    ],
)
def test_bad_commands_are_refused(swimlab, tmp_path, words, message):
    write_gate(tmp_path / "plain.toml", RULE)
    write_gate(tmp_path / "gate.toml", COMPARING, baseline='file = "b.json"')
    write_gate(tmp_path / "off.toml", 'metric = "*"\nlevel = "off"', baseline='file = "b.json"')
    write_scores(tmp_path / "run", entry(budget_mse=0.5))
    write_scores(tmp_path / "nan", entry(budget_mse=None))
    write_scores(tmp_path / "other", entry(budget_bias=0.5))
    write_scores(tmp_path / "absent", {**entry(), "absent": {"budget.mse": "needs a reference"}})
    write_scores(tmp_path / "renewed", entry(budget_mse=0.5), digest="ffff")
    write_scores(tmp_path / "unhashed", entry(budget_mse=0.5), digest=None)
    code, out, err = swimlab(*words)
    assert (code, out) == (2, "")
    assert message in " ".join(err.split())
    assert not (tmp_path / "b.json").exists()


BAD_BASELINES = {
    "no file": (None, "b.json: cannot be read (No such file or directory); make it: swimlab baseline update gate.toml"),
    "no JSON": ("{", "b.json: is not a baseline"),
    "another version": ('{"version": 7}', "b.json: has version 7"),
    "no entries": ('{"version": 1}', "b.json: is not a baseline (KeyError('entries'))"),
    "a mean that is null": (
        json.dumps(
            {
                "version": 1,
                "entries": [
                    {
                        "sequence": "road-shift",
                        "technique": "tsl",
                        "runs": 1,
                        "hash": HASH,
                        "domain": "linear",
                        "extent": "0-1",
                        "scores": {"budget.mse": {"mean": None, "sigma": None}},
                    }
                ],
            }
        ),
        "b.json: is not a baseline (ValueError('None is not a finite number'))",
    ),
}


@pytest.mark.parametrize("what", BAD_BASELINES)
def test_bad_baselines_are_refused_by_file(swimlab, tmp_path, what):
    text, message = BAD_BASELINES[what]
    write_gate(tmp_path / "gate.toml", COMPARING, baseline='file = "b.json"')
    write_scores(tmp_path / "run", entry(budget_mse=0.5))
    if text is not None:
        (tmp_path / "b.json").write_text(text, encoding="utf-8")
    code, out, err = swimlab("gate", "gate.toml", "run")
    assert (code, out) == (2, "")
    assert message in err


@pytest.mark.parametrize("file", ["gate.toml", "baseline.json", "run/scores.json"])
def test_files_with_a_byte_order_mark_are_read(swimlab, tmp_path, file):
    """As editors on Windows write them."""
    write_scores(tmp_path / "run", entry(budget_mse=1.0))
    write_gate(tmp_path / "gate.toml", COMPARING, baseline='file = "baseline.json"')
    assert swimlab("baseline", "update", "gate.toml", "run")[0] == 0
    marked = b"\xef\xbb\xbf" + (tmp_path / file).read_bytes().replace(b"\n", b"\r\n")
    (tmp_path / file).write_bytes(marked)
    code, _, err = swimlab("gate", "gate.toml", "run")
    assert code == 0, err
