"""Frames that are skipped by choice: motion is composed over those between, or what is lacking is said."""

import json

import numpy as np
import pytest
from moving_waves import HEIGHT, WIDTH, write_clips, write_step

from swimlab.footage.motion import UniformMotion
from swimlab.runs.frames import write_channels

COUNT = 12
UNSTEADY = np.cumsum([(0.0, 0.0), *((1 + 0.25 * t, 0.5 - 0.125 * t) for t in range(COUNT - 1))], axis=0)
"""(x, y) px that the picture has moved by in each frame, ever faster to the right."""
STEADY = np.arange(COUNT)[:, None] * np.array([1.25, -0.5])
CHOICES = ["0-11x2", "0,2,4,6,8,10", "0-5,7-11", "1-11x5", "0,3,4,9,11"]


@pytest.fixture(scope="module")
def unsteady(tmp_path_factory):
    folder = tmp_path_factory.mktemp("unsteady")
    write_clips(folder, UNSTEADY)
    return folder


@pytest.mark.parametrize("where", ["option", "pattern"])
@pytest.mark.parametrize("frames", CHOICES)
def test_vectors_are_composed_over_skipped_frames(swimlab, unsteady, frames, where, tolerance):
    own = f"{frames}####.exr" if where == "pattern" else "####.exr"
    names = [f"--{what}={unsteady / name / own}" for what, name in (("test", "glued"), ("reference", "ref"))]
    words = [*names, "--motion", unsteady / "mv" / own, *(["--frames", frames] if where == "option" else [])]
    code, out, err = swimlab("measure", *words, "--json")
    assert code == 0, err
    entry = json.loads(out)["sequences"][0]
    assert entry["scores"]["budget.flicker"] < tolerance("glued") * entry["scores"]["budget.mse"]
    assert entry["motion_check"]["verdict"] == "verified"


@pytest.mark.parametrize("frames", CHOICES)
def test_one_vector_is_that_of_every_frame_though_some_are_skipped(swimlab, tmp_path, frames, tolerance):
    write_clips(tmp_path, STEADY)
    words = ("--test", "glued", "--reference", "ref", "--motion=1.25,-0.5", "--frames", frames, "--json")
    code, out, err = swimlab("measure", *words)
    assert code == 0, err
    scores = json.loads(out)["sequences"][0]["scores"]
    assert scores["budget.flicker"] < tolerance("glued") * scores["budget.mse"]


def test_a_vector_that_is_wrong_is_mended_in_px_a_frame(swimlab, tmp_path):
    write_clips(tmp_path, STEADY)
    words = ("measure", "--test", "glued", "--reference", "ref", "--frames", "0-11x2")
    code, _, err = swimlab(*words, "--motion=2.5,-1")
    assert code == 2
    assert "Use --motion 1.25,-0.5" in err
    code, _, err = swimlab(*words)
    assert code == 2
    assert "content moves by about 1.2" in err


def test_the_step_of_skipped_frames_is_as_many_times_as_long():
    motion = UniformMotion((1.5, -0.25), (4, 4), (3, 5, 7, 8))
    assert motion.step([0, 1, 2]) == (3.0, -0.5)
    assert motion.step([0, 1, 2, 3]) is None
    assert motion.moved(3, 1)[0, 0].tolist() == [4.5, -0.75]


def test_what_is_not_there_between_is_said(swimlab, unsteady, tmp_path):
    """All vectors between are lacking, which is why the motion does not fit; some are; none is, and that is meant."""
    mv = tmp_path / "mv"
    mv.mkdir()
    for t in range(0, COUNT, 2):
        (mv / f"{t:04d}.exr").write_bytes((unsteady / "mv" / f"{t:04d}.exr").read_bytes())
    words = ["measure", "--test", unsteady / "glued", "--reference", unsteady / "ref", "--frames", "0-10x2"]
    code, _, err = swimlab(*words, "--motion", mv, "-q")
    assert code == 2
    assert "frames are skipped (1-9x2), of which there are no motion vectors" in err
    assert "write the vectors of every frame beside them" in err
    (mv / "0003.exr").write_bytes((unsteady / "mv" / "0003.exr").read_bytes())
    code, _, err = swimlab(*words, "--motion", mv, "-q")
    assert code == 2
    assert "0001.exr: is missing" in err
    assert "motion vectors of skipped frames are needed too" in err
    for t in range(2, COUNT, 2):
        write_step(tmp_path / "two" / f"{t:04d}.exr", UNSTEADY[t] - UNSTEADY[t - 2])
    words[-1] = "2-10x2"
    code, _, err = swimlab(*words, "--motion", tmp_path / "two")
    assert code == 0, err
    assert "taken to reach back to the frame measured before" in err


def test_a_masks_frames_between_are_asked_for_too(swimlab, unsteady, tmp_path):
    for t in range(0, COUNT, 2):
        ones = np.ones((HEIGHT, WIDTH, 1), np.float32)
        write_channels(tmp_path / "m" / f"{t:04d}.exr", ones, ("Y",), half=False, metadata={})
    words = ["--test", unsteady / "glued", "--motion", unsteady / "mv", "--frames", "0-10x2"]
    code, _, err = swimlab("measure", *words, "--motion-mask", "m")
    assert code == 2
    assert "--motion-mask m" in err
    assert "give both or none" in err


def test_kept_scores_are_measured_again_when_a_vector_between_changes(swimlab, tmp_path):
    write_clips(tmp_path, STEADY)
    words = ("measure", "--test", "glued", "--motion", "mv", "--frames", "0-10x2", "-o", "run")
    assert swimlab(*words)[0] == 0
    assert "measuring glued" not in swimlab(*words)[2]
    write_step(tmp_path / "mv" / "0003.exr", (1.26, -0.5))
    assert "measuring glued" in swimlab(*words)[2]


def test_a_range_that_cannot_be_read_is_said_once(swimlab, unsteady):
    words = ("measure", "--test", unsteady / "glued", "--reference", unsteady / "ref", "--motion", unsteady / "mv")
    for text, why in (("5-2", "runs backwards; write 2-5"), ("abc", "is no range"), ("0-3,9-7x2", "write 7-9")):
        code, _, err = swimlab(*words, "--frames", text)
        assert code == 2
        assert err.startswith(f"swimlab: --frames: {text} ")
        assert why in err
        assert err.count("\n") == 1
