"""`swimlab measure --test` and `swimlab info` on files, as a user types them."""

import json

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from swimlab.runs.frames import write_channels

WIDTH, HEIGHT, COUNT = 96, 64, 12
VELOCITY = (-1.25, 0.625)
MOTION = f"--motion={VELOCITY[0]},{VELOCITY[1]}"


def waves(t, seed, velocity=VELOCITY, size=(HEIGHT, WIDTH)):
    """[H, W, 3]: a band-limited picture that has moved for t frames, rms 1."""
    random = np.random.default_rng(seed)
    y, x = np.indices(size) + 0.5
    x, y = x - t * velocity[0], y - t * velocity[1]
    kx, ky = random.uniform(-0.2, 0.2, (2, 16))
    angle = 2 * np.pi * (x[..., None] * kx + y[..., None] * ky) + random.uniform(0, 6, 16)
    return np.repeat(np.cos(angle).sum(axis=2)[..., None] * np.sqrt(2 / 16), 3, axis=2)


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """A folder with ref, glued, blink and mv (motion.X, motion.Y), frames 1001 to 1012."""
    folder = tmp_path_factory.mktemp("clips")
    for t in range(COUNT):
        pictures = {
            "ref": 3 + waves(t, 1),
            "glued": 3 + waves(t, 1) + 0.1 * waves(t, 2),
            "blink": 3 + waves(t, 1) + 0.1 * (-1) ** t * waves(t, 2),
        }
        for name, pixels in pictures.items():
            path = folder / name / f"{name}.{1001 + t}.exr"
            write_channels(path, pixels.astype(np.float32), ("R", "G", "B"), half=False, metadata={})
        field = np.broadcast_to(np.float32(VELOCITY), (HEIGHT, WIDTH, 2))
        write_channels(folder / "mv" / f"mv.{1001 + t}.exr", field, ("motion.X", "motion.Y"), half=False, metadata={})
    return folder


@pytest.fixture
def measure(swimlab, clips):
    """Measure with --json: the scores file's content and standard error."""

    def measure(test, *words):
        code, out, err = swimlab("measure", "--test", clips / test / f"{test}.####.exr", *words, "--json")
        assert code == 0, err
        return json.loads(out), err

    return measure


@pytest.mark.parametrize("how", ["vector", "fields"])
def test_a_glued_error_has_no_flicker_and_a_blinking_one_has_all(measure, clips, how, tolerance):
    motion = [MOTION] if how == "vector" else ["--motion", clips / "mv"]
    for test, flickers in (("glued", False), ("blink", True)):
        scores = measure(test, "--reference", clips / "ref", *motion, "--fps", "30")[0]["sequences"][0]["scores"]
        share = scores["budget.flicker"] / scores["budget.mse"]
        assert share > 1 - tolerance("glued") if flickers else share < tolerance("glued")
        parts = scores["budget.bias"] + scores["budget.detail"] + scores["budget.flicker"]
        assert parts == pytest.approx(scores["budget.mse"], rel=tolerance("budget"))


@pytest.mark.parametrize("kind", ["screen-fixed", "swimming", "noise"])
def test_what_moves_against_the_surface_is_flicker(swimlab, tmp_path, kind, tolerance):
    random = np.random.default_rng(4)
    size = (128, 160)
    for t in range(24):
        reference = 3 + waves(t, 1, size=size)
        error = {
            "screen-fixed": lambda: waves(0, 2, size=size),
            "swimming": lambda t=t: waves(t, 2, (0.75, -1.5), size=size),
            "noise": lambda: random.standard_normal((*size, 3)),
        }[kind]()
        for name, pixels in (("ref", reference), ("test", reference + 0.1 * error)):
            path = tmp_path / name / f"{t:04d}.exr"
            write_channels(path, pixels.astype(np.float32), ("R", "G", "B"), half=False, metadata={})
    code, out, err = swimlab("measure", "--test", "test", "--reference", "ref", MOTION, "--json", "-q")
    assert code == 0, err
    scores = json.loads(out)["sequences"][0]["scores"]
    assert scores["budget.flicker"] > tolerance("moving") * scores["budget.mse"]


