"""Frames of a test that are shown again, while its reference moves on, or with nothing to hold them against."""

import json

import numpy as np
import pytest
from moving_waves import waves, write_clips, write_picture

from swimlab.footage.check import repeats

COUNT = 12
STEADY = np.arange(COUNT)[:, None] * np.array([1.5, -0.5])
CADENCES = {
    "30 shown at 60": ([0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10], "every 2nd frame", "1-11x2", "0-10x2"),
    "20 shown at 60": ([0, 0, 0, 3, 3, 3, 6, 6, 6, 9, 9, 9], "a frame", "1-2,4-5,7-8,10-11", "0-9x3"),
    "24 shown at 60": ([0, 0, 0, 3, 3, 5, 5, 5, 8, 8, 10, 10], "a frame", "1-2,4,6-7,9,11", "0,3,5,8,10"),
    "one": ([0, 1, 2, 3, 4, 4, 6, 7, 8, 9, 10, 11], "a frame", "5", "0-4,6-11"),
}


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """Folders ref and mv, and a test of each cadence with a glued error."""
    folder = tmp_path_factory.mktemp("clips")
    write_clips(folder, STEADY)
    for name, (shown, *_) in CADENCES.items():
        for t, k in enumerate(shown):
            write_picture(folder / name / f"{t:04d}.exr", waves(STEADY[k], 1) + 0.1 * waves(STEADY[k], 2))
    return folder


@pytest.mark.parametrize("cadence", CADENCES)
@pytest.mark.parametrize("how", ["vector", "fields", "estimate"])
def test_a_test_that_repeats_frames_is_warned_of_and_mended_by_the_others(swimlab, clips, cadence, how, tolerance):
    _, pattern, named, new = CADENCES[cadence]
    motion = {"vector": "1.5,-0.5", "fields": clips / "mv", "estimate": "estimate"}[how]
    words = ("--test", clips / cadence, "--reference", clips / "ref", "--motion", motion, "--json", "-q")
    code, out, err = swimlab("measure", *words)
    assert code == 0, err
    assert f"warning: {pattern} of the test repeats the one before ({named}), while the reference moves on" in err
    assert any("of the test repeats" in text for text in json.loads(out)["sequences"][0]["warnings"])
    assert f"measure the new ones with --frames {new}" in err
    if how == "estimate":
        return
    code, out, err = swimlab("measure", *words, "--frames", new)
    assert code == 0, err
    assert "repeats" not in err
    scores = json.loads(out)["sequences"][0]["scores"]
    assert scores["budget.flicker"] < tolerance("glued") * scores["budget.mse"]


@pytest.mark.parametrize("cadence", CADENCES)
@pytest.mark.parametrize("motion", [(), ("--motion", "estimate")], ids=["none", "estimate"])
def test_repeated_frames_are_warned_of_without_a_motion_or_a_reference(swimlab, clips, cadence, motion):
    _, pattern, named, _ = CADENCES[cadence]
    code, _, err = swimlab("measure", "--test", clips / cadence, *motion, "-q")
    assert code == 0, err
    assert f"{pattern} repeats the one before ({named})" in err
    assert motion or "content moves by about 1." in err


def test_repeats_are_each_builds_own(swimlab, clips):
    builds = ("--build", f"good={clips / 'glued'}", "--build", f"bad={clips / 'one'}")
    code, _, err = swimlab("measure", *builds, "--reference", clips / "ref", "--motion", clips / "mv", "-q")
    assert code == 0, err
    assert "bad: a frame of the test repeats the one before (5)" in err
    assert "good: " not in err


@pytest.mark.parametrize(("looked_at", "told"), [(6, True), (4, False)])
def test_of_a_long_clip_the_middle_tells_whether_all_is_looked_at(swimlab, clips, monkeypatch, looked_at, told):
    """Repeats beside it alone are not found; where it has one all are named."""
    name = "ends"
    for t, k in enumerate([0, 0, 2, 3, 3 if told else 4, 5, 6, 7, 8, 8, 10, 11]):
        write_picture(clips / name / f"{t:04d}.exr", waves(STEADY[k], 1))
    monkeypatch.setattr(repeats, "LOOKED_AT", looked_at)
    words = ("--test", clips / name, "--reference", clips / "ref", "--motion", "1.5,-0.5", "-q")
    code, _, err = swimlab("measure", *words)
    assert code == 0, err
    assert ("of the test repeats the one before (1,4,9)" in err) == told
    assert ("of the test repeats" in err) == told


def test_what_rests_or_repeats_with_its_reference_is_no_fault_of_the_test(swimlab, clips, tmp_path):
    """A still picture whose reference is noisy, a clip that stops, and a reference of the same cadence."""
    random = np.random.default_rng(1)
    rests = [*range(6), *[6] * 6]
    for t in range(COUNT):
        write_picture(tmp_path / "still" / f"{t:04d}.exr", waves(STEADY[0], 1) + 0.2 * (t % 4 == 0))
        noise = 0.05 * random.standard_normal(waves(STEADY[0], 1).shape)
        write_picture(tmp_path / "noisy" / f"{t:04d}.exr", waves(STEADY[0], 1) + noise)
        write_picture(tmp_path / "rests" / f"{t:04d}.exr", waves(STEADY[rests[t]], 1))
    code, _, err = swimlab("measure", "--test", "still", "--reference", "noisy")
    assert code == 0, err
    assert "repeats" not in err
    code, _, err = swimlab("measure", "--test", "rests")
    assert code == 0, err
    assert "repeats" not in err
    same = clips / "one"
    code, _, err = swimlab("measure", "--test", same, "--reference", same, "--motion", clips / "mv", "-q")
    assert code == 0, err
    assert "a frame repeats the one before (5): the motion was checked" in err
    assert "of the test repeats" not in err
