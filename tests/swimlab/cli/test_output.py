"""Where `--output` may be written: it is looked at before anything is measured."""

from pathlib import Path

import numpy as np
import pytest
from moving_waves import waves, write_picture

COUNT = 4


@pytest.fixture
def clips(tmp_path):
    """Folders a and b of still frames, and a shot file of a and b; the working folder."""
    for seed, name in enumerate("ab"):
        for t in range(COUNT):
            write_picture(tmp_path / name / f"{t:04d}.exr", waves(np.zeros(2), seed) + 0.01 * t)
    builds = "".join(f'[builds.{name}]\nframes = "{name}/####.exr"\n' for name in "ab")
    (tmp_path / "shot.toml").write_text(f'version = 1\nname = "still"\n{builds}', encoding="utf-8")
    return tmp_path


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
