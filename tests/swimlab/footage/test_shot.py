"""Shot files and the run folders that are made of them, as a user types them."""

import json
import os
import shutil

import numpy as np
import pytest

from sequences import SequenceError
from swimlab.footage.shot import is_shot, load_shot
from swimlab.notebook.study import open_run
from swimlab.runs.frames import write_channels

WIDTH, HEIGHT, COUNT = 64, 64, 6
SHOT = """
version = 1
name = "corridor"
fps = 30
[reference]
frames = "ref/f.####.exr"
[motion]
velocity = [-1.25, 0.625]
[builds.glued]
frames = "glued/f.####.exr"
[builds.blink]
frames = "blink/f.####.exr"
"""


def waves(t, seed):
    """[H, W, 3]: a band-limited picture that has moved by (-1.25, 0.625) px a frame."""
    random = np.random.default_rng(seed)
    y, x = np.indices((HEIGHT, WIDTH)) + 0.5
    kx, ky = random.uniform(-0.2, 0.2, (2, 16))
    angle = 2 * np.pi * ((x + 1.25 * t)[..., None] * kx + (y - 0.625 * t)[..., None] * ky) + random.uniform(0, 6, 16)
    return np.repeat(np.cos(angle).sum(axis=2)[..., None] * np.sqrt(2 / 16), 3, axis=2)


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shot")
    for t in range(COUNT):
        true, error = 3 + waves(t, 1), 0.1 * waves(t, 2)
        for name, pixels in {"ref": true, "glued": true + error, "blink": true + (-1) ** t * error}.items():
            path = folder / name / f"f.{t:04d}.exr"
            write_channels(path, pixels.astype(np.float32) / 8, ("R", "G", "B"), half=False, metadata={})
    (folder / "shot.toml").write_text(SHOT, encoding="utf-8")
    return folder


@pytest.fixture
def shot(frames, tmp_path):
    """A folder of one's own with the frames and the shot file."""
    return shutil.copytree(frames, tmp_path / "shot")


@pytest.fixture
def run(swimlab, shot):
    code, _, err = swimlab("study", shot / "shot.toml", "-o", shot / "run", "-q")
    assert code == 0, err
    return shot / "run"


def entries(run):
    content = json.loads((run / "scores.json").read_text(encoding="utf-8"))
    return {entry["technique"]: entry for entry in content["sequences"]}


def test_a_motion_that_does_not_fit_is_a_warning_of_every_build(swimlab, shot):
    text = SHOT.replace("velocity = [-1.25, 0.625]", "velocity = [1.25, -0.625]\nunverified = true")
    (shot / "shot.toml").write_text(text, encoding="utf-8")
    (shot / "gate.toml").write_text('version = 1\n[[rule]]\nmetric = "budget.mse"\nmax = 1\n', encoding="utf-8")
    assert swimlab("study", shot / "shot.toml", "-o", shot / "run", "-q")[0] == 0
    warned = [entry["warnings"] for entry in entries(shot / "run").values()]
    assert warned[0] == warned[1]
    code, out, _ = swimlab("gate", shot / "gate.toml", shot / "run")
    assert code == 0
    assert "warning: glued, blink on corridor: motion not verified: " in out


