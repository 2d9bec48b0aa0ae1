"""Scores over time: files, numbers that no two take, what is compared with what, the trend."""

import json
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from gate_files import entry, write_scores

from swimlab.compare import history
from swimlab.compare.history import Commit, commit_of
from swimlab.runs.entries import read_entries
from swimlab.runs.record import RunError

HERE = Commit("nogit", dirty=False)


def write(folder, value, **options):
    made = entry(budget_flicker=value) | {"errors": {"budget.flicker": 0.1}, "curves": {"budget.bands": {"x": [1.0]}}}
    return write_scores(folder, made, **options)


def save(tmp_path, value, **options):
    return history.save(tmp_path / "history", [write(tmp_path / "run", value, **options)], HERE, provenance={"a": "b"})


def git(folder, *words):
    who = ["-c", "user.name=a", "-c", "user.email=a@b.invalid", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", "-C", str(folder), *who, *words], check=True, capture_output=True)


def test_files_are_numbered_and_named_after_the_commit(tmp_path):
    first, second = save(tmp_path, 1.0), save(tmp_path, 2.0)
    assert first.name.startswith("0001_nogit_")
    assert second.name.startswith("0002_nogit_")
    assert sorted(path.name for path in (tmp_path / "history").iterdir()) == [first.name, second.name]


def test_a_saved_file_is_a_file_of_scores_without_its_curves(tmp_path):
    path = save(tmp_path, 1.5)
    (saved,), (now,) = read_entries(path), read_entries(tmp_path / "run")
    assert saved == replace(now, curves={}, provenance=saved.provenance)
    assert saved.provenance["a"] == "b"
    assert saved.provenance["commit"] == {"name": "nogit", "dirty": False}


def test_two_at_a_time_take_two_numbers(tmp_path):
    run = write(tmp_path / "run", 1.0)
    folder = tmp_path / "history"
    with ThreadPoolExecutor(8) as pool:
        paths = list(pool.map(lambda _: history.save(folder, [run], HERE, provenance={}), range(24)))
    assert len({path.name.partition("_")[0] for path in paths}) == 24
    assert len(list(folder.iterdir())) == 24


def test_a_claim_left_by_a_killed_process_costs_its_number_alone(tmp_path):
    save(tmp_path, 1.0)
    (tmp_path / "history" / ".0002.claim").touch()
    assert save(tmp_path, 1.0).name.startswith("0003_")


def test_a_write_that_fails_leaves_nothing(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr(history, "write_json", fail)
    with pytest.raises(OSError, match="disk full"):
        save(tmp_path, 1.0)
    assert list((tmp_path / "history").iterdir()) == []


def test_scores_are_held_against_the_last_of_the_same_settings(tmp_path):
    save(tmp_path, 1.0)
    save(tmp_path, 7.0, digest="feedfeedfeedfeed")
    save(tmp_path, 9.0, domain="display")
    now = read_entries(write(tmp_path / "run", 2.0))
    (trend,) = history.look_back(now, history.read_history(tmp_path / "history")).trends
    assert (trend.change.before, trend.change.after, trend.values) == (1.0, 2.0, (1.0, 2.0))
    assert trend.since.name.startswith("0001_")
    assert trend.change.verdict == "worse"


def test_the_first_of_its_settings_is_said_to_be(tmp_path):
    save(tmp_path, 7.0, digest="feedfeedfeedfeed")
    now = read_entries(write(tmp_path / "run", 2.0))
    found = history.look_back(now, history.read_history(tmp_path / "history"))
    assert (found.trends, found.first) == ([], {("road-shift", "tsl"): 1})
    assert history.look_back(now, []).first == {("road-shift", "tsl"): 0}


def test_numbers_beyond_9999_come_last(tmp_path):
    path = save(tmp_path, 1.0)
    path.rename(path.with_name("9999_nogit_x.json"))
    assert save(tmp_path, 2.0).name.startswith("10000_")
    found = history.read_history(tmp_path / "history")
    assert [snapshot.path.name.partition("_")[0] for snapshot in found] == ["9999", "10000"]


def test_a_damaged_file_is_named(tmp_path):
    save(tmp_path, 1.0).write_text("{")
    with pytest.raises(RunError, match=r"0001_nogit_.*is not JSON"):
        history.read_history(tmp_path / "history")


def test_what_does_not_go_into_one_file_is_refused(tmp_path):
    one = write(tmp_path / "one", 1.0)
    display = write_scores(tmp_path / "display", entry("road-hills", budget_flicker=1.0), domain="display")
    other = write_scores(tmp_path / "other", entry(technique="lean", budget_flicker=1.0), digest="feedfeedfeedfeed")
    bare = write_scores(tmp_path / "bare", entry(budget_flicker=1.0), digest=None)
    for runs, said in [
        ((one, display), "several domains"),
        ((one, other), "several settings"),
        ((bare,), "no settings"),
    ]:
        with pytest.raises(RunError, match=said):
            history.save(tmp_path / "history", runs, HERE, provenance={})


def test_the_spark_goes_from_least_to_greatest():
    assert history.spark([0, 1, 2, 3, 4, 5, 6, 7]) == "▁▂▃▄▅▆▇█"
    assert history.spark([5.0, 5.0]) == "▄▄"
    assert len(history.spark(range(100))) == 16


def test_the_commit_is_that_of_the_repository(tmp_path, monkeypatch):
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    work = tmp_path / "work"
    work.mkdir()
    assert str(commit_of(work)) == "nogit"
    git(tmp_path, "init", "-q", str(work))
    assert str(commit_of(work)) == "nogit"
    (work / "file").write_text("1")
    git(work, "add", "file")
    git(work, "commit", "-q", "-m", "first")
    git(work, "tag", "v1")
    clean = commit_of(work)
    assert len(clean.name) == 40
    assert int(clean.name, 16) >= 0
    assert not clean.dirty
    (work / "untracked").touch()
    assert commit_of(work) == clean
    (work / "file").write_text("2")
    assert str(commit_of(work)) == f"{clean.name[:12]}_uncommitted-changes"


def test_without_git_there_is_no_commit(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert commit_of(tmp_path) == HERE


def test_the_command_saves_and_looks_back(swimlab, tmp_path, monkeypatch):
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    for value in (1.0, 1.0, 1.0):
        write(tmp_path / "run", value)
        code, out, _ = swimlab("compare", "--history", "history", "run", "--save")
        assert code == 0
    assert out.splitlines()[-1].startswith("history/0003_nogit_")
    write(tmp_path / "run", 1.01)
    code, out, _ = swimlab("compare", "--history", "history", "run")
    (row,) = [line.split() for line in out.splitlines() if line.strip().startswith("tsl")]
    assert " ".join(row[1:]) == "budget.flicker radiance^2 1 1.01 +0.01 +1.0 +∞ worse spread of 3 runs ▁▁▁█"
    assert len(list((tmp_path / "history").iterdir())) == 3
    code, out, _ = swimlab("compare", "--history", "history", "run", "--json", "--save")
    content = json.loads(out)
    assert content["saved"].startswith("history/0004_")
    assert content["changes"][0]["values"] == [1.0, 1.0, 1.0, 1.01]


def test_a_folder_without_history_files_is_said_to_hold_none(swimlab, tmp_path, monkeypatch):
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    write(tmp_path / "run", 1.0)
    (tmp_path / "empty").mkdir()
    code, out, _ = swimlab("compare", "--history", "empty", "run")
    assert (code, out) == (0, "empty: holds no history files yet; --save adds one\n")
    first, saved = swimlab("compare", "--history", "empty", "run", "--save")[1].splitlines()
    assert first == "empty: holds no history files yet"
    assert saved.startswith("empty/0001_")
    write(tmp_path / "run", 1.0, digest="feedfeedfeedfeed")
    out = swimlab("compare", "--history", "empty", "run")[1]
    assert out.startswith("tsl on road-shift: no earlier run of the same settings, 1 of others\n")
