"""A picture of a run that was cut off is rendered again; one that is damaged inside is told with what to do."""

import pytest
from run_folders import pixels

from swimlab.render.plan import make_plan
from swimlab.render.run import render_run
from swimlab.runs.frames import frame_path

WORDS = ("-t", "pixel-point,reference", "--size", "96x54", "--frames", "0-2", "--samples", 4, "-q")
FOLDERS = ("pixel-point", "reference", "error", "geometry")


@pytest.fixture
def run(tmp_path):
    plan = make_plan("road-shift", ["pixel-point", "reference"], size=(96, 54), frames="0-2", samples=4)
    render_run(plan, tmp_path / "run")
    return tmp_path / "run"


@pytest.mark.parametrize("folder", FOLDERS)
@pytest.mark.parametrize("left", [0, 1000, -1])
def test_a_picture_that_was_cut_off_is_rendered_again(swimlab, run, folder, left):
    before, path = pixels(run), frame_path(run, folder, 1)
    others = {each: each.stat().st_mtime_ns for each in run.rglob("*.exr") if each.stem != "0001"}
    path.write_bytes(path.read_bytes()[:left])
    if folder not in ("error", "geometry"):
        assert ": 1 of 6 pictures to render" in swimlab("render", "road-shift", *WORDS, "-o", run, "--dry-run")[1]
    assert swimlab("study", "road-shift", *WORDS, "-o", run)[0] == 0
    assert pixels(run) == before
    assert {each: each.stat().st_mtime_ns for each in others} == others


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_picture_that_is_damaged_inside_is_told_with_what_to_do(swimlab, run, folder):
    path = frame_path(run, folder, 1)
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 64] = bytes(64)
    path.write_bytes(content)
    code, _, err = swimlab("study", "road-shift", *WORDS, "-o", run)
    assert code == 2
    assert f"{path}: is damaged: " in err
    assert "; delete it and give the command that rendered it again" in err
    path.unlink()
    assert swimlab("study", "road-shift", *WORDS, "-o", run)[0] == 0
