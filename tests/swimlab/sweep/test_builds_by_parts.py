"""Long builds measured by parts: the bits of one process, no part twice, nothing lost."""

import json
import shutil
from pathlib import Path

import pytest
from small_shot import write_shot
from turning_shot import write_turning_shot

import metrics.plan
from swimlab.scoring.by_parts import runs
from swimlab.sweep import build, engine

FIRST, LAST = (0, 8), (9, 21)
"""The frames of the shot's parts."""


@pytest.fixture
def shot(tmp_path, monkeypatch):
    """A shot of a few frames that counts as long: five spans, and two parts, which meet within the first."""
    monkeypatch.setattr(metrics.plan, "LONGEST_UNWARPED", 5)
    monkeypatch.setattr(build, "LEAST", 8)
    return write_turning_shot(tmp_path, count=22, cut=13, side=72)


@pytest.fixture
def looked_at(monkeypatch):
    """The frames of the parts that are looked at from now on, and those of parts that fail."""
    frames, failing = [], []
    real = build.look_at

    def note(planned, part, **options):
        frames.append(part.frames)
        if part.frames in failing:
            raise OSError("the disk is gone")
        return real(planned, part, **options)

    monkeypatch.setattr(build, "look_at", note)
    return frames, failing


@pytest.fixture(autouse=True)
def here(monkeypatch):
    """The engine of this process under the name of the cluster's."""

    class Here:
        def __init__(self, *_, **__):
            pass

        def __enter__(self):
            return engine.local

        def __exit__(self, *_):
            pass

    monkeypatch.setattr("swimlab.cli.engines.dask_engine", Here)


def entries(run: Path):
    return json.loads((run / "scores.json").read_text(encoding="utf-8"))["sequences"]


def test_parts_score_as_one_process(swimlab, shot, looked_at):
    home = shot.parent
    assert swimlab("study", shot, "-q", "-o", home / "plain")[0] == 0
    code, _, err = swimlab("study", shot, "-q", "-o", home / "parts", "--engine", "dask")
    assert code == 0, err
    assert looked_at[0] == [FIRST, LAST]
    assert entries(home / "parts") == entries(home / "plain")
    assert (home / "parts" / "frames.csv").read_bytes() == (home / "plain" / "frames.csv").read_bytes()
    assert not (home / "parts" / ".scores").exists()
    assert entries(home / "parts")[0]["motion_check"]["cuts"] == [13]
    assert "budget.alignment_floor" in entries(home / "parts")[0]["scores"]


def test_a_part_that_fails_loses_no_other(swimlab, shot, looked_at):
    frames, failing = looked_at
    failing.append(LAST)
    run = shot.parent / "run"
    words = ("study", shot, "-q", "-o", run, "--engine", "dask")
    code, _, err = swimlab(*words)
    assert (code, "carousel, noisy, frames 9-21: the disk is gone" in err) == (2, True)
    assert [path.name.partition(".")[2] for path in (run / ".scores").glob("*.part")] == ["0-8.part"]
    failing.clear()
    assert swimlab(*words)[0] == 0
    assert frames == [FIRST, LAST, LAST]
    assert not list((run / "failures").iterdir())


def test_a_part_whose_file_is_gone_is_measured_again(swimlab, shot, looked_at, monkeypatch):
    frames, _ = looked_at
    run = shot.parent / "run"
    words = ("study", shot, "-q", "-o", run, "--engine", "dask")

    def fail(*_):
        raise OSError("the disk is full")

    with monkeypatch.context() as context:
        context.setattr(build, "join_parts", fail)
        assert swimlab(*words)[0] == 2
    (part,) = (run / ".scores").glob("*.0-8.part")
    part.unlink()
    assert swimlab(*words)[0] == 0
    assert frames == [FIRST, LAST, FIRST]


def test_parts_of_a_shot_that_moved_are_gone_on_with(swimlab, shot, looked_at, tmp_path_factory):
    """The plan has the files where they were open, and is made again."""
    frames, failing = looked_at
    failing.append(LAST)
    run = tmp_path_factory.mktemp("runs") / "run"
    assert swimlab("study", shot, "-q", "-o", run, "--engine", "dask")[0] == 2
    failing.clear()
    moved = shot.parent.rename(tmp_path_factory.mktemp("new") / "home")
    code, _, err = swimlab("study", moved / shot.name, "-q", "-o", run, "--engine", "dask")
    assert code == 0, err
    assert frames == [FIRST, LAST, LAST]


def test_parts_of_frames_that_have_changed_are_not_joined(swimlab, shot, looked_at):
    frames, failing = looked_at
    failing.append(FIRST)
    words = ("study", shot, "-q", "-o", shot.parent / "run", "--engine", "dask")
    assert swimlab(*words)[0] == 2
    failing.clear()
    shutil.copy(shot.parent / "ref" / "0003.exr", shot.parent / "noisy" / "0003.exr")
    assert swimlab(*words)[0] == 0
    assert frames[2:] == [FIRST, LAST]


def test_a_frame_that_changes_while_a_part_is_measured_is_told(swimlab, shot, monkeypatch):
    real = build.look_at

    def change(planned, part, **options):
        found = real(planned, part, **options)
        shutil.copy(shot.parent / "ref" / "0003.exr", shot.parent / "noisy" / "0003.exr")
        return found

    monkeypatch.setattr(build, "look_at", change)
    run = shot.parent / "run"
    code, _, err = swimlab("study", shot, "-q", "-o", run, "--engine", "dask")
    assert (code, "0003.exr: has changed while it was measured" in err) == (2, True)
    assert not list((run / ".scores").glob("*.part"))


def test_a_build_of_one_span_is_one_task(swimlab, tmp_path, looked_at, monkeypatch):
    monkeypatch.setattr(build, "LEAST", 1)
    shot = write_shot(tmp_path)
    assert swimlab("study", shot, "-q", "-o", tmp_path / "run", "--engine", "dask")[0] == 0
    assert not looked_at[0]
    assert len(entries(tmp_path / "run")) == 2


@pytest.mark.parametrize(
    ("lengths", "found"),
    [
        ([], []),
        ([5], [(0, 1)]),
        ([32, 32, 32, 32], [(0, 2), (2, 4)]),
        ([32, 32, 32], [(0, 3)]),
        ([70, 10, 60, 1], [(0, 1), (1, 4)]),
        ([30, 10, 30, 100], [(0, 3), (3, 4)]),
    ],
)
def test_spans_in_runs(lengths, found):
    assert runs(lengths, 64) == found