def test_what_moves_otherwise_is_left_out_by_its_alpha(swimlab, clips, tmp_path, tolerance):
    """An opaque patch crosses the picture; behind it, and beside it, a glued error stays one."""
    for t in range(COUNT):
        patch = np.zeros((HEIGHT, WIDTH), dtype=bool)
        patch[40:52, 8 + 3 * t : 24 + 3 * t] = True
        pixels = np.ones((HEIGHT, WIDTH, 4), np.float32)
        pixels[..., :3] = 3 + waves(t, 1) + 0.1 * waves(t, 2)
        pixels[patch] = [9, (-1) ** t, 9, 0]
        write_channels(tmp_path / "p" / f"{t:04d}.exr", pixels, tuple("RGBA"), half=False, metadata={})
    words = ("measure", "--test", "p", "--reference", clips / "ref", MOTION, "--json", "-q")
    found = {}
    for alpha in ("ignore", "mask"):
        code, out, err = swimlab(*words, "--alpha", alpha)
        assert code == 0, err
        found[alpha] = json.loads(out)["sequences"][0]["scores"]
    assert found["ignore"]["budget.flicker"] > found["mask"]["budget.mse"]
    assert found["mask"]["budget.flicker"] < tolerance("glued") * found["mask"]["budget.mse"]
    assert found["mask"]["budget.mse"] == pytest.approx(0.01, rel=tolerance("part of a picture"))
    assert 0 < found["mask"]["measured.fraction"] < found["ignore"]["measured.fraction"]


def test_scores_have_the_form_of_a_run_and_say_how_they_were_made(measure, clips):
    content, err = measure("glued", MOTION, "--fps", "30", "--frames", "1002-1009")
    assert content["version"] == 1
    about = content["provenance"]
    assert (about["domain"], about["settings"]["fps"], about["settings"]["count"]) == ("linear", 30, 8)
    entry = content["sequences"][0]
    assert (entry["sequence"], entry["technique"], entry["motion"]) == ("glued", "test", "uniform")
    assert [row["frame"] for row in entry["frames"]] == list(range(1002, 1010))
    assert entry["absent"]["budget.mse"] == "needs a reference"
    assert "residuals: as given 0.0" in err
    assert "residuals: as given 0.0" in " ".join(entry["notes"])
    other = measure("glued", MOTION, "--fps", "24", "--frames", "1002-1009")[0]
    assert other["provenance"]["hash"] != about["hash"]


def test_the_table_and_the_file(swimlab, clips, tmp_path):
    words = ("measure", "--test", clips / "glued", MOTION, "--reference", clips / "ref")
    code, out, err = swimlab(*words, "-o", "out/scores.json")
    assert code == 0
    assert "glued, linear" in out
    assert "rms error" in out
    assert "verified" in err
    assert out.endswith("out/scores.json\n")
    scores = json.loads((tmp_path / "out" / "scores.json").read_text())
    assert "budget.mse" in scores["sequences"][0]["scores"]
    code, out, err = swimlab(*words, "-q")
    assert (code, err) == (0, "")


def test_vectors_under_another_convention(measure, clips, tmp_path, tolerance):
    for t in range(COUNT):
        field = np.zeros((HEIGHT, WIDTH, 4), np.float32)
        field[..., :2] = np.float32(VELOCITY) * [-1, 1]
        names = tuple(f"View.Vector.{c}" for c in "XYZW")
        write_channels(tmp_path / "v" / f"{t:04d}.exr", field, names, half=False, metadata={})
    words = ("--reference", clips / "ref", "--motion", tmp_path / "v", "--motion-convention", "blender")
    content, err = measure("glued", *words)
    scores = content["sequences"][0]["scores"]
    assert scores["budget.flicker"] < tolerance("glued") * scores["budget.mse"]
    assert "motion frames 0-11 go with test frames 1001-1012, in order" in err
    assert "motion from View.Vector.X,View.Vector.Y: px, backward, +y up, scale -1,-1" in err


def test_estimated_motion_is_labelled(measure):
    entry = measure("glued", "--motion", "estimate", "--frames", "1001-1004")[0]["sequences"][0]
    assert entry["motion"] == "estimated"
    assert any("estimated" in note for note in entry["notes"])


