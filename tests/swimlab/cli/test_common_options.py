"""Options that every command of its kind has: --dry-run, -v, --json, -q."""

import json

import pytest

from swimlab.runs.record import Record
from swimlab.studies.selftest import Check


def test_a_dry_run_says_what_lacks_and_renders_nothing(swimlab, tmp_path):
    words = ("render", "road-shift", "-t", "pixel-point,pixel-bilinear", "--size", "64x36", "-o", "run", "-q")
    code, out, _ = swimlab(*words, "--frames", "0-1", "--dry-run")
    assert (code, list(tmp_path.iterdir())) == (0, [])
    assert out.strip() == ("run: road-shift, 64x36, 2 frames of pixel-bilinear, pixel-point: 4 of 4 pictures to render")
    code, _, err = swimlab(*words, "--frames", "0", "-v")
    assert code == 0
    assert "rendering road-shift: 2/2 pixel-point" in err
    assert "4 of 6 pictures" in swimlab("study", *words[1:], "--frames", "0-1", "--dry-run")[1]
    assert "2 of 4 pictures" in swimlab(*words, "--frames", "0-1", "--dry-run")[1]
    assert "4 of 4 pictures" in swimlab(*words, "--frames", "0-1", "--dry-run", "--force")[1]
    (row,) = json.loads(swimlab("study", *words[1:], "--frames", "0-1", "--dry-run", "--json")[1])
    assert (row["run"], row["techniques"], row["pictures"], row["done"]) == (
        "run",
        ["pixel-bilinear", "pixel-point", "reference"],
        6,
        2,
    )
    code, _, err = swimlab(*words, "--samples", "16", "--dry-run")
    assert code == 2
    assert "run: holds a run of other settings" in err


@pytest.mark.parametrize(
    ("words", "key"),
    [
        (("list", "techniques"), "source"),
        (("info", "road-shift"), "motion"),
        (("doctor",), "ok"),
        (("table", "."), "rows"),
    ],
)
def test_what_is_shown_comes_as_json_too(swimlab, tmp_path, words, key):
    Record(
        {"name": "a", "size": [1, 1], "fps": 1.0, "motion": {"kind": "b"}},
        {"samples": 4, "half": True},
        "c",
        None,
        False,
        {},
    ).write(tmp_path)
    code, out, _ = swimlab(*words, "--json")
    assert code == 0
    found = json.loads(out)
    assert all(key in each for each in (found if isinstance(found, list) else [found]))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["bogus"], 'Unknown command "bogus"'),
        (["render"], "parameter SEQUENCE requires an argument"),
        (["render", "road-shift", "--bogus"], "Unknown option: --bogus"),
        (["render", "road-shift", "--frames", ""], "--frames : the sequence has frames 0-31"),
        (["list", "foo"], 'Invalid value "foo" for KIND'),
        (["study", "road-shift", "road-shift"], "road-shift: 2 of the sequences are named so"),
        (["nothing", "\n".join("ab")], 'Unknown command "nothing"'),
    ],
)
def test_a_mistake_is_told_in_a_line(swimlab, tmp_path, words, said):
    code, out, err = swimlab(*words)
    assert (code, out) == (2, "")
    assert err.startswith("swimlab: ")
    assert said in err.splitlines()[0]
    assert list(tmp_path.iterdir()) == []


def test_a_quiet_selftest_shows_what_is_off(swimlab, monkeypatch):
    good, off = Check("clip", "a", 1.0, 1.0, 0.1), Check("clip", "b", 2.0, 1.0, 0.1)
    monkeypatch.setattr("swimlab.cli.selftest_command.checks", lambda: [good])
    assert swimlab("selftest", "-q")[:2] == (0, "1 checks, all as expected\n")
    monkeypatch.setattr("swimlab.cli.selftest_command.checks", lambda: [good, off])
    code, out, _ = swimlab("selftest", "-q")
    assert code == 1
    assert [line.split()[1] for line in out.splitlines() if line.strip().startswith("clip ")] == ["score", "b"]
    assert out.endswith("2 checks, 1 OFF\n")
