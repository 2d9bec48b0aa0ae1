"""Sub-pixel jitter that only the vectors have, or only the frames."""

import json

import numpy as np
import pytest
from moving_wall import COUNT, HEIGHT, WIDTH, moved, picture, write

import swimlab
from swimlab.footage.jitter import JitteredMotion, read_offsets
from swimlab.footage.motion import UniformMotion
from swimlab.runs.frames import FrameError


def halton(index, base):
    share, found = 1.0, 0.0
    while index:
        share /= base
        found += share * (index % base)
        index //= base
    return found


JITTER = np.array([[halton(t + 1, 2) - 0.5, halton(t + 1, 3) - 0.5] for t in range(COUNT)])


def change(t):
    return JITTER[t] - JITTER[t - 1] if t else 0 * JITTER[0]


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """Calm and jittered frames of a wall, vectors without and with the jitter, and the jitter."""
    folder = tmp_path_factory.mktemp("jitter")
    write(folder / "calm", picture)
    write(folder / "jittered", lambda t: picture(t, jitter=JITTER[t]))
    write(folder / "still", lambda t: picture(0))
    write(folder / "mv", moved, ("X", "Y"))
    write(folder / "mv_jittered", lambda t: moved(t) + change(t), ("X", "Y"))
    write(folder / "mv_still", lambda t: np.zeros((HEIGHT, WIDTH, 2)) + change(t), ("X", "Y"))
    half = (WIDTH // 2, HEIGHT // 2)
    write(folder / "mv_half", lambda t: moved(t, half) + change(t), ("X", "Y"))
    (folder / "jitter.txt").write_text("".join(f"{x!r} {y!r}\n" for x, y in JITTER.tolist()))
    return folder


@pytest.fixture
def flicker(swimlab, clips):
    """The share of the picture's energy that flickers; the settings; what was said."""

    def flicker(test, motion, *words):
        motion = clips / motion if (clips / motion).exists() else motion
        code, out, err = swimlab("measure", "--test", clips / test, "--motion", motion, "--json", *words)
        assert code == 0, err
        content = json.loads(out)
        scores = content["sequences"][0]["scores"]
        return scores["residual.flicker"] / np.var(picture(0)), content["provenance"]["settings"], err

    return flicker


TAKEN_OUT = {"moving": ("calm", "mv_jittered"), "at rest": ("still", "mv_still")}


@pytest.mark.parametrize("clip", TAKEN_OUT)
def test_jitter_of_the_vectors_is_taken_out(flicker, clips, clip, tolerance):
    plain = flicker(*TAKEN_OUT[clip], "--motion-unverified")[0]
    found, settings, err = flicker(*TAKEN_OUT[clip], "--motion-jitter", clips / "jitter.txt")
    assert found < tolerance("unwarped glued") < 0.1 * plain
    assert settings["motion_jitter"] == "vectors"
    assert f"jitter of up to {np.abs(JITTER).max():.2g} px is taken out of the motion vectors" in err


@pytest.mark.parametrize("clip", [*TAKEN_OUT.values(), ("jittered", "mv")], ids=[*TAKEN_OUT, "of the frames"])
def test_jitter_is_estimated(flicker, clip, tolerance):
    side = "frames" if clip[0] == "jittered" else "vectors"
    plain = flicker(*clip, "--motion-unverified")[0]
    found, settings, err = flicker(*clip, "--motion-jitter", "estimate", "--motion-jitter-in", side)
    assert found < tolerance("estimated jitter") < plain / 10
    assert settings["motion_jitter"] == f"{side}, estimated"
    assert "px rms is estimated from the frames" in err


def test_jitter_is_in_px_of_the_vectors(flicker, clips, tolerance):
    """Half the size of the frames: a pixel of theirs is two."""
    found, _, err = flicker("calm", "mv_half", "--motion-jitter", clips / "jitter.txt")
    assert found < tolerance("unwarped glued")
    assert "motion verified" in err


@pytest.mark.parametrize("motion", ["mv", "0,0"])
def test_jitter_of_the_frames_is_put_in(flicker, clips, motion, tolerance):
    if motion == "0,0":
        write(clips / "jittered_still", lambda t: picture(0, jitter=JITTER[t]))
    words = ("--motion-jitter", clips / "jitter.txt", "--motion-jitter-in", "frames")
    found, settings, err = flicker("jittered" if motion == "mv" else "jittered_still", motion, *words)
    assert found < tolerance("unwarped glued")
    assert settings["motion_jitter"] == "frames"
    assert "put into the motion" in err


@pytest.mark.parametrize(
    ("test", "motion", "side", "mend"),
    [
        ("jittered", "mv", "vectors", "--motion-jitter-in frames"),
        ("calm", "mv_jittered", "frames", "--motion-jitter-in vectors"),
    ],
)
def test_the_wrong_side_is_refused_by_the_setting_that_mends_it(swimlab, clips, test, motion, side, mend):
    words = ("--motion-jitter", clips / "jitter.txt", "--motion-jitter-in", side)
    code, _, err = swimlab("measure", "--test", clips / test, "--motion", clips / motion, *words)
    assert code == 2
    assert f"Use {mend}, or" in err


def test_steps_add_up_over_frames_that_are_left_out(tolerance):
    offsets = np.array([[0.5, 0.0], [-0.25, 0.25], [0.125, -0.5]])
    inner = UniformMotion((2.0, 1.0), (4, 5))
    points = np.array([[3.0, 2.0], [1.0, 4.0]])
    for side, sign in (("frames", 1), ("vectors", -1)):
        motion = JitteredMotion(inner, offsets, side)
        dx, dy = np.array([4.0, 2.0]) + sign * (offsets[2] - offsets[0])
        assert np.abs(motion.back(points, 2, 0) - (points - [[dy], [dx]])).max() < tolerance("closed form")
        assert np.allclose(motion.moved(2, 0), [dx, dy])


FORMS = {
    "blanks": "0.5 -0.25\n0 0.125\n",
    "commas": "0.5,-0.25\n0,0.125\n",
    "numbered": "8 0 .125\n7 .5 -.25\n9 1 1\n",
    "semicolons and names": "Frame; Jitter X; jitter_y\n7;0.5;-0.25;\n8;0;0.125;\n",
    "comments": "# px\n\n0.5, -0.25  # first\n0\t0.125\n\n",
}


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"], ids=["", "BOM"])
@pytest.mark.parametrize("form", FORMS)
def test_files_of_jitter_are_read_in_many_forms(tmp_path, form, mark, end):
    file = tmp_path / "jitter.csv"
    file.write_bytes((mark + FORMS[form].replace("\n", end)).encode())
    assert read_offsets(file, (7, 8)).tolist() == [[0.5, -0.25], [0, 0.125]]


FAULTS = {
    "too few": ("0 0\n", "has 1 line for 2 frames"),
    "too many": ("0 0\n0 0\n0 0\n", "has 3 lines for 2 frames"),
    "a word": ("0 0\n0 zero\n", "line 2: zero is not a number"),
    "not finite": ("0 0\n0 nan\n", "line 2: nan is not a number"),
    "one value": ("# x\n1\n2\n", "line 2: has 1 value"),
    "four values": ("1 2 3 4\n", "line 1: has 4 values"),
    "an empty value": ("7,,0\n8,0,0\n", "line 1: an empty value is not a number"),
    "mixed": ("7 0 0\n0 0\n", "line 2: has 2 values"),
    "another frame": ("7 0 0\n9 0 0\n", "has no line for frame 8, 1 missing"),
    "a frame twice": ("7 0 0\n7 1 1\n", "line 2: frame 7 comes twice"),
    "half a frame": ("7.5 0 0\n8 1 1\n", "line 1: 7.5 is no frame number"),
    "other columns": ("y,x\n0,0\n0,0\n", "line 1: its columns are y, x"),
    "two lines of names": ("x,y\nx,y\n0,0\n0,0\n", "line 2: x is not a number"),
    "nothing": ("# frame,x,y\n", "has no lines"),
    "no text": (b"\xff\xfe\x00\x81", "cannot be read"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_what_is_wrong_with_a_file_of_jitter_is_named(tmp_path, fault):
    content, said = FAULTS[fault]
    file = tmp_path / "jitter.csv"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(FrameError, match=r"--motion-jitter .*jitter\.csv") as raised:
        read_offsets(file, (7, 8))
    assert said in str(raised.value)


REFUSED = {
    "a missing file": (("--motion", "mv", "--motion-jitter", "none.txt"), "none.txt: cannot be read"),
    "a vector's own": (("--motion", "1,2", "--motion-jitter", "jitter.txt"), "give --motion-jitter-in frames"),
    "an estimate": (("--motion", "estimate", "--motion-jitter", "jitter.txt"), "--motion-jitter: is for a motion that"),
    "a side alone": (("--motion", "mv", "--motion-jitter-in", "frames"), "give --motion-jitter FILE or estimate too"),
    "no motion": (("--motion-jitter", "jitter.txt"), "--motion-jitter: is for a motion that is given"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_jitter_of_no_use_is_refused(swimlab, clips, monkeypatch, case):
    words, said = REFUSED[case]
    monkeypatch.chdir(clips)
    code, _, err = swimlab("measure", "--test", "calm", *words)
    assert code == 2
    assert said in err


def test_masks_and_jitter_from_python(clips, tmp_path, tolerance):
    valid = np.ones((HEIGHT, WIDTH, 1))
    valid[:9] = 0
    mask = write(tmp_path / "valid", lambda t: valid, ("Y",)) / "0000.exr"
    words = {"motion_jitter": clips / "jitter.txt", "motion_mask": mask}
    found = swimlab.measure_frames(clips / "calm", motion=clips / "mv_jittered", **words)
    entry = found.content["sequences"][0]
    assert entry["scores"]["residual.flicker"] < tolerance("unwarped glued") * np.var(picture(0))
    assert any(f"{9 / HEIGHT:.2%} of the pixels" in note for note in found.notes)