def test_bad_frames_can_be_left_out_and_that_is_recorded(swimlab, clips, tmp_path, tolerance):
    """A gap, a NaN and a frame of another size: what is left is aligned over the holes."""
    for t in range(COUNT):
        pixels = (3 + waves(t, 1) + 0.1 * waves(t, 2)).astype(np.float32)
        if t == 3:
            pixels[5, 7] = np.nan
        pixels = pixels[:-2] if t == 8 else pixels
        if t != 6:
            write_channels(tmp_path / "t" / f"t.{1001 + t}.exr", pixels, ("R", "G", "B"), half=False, metadata={})
    words = ("measure", "--test", tmp_path / "t", "--reference", clips / "ref", "--json")
    for motion in (MOTION, f"--motion={clips / 'mv'}"):
        code, out, err = swimlab(*words, motion, "--skip-bad-frames")
        assert code == 0
        assert "3 bad frames are left out: 1004,1007,1009" in err
        entry = json.loads(out)["sequences"][0]
        assert any("3 bad frames are left out" in note for note in entry["notes"])
        assert json.loads(out)["provenance"]["settings"]["skip_bad_frames"] is True
        assert {row["frame"] for row in entry["frames"]} == set(range(1001, 1013)) - {1004, 1007, 1009}
        assert entry["scores"]["budget.flicker"] < tolerance("glued") * entry["scores"]["budget.mse"]


def test_mask_and_crop_leave_out_what_is_not_asked_for(swimlab, clips, tmp_path, tolerance):
    """A watermark fixed to the screen is all the error there is outside the mask."""
    marked = tmp_path / "marked"
    for t in range(COUNT):
        pixels = 3 + waves(t, 1) + 0.1 * waves(t, 2)
        pixels[:, 80:] = 9
        write_channels(marked / f"{t:04d}.exr", pixels.astype(np.float32), ("R", "G", "B"), half=False, metadata={})
    mask = np.ones((HEIGHT, WIDTH, 1), np.float32)
    mask[:, 80:] = 0
    write_channels(tmp_path / "mask.exr", mask, ("Y",), half=False, metadata={})
    words = ("measure", "--test", marked, "--reference", clips / "ref", MOTION, "--json")
    flicker = {}
    for name, choice in {"all": (), "mask": ("--mask", "mask.exr"), "crop": ("--crop", "0,0,80,64")}.items():
        code, out, _ = swimlab(*words, *choice)
        assert code == 0
        flicker[name] = json.loads(out)["sequences"][0]["scores"]["budget.flicker"]
    assert flicker["all"] > 0.1
    assert max(flicker["mask"], flicker["crop"]) < tolerance("glued") * 0.01
    assert json.loads(out)["provenance"]["settings"]["size"] == [80, 64]


@pytest.mark.parametrize(("kind", "suffix"), [(oiio.UINT8, "png"), (oiio.HALF, "exr")])
def test_quantisation_is_a_score_beside_the_flicker_it_makes(swimlab, tmp_path, kind, suffix):
    for t in range(6):
        pixels = (0.5 + 0.1 * waves(t, 1)).astype(np.float32)
        spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, kind)
        output = oiio.ImageOutput.create(str(tmp_path / f"q.{t:04d}.{suffix}"))
        assert output.open(str(tmp_path / f"q.{t:04d}.{suffix}"), spec)
        assert output.write_image(pixels)
        output.close()
    words = ("measure", "--test", f"q.####.{suffix}", MOTION, "--colorspace", "linear", "--json")
    code, out, err = swimlab(*words)
    assert code == 0
    assert "quantisation alone makes a flicker of" in err
    scores = json.loads(out)["sequences"][0]["scores"]
    assert 0.3 < scores["residual.flicker"] / scores["quantisation.floor"] < 1.5


def test_lossy_compression_is_warned_of(swimlab, tmp_path):
    for t in range(3):
        spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, oiio.HALF)
        spec.attribute("compression", "dwaa")
        output = oiio.ImageOutput.create("exr")
        assert output.open(str(tmp_path / f"l.{t:04d}.exr"), spec)
        assert output.write_image((3 + waves(t, 1)).astype(np.float32))
        output.close()
    code, out, err = swimlab("measure", "--test", "l.#.exr", MOTION, "--json")
    assert code == 0
    assert "dwaa compression is lossy" in err
    assert any("lossy" in note for note in json.loads(out)["sequences"][0]["notes"])
    assert "dwaa; lossy" in swimlab("info", "l.#.exr")[1]