def test_every_mistake_is_told_at_once_with_its_key_and_a_hint(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(
        'version = 1\nname = "a b"\nframes = "7-q"\n[reference]\nframse = "x"\n[motion]\nvelocity = [1.0, 2.0]\n'
        'estimate = true\n[builds.reference]\nframes = "x"\n[builds.b]\nframes = "y"\ncolourspace = "srgb"\n',
        encoding="utf-8",
    )
    with pytest.raises(SequenceError) as caught:
        load_shot(path)
    said = str(caught.value)
    for part in (
        "name: ",
        "frames: frames: 7-q is no range",
        "reference.framse: unknown key (did you mean 'frames'?",
        "motion: give one of frames, velocity and estimate = true, not velocity and estimate",
        "builds.reference: 'reference' is what a run calls a part of its own",
        "builds.b.colourspace: unknown key (did you mean 'colorspace'?",
    ):
        assert part in said
    assert all(line.startswith(f"{path}: ") for line in said.splitlines())


def test_a_sequence_file_is_no_shot_file(tmp_path):
    path = tmp_path / "road.toml"
    path.write_text('version = 1\nname = "road"\n[motion]\nkind = "shift"\n', encoding="utf-8")
    assert not is_shot(path)
    assert not is_shot("road-shift")


def test_builds_measured_together_score_as_each_alone(swimlab, shot, run):
    together = entries(run)
    for name in ("glued", "blink"):
        words = ("--test", shot / name, "--name", name, "--reference", shot / "ref", "--motion=-1.25,0.625")
        code, out, err = swimlab("measure", *words, "--fps", "30", "--sequence", "corridor", "--json", "-q")
        assert code == 0, err
        content = json.loads(out)
        alone = content["sequences"][0]
        for key in ("scores", "errors", "frames", "sequence", "technique", "motion_check"):
            assert together[name][key] == alone[key]
        assert together[name]["hash"] == content["provenance"]["hash"]


def test_the_run_folder_serves_every_command(swimlab, shot, run):
    for words in (("report", run), ("info", run), ("compare", run, run), ("measure", run, "-q")):
        code, _, err = swimlab(*words)
        assert code == 0, err
    page = (run / "report.html").read_text(encoding="utf-8")
    assert all(name in page for name in ("corridor", "glued", "blink"))
    gate = shot / "gate.toml"
    rule = '[[rule]]\nmetric = "budget.flicker"\n'
    gate.write_text(f'version = 1\n[baseline]\nfile = "base.json"\n{rule}max_increase = "5%"\n', encoding="utf-8")
    assert swimlab("baseline", "update", gate, run)[0] == 0
    assert swimlab("gate", gate, run)[0] == 0
    gate.write_text(f"version = 1\n{rule}max = 1e-6\n", encoding="utf-8")
    assert swimlab("gate", gate, run)[0] == 1
    assert [path.name for path in (run / "gate").iterdir()] == ["corridor-blink-budget.flicker.png"]


def test_the_short_form_writes_the_same_folder(swimlab, shot, run):
    words = ["--build", f"glued={shot / 'glued'}", "--build", f"blink={shot / 'blink'}", "--reference", shot / "ref"]
    words += ["--motion=-1.25,0.625", "--fps", "30", "--sequence", "corridor", "-o", shot / "short", "-q"]
    code, _, err = swimlab("measure", *words)
    assert code == 0, err
    assert {n: e["scores"] for n, e in entries(shot / "short").items()} == {
        n: e["scores"] for n, e in entries(run).items()
    }
    assert swimlab("report", shot / "short")[0] == 0


def test_the_report_speaks_of_builds_and_says_where_their_frames_are(run):
    page = (run / "report.html").read_text(encoding="utf-8")
    assert "Which build should I ship" in page
    assert "brought frames are where they were measured, in files that run.json names." in page
    assert "in the run folder" not in page


def test_sources_that_moved_or_changed_are_told_by_name(swimlab, shot, run):
    moved = shot / "blink" / "f.0003.exr"
    kept = moved.read_bytes()
    moved.unlink()
    code, _, err = swimlab("report", run)
    assert code == 2
    assert f"{moved}: is gone since it was measured (blink)" in err
    moved.write_bytes(kept)
    os.utime(moved, ns=(1, 1))  # the same bytes at another time are the same
    assert swimlab("report", run)[0] == 0
    moved.write_bytes(kept[:-1] + bytes([kept[-1] ^ 1]))
    code, _, err = swimlab("report", run)
    assert (code, f"{moved}: has changed" in err) == (2, True)


def test_without_a_reference_the_report_shows_what_it_can(swimlab, shot):
    path = shot / "bare.toml"
    path.write_text(SHOT.replace('[reference]\nframes = "ref/f.####.exr"\n', ""), encoding="utf-8")
    code, _, err = swimlab("study", path, "-t", "blink", "-o", shot / "bare", "-q")
    assert code == 0, err
    assert list(entries(shot / "bare")) == ["blink"]
    assert (shot / "bare" / "report.html").is_file()


def test_notebooks_open_it(shot, run):
    opened = open_run(run)
    assert opened.techniques == ("blink", "glued", "reference")
    assert opened.frame("glued").shape == (HEIGHT, WIDTH, 4)
    clip, exact = opened.clip("glued"), opened.clip("reference")
    assert clip.motion == exact.motion == (-1.25, 0.625)
    assert np.array_equal(exact.frame(2), opened.frame("reference", 2)[..., :3])


def test_a_gate_fixture_measures_a_shot(shot, swimlab_gate):
    gate = shot / "gate.toml"
    gate.write_text('version = 1\n[[rule]]\nmetric = "budget.flicker"\nmax = 1e-6\n', encoding="utf-8")
    assert swimlab_gate(shot / "shot.toml", gate, techniques=["glued"]).exit_code == 0


def test_a_rendered_run_is_not_written_over(swimlab, shot):
    (shot / "road").mkdir()
    record = {"sequence": {}, "settings": {}, "hash": "", "uniform_velocity": None, "resizes": False, "provenance": {}}
    (shot / "road" / "run.json").write_text(json.dumps({"version": 1, **record}), encoding="utf-8")
    code, _, err = swimlab("study", shot / "shot.toml", "-o", shot / "road")
    assert (code, "holds a rendered run" in err) == (2, True)
    code, _, err = swimlab("study", shot / "shot.toml", "--size", "64x64", "-o", shot / "run")
    assert (code, "--size: is for rendering" in err) == (2, True)


def test_a_drafted_shot_file_is_measured_as_it_is(swimlab, shot):
    (shot / "shot.toml").unlink()
    assert swimlab("init-shot", shot)[0] == 0
    drafted = load_shot(shot / "shot.toml")
    assert (sorted(drafted.builds), drafted.name) == (["blink", "glued"], "shot")
    assert drafted.reference is not None
    assert drafted.reference.frames == "ref/f.####.exr"
    code, _, err = swimlab("init-shot", shot)
    assert (code, "is there already" in err) == (2, True)


def test_depth_splits_scores_into_bands(swimlab, shot):
    """Where all is far, the far band's score is the whole score."""
    far = np.full((HEIGHT, WIDTH, 1), 100, np.float32)
    for t in range(COUNT):
        write_channels(shot / "depth" / f"z.{t:04d}.exr", far, ("Z",), half=False, metadata={})
    path = shot / "deep.toml"
    path.write_text(SHOT + '[depth]\nframes = "depth"\n', encoding="utf-8")
    code, _, err = swimlab("study", path, "-t", "blink", "-o", shot / "deep", "-q")
    assert code == 0, err
    scores = entries(shot / "deep")["blink"]["scores"]
    assert scores["budget.flicker.far"] == scores["budget.flicker"] > 0
    words = ("--test", shot / "blink", "--reference", shot / "ref", "--motion=-1.25,0.625", "--depth", shot / "depth")
    code, out, err = swimlab("measure", *words, "--json", "-q")
    assert code == 0, err
    assert json.loads(out)["sequences"][0]["scores"]["budget.flicker.far"] == scores["budget.flicker.far"]


def test_a_study_of_two_shots_keeps_each_ones_settings(swimlab, shot):
    other = shot / "other.toml"
    other.write_text(SHOT.replace("corridor", "hall").replace("fps = 30", "fps = 24"), encoding="utf-8")
    code, _, err = swimlab("study", shot / "shot.toml", other, "-t", "glued", "-o", shot / "both", "-q")
    assert code == 0, err
    content = json.loads((shot / "both" / "scores.json").read_text(encoding="utf-8"))
    kept = [(entry["sequence"], entry["settings"]["fps"]) for entry in content["sequences"]]
    assert kept == [("corridor", 30), ("hall", 24)]
    assert swimlab("compare", shot / "both", shot / "both")[0] == 0
    assert swimlab("study", shot / "shot.toml", "-t", "none")[0] == 2


def test_builds_that_read_the_reference_differently_are_refused(swimlab, shot):
    """Else one reference would be several, and the builds not comparable."""
    path = shot / "spaces.toml"
    path.write_text(SHOT.replace('"glued/f.####.exr"', '"glued/f.####.exr"\ncolorspace = "ACEScg"'), encoding="utf-8")
    code, _, err = swimlab("study", path, "-o", shot / "spaces", "-q")
    assert (code, "blink: reads the reference otherwise than glued does" in err) == (2, True)
    said = path.read_text(encoding="utf-8").replace('"ref/f.####.exr"', '"ref/f.####.exr"\ncolorspace = "linear"')
    path.write_text(said, encoding="utf-8")
    assert swimlab("study", path, "-o", shot / "spaces", "-q")[0] == 0


def test_builds_of_other_rates_are_refused(swimlab, shot):
    for t in range(COUNT):
        pixels = (3 + waves(t, 1)).astype(np.float32) / 8
        rate = {"FramesPerSecond": 24.0}
        write_channels(shot / "blink" / f"f.{t:04d}.exr", pixels, ("R", "G", "B"), half=False, metadata=rate)
    (shot / "rates.toml").write_text(SHOT.replace("fps = 30\n", ""), encoding="utf-8")
    code, _, err = swimlab("study", shot / "rates.toml", "-o", shot / "rates", "-q")
    assert (code, "blink: has 24 frames a second, glued 60" in err) == (2, True)


def test_a_frame_that_is_bad_in_one_build_is_left_out_of_all(swimlab, shot):
    """Scores are those of the good frames alone, as if the shot had been told of them."""
    (shot / "blink" / "f.0000.exr").write_bytes(b"no picture")
    (shot / "skip.toml").write_text(SHOT.replace("fps = 30", "fps = 30\nskip_bad_frames = true"), encoding="utf-8")
    (shot / "told.toml").write_text(SHOT.replace("fps = 30", 'fps = 30\nframes = "1-5"'), encoding="utf-8")
    found = {}
    for name in ("skip", "told"):
        code, _, err = swimlab("study", shot / f"{name}.toml", "-o", shot / name)
        assert code == 0, err
        if name == "skip":
            assert "glued: 1 bad frame is left out, as in blink: 0" in err
            assert "blink: 1 bad frame is left out: 0" in err
        found[name] = json.loads((shot / name / "scores.json").read_text(encoding="utf-8"))["sequences"]
    for skipped, told in zip(found["skip"], found["told"], strict=True):
        assert [row["frame"] for row in skipped["frames"]] == list(range(1, COUNT))
        assert skipped["scores"] == told["scores"]
    code, _, err = swimlab("report", shot / "skip")
    assert code == 0, err


@pytest.mark.parametrize("name", ["motion", "depth", "mask", "error"])
def test_a_build_has_no_name_of_another_input(name, tmp_path):
    path = tmp_path / "named.toml"
    path.write_text(SHOT.replace("builds.glued", f"builds.{name}"), encoding="utf-8")
    with pytest.raises(SequenceError, match=f"'{name}' is what a run calls a part of its own"):
        load_shot(path)


def test_a_mask_that_changed_is_told_by_name(swimlab, shot):
    for value in (1, 0.75):
        mask = np.full((HEIGHT, WIDTH, 1), value, np.float32)
        write_channels(shot / "mask.exr", mask, ("Y",), half=False, metadata={})
        if value == 1:
            (shot / "masked.toml").write_text(SHOT + '[mask]\nframes = "mask.exr"\n', encoding="utf-8")
            code, _, err = swimlab("study", shot / "masked.toml", "-o", shot / "masked", "-q")
            assert code == 0, err
    code, _, err = swimlab("report", shot / "masked")
    assert (code, "mask.exr: has changed since it was measured (mask)" in err) == (2, True)


def test_drafts_of_any_name_are_shot_files(swimlab, shot):
    """A build may not be called error, and a name may be of characters beyond 16 bits."""
    home = shot.rename(shot.with_name("\N{MOTORWAY} 1"))
    (home / "glued").rename(home / "error")
    (home / "blink").rename(home / "\N{MOTORWAY}")
    assert swimlab("init-shot", home, "--force")[0] == 0
    drafted = load_shot(home / "shot.toml")
    assert {build.frames for build in drafted.builds.values()} == {"error/f.####.exr", "\N{MOTORWAY}/f.####.exr"}


def test_the_draft_of_a_rendered_run_is_studied_as_it_is(swimlab, tmp_path):
    """Neither its geometry nor its error is a build."""
    words = ("road-drive", "-t", "pixel-aniso,reference", "--size", "64x36", "--frames", "0-2")
    code, _, err = swimlab("render", *words, "-o", tmp_path / "engine", "-q")
    assert code == 0, err
    assert swimlab("init-shot", tmp_path / "engine")[0] == 0
    path = tmp_path / "engine" / "shot.toml"
    drafted, text = load_shot(path), path.read_text(encoding="utf-8")
    assert list(drafted.builds) == ["pixel-aniso"]
    assert (drafted.motion.frames, drafted.motion.convention) == ("geometry/####.exr", "own")
    assert text.count('# alpha = "mask"') == 2  # of the build and of the reference
    assert '# frames = "error/####.exr"  # 3 frames, 64x36; no build' in text
    code, _, err = swimlab("measure", path, "-o", tmp_path / "run", "-q")
    assert code == 0, err
    assert list(entries(tmp_path / "run")) == ["pixel-aniso"]


def test_a_draft_leaves_out_builds_of_another_size_and_frames_without_colour(swimlab, shot):
    for t in range(COUNT):
        picture = np.ones((HEIGHT // 2, WIDTH, 3), np.float32)
        write_channels(shot / "small" / f"f.{t:04d}.exr", picture, ("R", "G", "B"), half=False, metadata={})
        normals = np.ones((HEIGHT, WIDTH, 3), np.float32)
        write_channels(shot / "normals" / f"f.{t:04d}.exr", normals, ("N.X", "N.Y", "N.Z"), half=False, metadata={})
    assert swimlab("init-shot", shot, "--force")[0] == 0
    text = (shot / "shot.toml").read_text(encoding="utf-8")
    assert sorted(load_shot(shot / "shot.toml").builds) == ["blink", "glued"]
    assert "# left out: its frames are of 64x32 px, the shot is of 64x64\n# [builds.small]\n# frames" in text
    assert '# frames = "normals/f.####.exr"  # 6 frames, 64x64; no build: they have no channels of colour' in text
    assert "alpha =" not in text


def test_a_draft_keeps_builds_where_the_reference_is_of_another_size(swimlab, shot):
    for t in range(COUNT):
        picture = np.ones((HEIGHT // 2, WIDTH, 3), np.float32)
        write_channels(shot / "ref" / f"f.{t:04d}.exr", picture, ("R", "G", "B"), half=False, metadata={})
    assert swimlab("init-shot", shot, "--force")[0] == 0
    drafted = load_shot(shot / "shot.toml")
    assert (sorted(drafted.builds), drafted.reference) == (["blink", "glued"], None)


def test_a_build_that_holds_its_vectors_stays_a_build(swimlab, shot):
    channels = ("R", "G", "B", "motion.X", "motion.Y")
    for t in range(COUNT):
        pixels = np.ones((HEIGHT, WIDTH, 5), np.float32)
        write_channels(shot / "blink" / f"f.{t:04d}.exr", pixels, channels, half=False, metadata={})
    assert swimlab("init-shot", shot, "--force")[0] == 0
    drafted = load_shot(shot / "shot.toml")
    assert sorted(drafted.builds) == ["blink", "glued"]
    assert drafted.motion.frames == "blink/f.####.exr"
