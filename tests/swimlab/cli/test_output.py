"""Where `--output` may be written: it is looked at before anything is measured, and no other run is lost."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from moving_waves import waves, write_picture

COUNT = 4


@pytest.fixture
def clips(tmp_path):
    """Folders a, b and c of still frames, and a shot file of a and b; the working folder."""
    for seed, name in enumerate("abc"):
        for t in range(COUNT):
            write_picture(tmp_path / name / f"{t:04d}.exr", waves(np.zeros(2), seed) + 0.01 * t)
    builds = "".join(f'[builds.{name}]\nframes = "{name}/####.exr"\n' for name in "ab")
    (tmp_path / "shot.toml").write_text(f'version = 1\nname = "still"\n{builds}', encoding="utf-8")
    return tmp_path


def scores(folder):
    content = json.loads((Path(folder) / "scores.json").read_text(encoding="utf-8"))
    return {entry["technique"]: entry["scores"]["residual.flicker"] for entry in content["sequences"]}


def test_scores_of_other_frames_are_not_written_over(swimlab, clips):
    assert swimlab("measure", "--test", "a", "-o", "run", "-q")[0] == 0
    before = scores("run")
    code, _, err = swimlab("measure", "--test", "b", "-o", "run", "-q")
    assert code == 2
    assert "--output run: holds scores of test of other frames" in err
    assert "choose another folder with -o, or write over it with --force" in err
    assert scores("run") == before
    assert swimlab("measure", "--test", "b", "-o", "run", "-q", "--force")[0] == 0
    assert swimlab("measure", "--test", "b", "-o", "run", "-q")[0] == 0


def test_builds_that_are_not_named_again_are_not_lost(swimlab, clips):
    assert swimlab("measure", "shot.toml", "-o", "run", "-q")[0] == 0
    code, _, err = swimlab("measure", "--build", "a=a", "-o", "run", "-q")
    assert code == 2
    assert "holds scores of b too" in err
    assert list(scores("run")) == ["a", "b"]
    shot = (clips / "shot.toml").read_text(encoding="utf-8")
    (clips / "shot.toml").write_text(shot.replace("b/####", "c/####"), encoding="utf-8")
    code, _, err = swimlab("measure", "shot.toml", "-o", "run", "-q")
    assert code == 2
    assert "holds scores of b of other frames" in err


def test_the_same_frames_are_measured_again_and_builds_are_added(swimlab, clips):
    assert swimlab("measure", "--build", "a=a", "-o", "run", "-q")[0] == 0
    first = scores("run")
    assert swimlab("measure", "--build", "a=a", "--build", "b=b", "-o", "run", "-q")[0] == 0
    assert scores("run")["a"] == first["a"]
    write_picture(clips / "a" / "0002.exr", waves(np.zeros(2), 0) + 0.3)
    assert swimlab("measure", "shot.toml", "-o", "run", "-q", "--domain", "display")[0] == 0
    assert swimlab("measure", "shot.toml", "-o", "run", "-q")[0] == 0
    assert scores("run")["a"] > first["a"]
    assert swimlab("measure", "run", "-o", "run", "-q")[0] == 0


def test_frames_that_were_moved_are_the_same(swimlab, clips):
    assert swimlab("measure", "shot.toml", "-o", "run", "-q")[0] == 0
    (clips / "there").mkdir()
    for name in ("a", "b", "shot.toml"):
        shutil.move(clips / name, clips / "there" / name)
    assert swimlab("measure", "there/shot.toml", "-o", "run", "-q")[0] == 0


def test_a_copy_of_scores_takes_the_place_of_no_others(swimlab, clips):
    assert swimlab("measure", "shot.toml", "-o", "run", "-q")[0] == 0
    assert swimlab("measure", "--test", "c", "-o", "other", "-q")[0] == 0
    code, _, err = swimlab("measure", "run", "-o", "other", "-q")
    assert code == 2
    assert "--output other: holds another run" in err
    for _ in range(2):
        assert swimlab("measure", "run", "-o", "copy", "-q")[0] == 0
    code, _, err = swimlab("measure", "other", "-o", "copy", "-q")
    assert code == 2
    assert "holds the scores of still" in err
    code, _, err = swimlab("measure", "--test", "a", "-o", "copy", "-q")
    assert code == 2
    assert "holds scores of other runs" in err


@pytest.mark.parametrize("output", ["file/run", "file/deep/run", "file/scores.json", "folder.json"])
@pytest.mark.parametrize("command", ["brought", "shot", "run"])
def test_an_output_that_cannot_be_written_is_told_before_measuring(swimlab, clips, monkeypatch, output, command):
    (clips / "file").write_text("", encoding="utf-8")
    (clips / "folder.json").mkdir()
    if command == "run":
        assert swimlab("measure", "shot.toml", "-o", "run", "-q")[0] == 0
    monkeypatch.setattr("swimlab.footage.opened.open_frames", None)  # nothing is opened
    words = {"brought": ("--test", "a"), "shot": ("shot.toml",), "run": ("run",)}[command]
    code, _, err = swimlab("measure", *words, "-o", output)
    assert code == 2
    assert err.startswith(f"swimlab: --output {output}: ")
    assert "file, not a folder" in err or "is a folder" in err
    assert err.count("\n") == 1


def test_an_output_in_a_folder_without_leave_is_told(swimlab, clips, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "touch", refuse)
    for words in (("measure", "--test", "a"), ("study", "shot.toml")):
        code, _, err = swimlab(*words, "-o", "run/mine")
        assert code == 2
        assert err == "swimlab: --output run/mine: cannot be written: Permission denied; name another place with -o\n"


def test_nothing_is_left_of_looking_whether_an_output_can_be_written(swimlab, clips):
    there = {path.name for path in clips.iterdir()}
    assert swimlab("measure", "--test", "nothing", "-o", "new/run")[0] == 2
    assert {path.name for path in clips.iterdir()} == there