def test_info_says_what_frames_were_taken_for(swimlab, clips, tmp_path):
    code, out, _ = swimlab("info", clips / "mv" / "mv.####.exr")
    assert code == 0
    for words in ("12, 1001-1012", "96x64", "motion.X, motion.Y; float", "zip", "--motion-convention own"):
        assert words in out
    for t in (1, 2, 4):
        write_channels(
            tmp_path / f"a.{t:04d}.exr", np.ones((4, 5, 4), np.float32), tuple("RGBA"), half=True, metadata={}
        )
    code, out, _ = swimlab("info", ".")
    assert code == 2
    for words in ("4, 1-4", "R, G, B, A; half", "taken as linear", "A, premultiplied", "a.0003.exr: is missing"):
        assert words in out


def test_info_finds_frames_that_are_cut_short(swimlab, tmp_path):
    """Wherever their data is cut: the end of the file is read too."""
    random = np.random.default_rng(0)
    for kept in (0.2, 0.7, 0.99):
        for t in range(3):
            pixels = random.random((HEIGHT, WIDTH, 3)).astype(np.float32)
            write_channels(tmp_path / f"cut.{t:04d}.exr", pixels, ("R", "G", "B"), half=False, metadata={})
        assert swimlab("info", "cut.####.exr")[0] == 0
        path = tmp_path / "cut.0001.exr"
        path.write_bytes(path.read_bytes()[: int(kept * path.stat().st_size)])
        code, out, _ = swimlab("info", "cut.####.exr")
        assert code == 2
        assert "bad frame   cut.0001.exr: is damaged" in out
        assert "cut.0000.exr: " not in out
        code, out, _ = swimlab("info", "cut.####.exr", "--json")
        assert code == 2
        assert len(json.loads(out)["bad frames"]) == 1
        code, _, err = swimlab("measure", "--test", "cut.####.exr")
        assert code == 2
        assert "cut.0001.exr: is damaged" in err
        assert "--skip-bad-frames" in err


def test_output_is_a_folder_as_of_a_run(swimlab, clips, tmp_path):
    words = ("measure", "--test", clips / "glued", MOTION, "--reference", clips / "ref", "-q")
    for folder in ("before", "after.v2"):
        code, out, _ = swimlab(*words, "-o", folder)
        assert code == 0
        assert out.endswith(f"{folder}/scores.json\n")
        assert (tmp_path / folder / "frames.csv").read_text().startswith("sequence,technique,frame")
    code, out, _ = swimlab("info", "before")
    assert code == 0
    for words_there in ("scores of   glued, frames 1001-1012, linear: test", "verified by warping"):
        assert words_there in out
    assert out.endswith(swimlab("info", "before/scores.json")[1])
    assert json.loads(swimlab("info", "before", "--json")[1])["inputs"]["test"]["name"] == str(clips / "glued")
    code, out, err = swimlab("compare", "before", "after.v2")
    assert (code, err) == (0, "")
    assert "9 same" in out
    (tmp_path / "file").write_text("")
    code, _, err = swimlab(*words, "-o", "file")
    assert code == 2
    assert "--output file: is a file" in err


def test_what_is_not_measured_is_said_with_its_reason(measure):
    err = measure("glued")[1]
    assert "no budget: needs a reference" in err
    assert "no visible: needs --pixels-per-degree" in err
    assert err.count("no motion given: nothing is taken to move") == 1


def test_doubtful_motion_is_said_even_quietly(swimlab, tmp_path):
    for t in range(6):
        noise = 3 + np.random.default_rng(t).standard_normal((HEIGHT, WIDTH, 3))
        path = tmp_path / f"n.{t:04d}.exr"
        write_channels(path, noise.astype(np.float32), ("R", "G", "B"), half=False, metadata={})
    code, out, err = swimlab("measure", "--test", "n.####.exr", MOTION, "-q", "--json")
    assert code == 0
    assert err.startswith("swimlab: warning: motion not verified")
    assert err.count("\n") == 1
    assert any("motion not verified" in note for note in json.loads(out)["sequences"][0]["notes"])
