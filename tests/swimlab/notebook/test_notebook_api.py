"""What notebooks call: studies, tables, pictures, frames of your own, and techniques in folders of your own."""

import re
import subprocess
import sys
from dataclasses import fields
from inspect import signature

import cv2
import numpy as np
import pytest

import swimlab
from metrics import measure
from swimlab.cli.dry_run import pictures_there
from swimlab.footage.convention import PRESETS
from swimlab.footage.request import Request
from swimlab.notebook.picture import INK, OUTSIDE, error_colours, scale_bar
from swimlab.notebook.scores import Scores
from swimlab.render import catalogue
from swimlab.render.plan import make_plan
from swimlab.render.run import render_run
from swimlab.report.display import srgb
from swimlab.runs.frames import FrameError, frame_path, read_frame
from swimlab.runs.record import RunError
from swimlab.sweep.chunk import cut

FILE = """
from swimlab.render import ISOTROPIC, Technique, pixel_shading

TECHNIQUE = Technique(name={name!r}, summary={summary!r}, source="a test", render=pixel_shading(lambda _: ISOTROPIC))
"""


@pytest.fixture(scope="module")
def road(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study") / "road"
    return swimlab.study(
        "road-shift", ["pixel-point", "pixel-aniso"], size=(96, 54), frames="0-3", samples=4, output=folder
    )


def test_importing_swimlab_costs_nothing():
    heavy = "{'numpy', 'warp', 'cv2', 'scipy', 'pydantic', 'matplotlib'}"
    script = f"import sys, swimlab; print({heavy} & set(sys.modules), *dir(swimlab))"
    said = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True).stdout
    assert said.split() == ["set()", *sorted(swimlab.__all__)]


def test_one_technique_needs_no_list(road):
    one = swimlab.study("road-shift", "pixel-point", size=(32, 18), frames="0", samples=4)
    assert one.techniques == ("pixel-point", "reference")
    assert np.array_equal(road.compare("pixel-point").codes, road.compare(["pixel-point"]).codes)
    assert np.array_equal(road.errors("pixel-point").codes, road.errors(["pixel-point"]).codes)


@pytest.mark.parametrize(
    ("given", "said"),
    [({"threads": 0}, "--threads 0: must be at least 1"), ({"domain": "dispaly"}, "choose one of linear, display")],
)
def test_what_cannot_be_done_is_said_before_rendering(tmp_path, given, said):
    with pytest.raises(ValueError, match=said):
        swimlab.study("road-shift", ["pixel-point"], size=(32, 18), frames="0", output=tmp_path / "run", **given)
    assert list(tmp_path.iterdir()) == []


def test_a_motion_is_two_numbers(road):
    with pytest.raises(FrameError, match=r"motion \(1, 2, 3\): give \(dx, dy\)"):
        swimlab.measure_frames(road.folder / "pixel-point", motion=(1, 2, 3))


def test_exported_names_are_there():
    assert all(getattr(swimlab, name) is not None for name in swimlab.__all__)
    with pytest.raises(AttributeError, match="no attribute 'stduy'"):
        _ = swimlab.stduy


def test_scores_are_those_of_the_file(road, tolerance):
    raw = road.scores.to_dict()
    assert set(raw) == {"pixel-point", "pixel-aniso"}
    for name, row in road.scores.items():
        assert row["flicker"] == pytest.approx(raw[name]["budget.flicker"] ** 0.5, rel=tolerance("closed form"))
        parts = sum(row[part] ** 2 for part in ("bias", "detail", "flicker"))
        assert parts == pytest.approx(row["rms error"] ** 2, rel=tolerance("closed form"))
        assert "plane.on" in road.scores.absent[name]
    assert [row["technique"] for row in road.scores.rows] == list(road.scores)
    with pytest.raises(KeyError, match="no scores of 'tls'; there are pixel-aniso, pixel-point"):
        road.scores["tls"]


def test_tables_show_every_value_and_say_what_is_missing():
    entries = [
        {"technique": "a<b", "scores": {"budget.mse": 0.04, "visible.flicker": 2.0}, "absent": {}},
        {"technique": "c", "scores": {"budget.mse": 0.09}, "absent": {"visible.flicker": "a reason"}},
    ]
    scores = Scores(entries)
    assert repr(scores).splitlines() == [
        "technique  rms error  visible flicker",
        "a<b            0.200            2.000",
        "c              0.300                -",
    ]
    html = scores._repr_html_()
    assert "a&lt;b" in html
    assert re.findall(r">([\d.-]+)</td>", html) == ["0.200", "2.000", "0.300", "-"]
    assert scores.absent["c"]["visible.flicker"] == "a reason"


def test_a_study_says_what_it_is(road):
    assert repr(road).startswith(f"road-shift: 4 frames, 96x54 px, rms radiance; in {road.folder}\ntechnique")
    assert road.techniques == ("pixel-aniso", "pixel-point", "reference")
    assert road.costs["reference"]["shaded_per_frame"] > road.costs["pixel-point"]["shaded_per_frame"] > 0
    assert [row["frame"] for row in road.by_frame["pixel-point"]] == [0, 1, 2, 3]
    assert "budget.bands" in road.curves["pixel-aniso"]
    assert "road-shift" in road.report(road.folder / "page.html").read_text(encoding="utf-8")


def test_clips_measure_as_the_study_did(road):
    test, reference = road.clip("pixel-point"), road.clip()
    found = measure(test, reference, names=["budget.mse", "budget.flicker"]).scores
    raw = road.scores.to_dict()["pixel-point"]
    assert found == {name: raw[name] for name in found}
    assert {"budget.mse", "budget.flicker"} <= set(found)


def test_pictures_show_the_frames_pixels(road):
    rgba = read_frame(frame_path(road.folder, "pixel-point", 2))
    picture = road.show("pixel-point", 2, exposure=1.0, zoom=3, region=(40, 30, 16, 8))
    decoded = cv2.imdecode(np.frombuffer(picture.png, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert np.array_equal(decoded, picture.codes)
    expected = srgb(2 * rgba[30:38, 40:56, :3]).repeat(3, axis=0).repeat(3, axis=1)
    corner = np.argwhere((decoded == expected[0, 0]).all(axis=2) & (np.indices(decoded.shape[:2])[0] >= 20))[0]
    panel = decoded[corner[0] : corner[0] + 24, corner[1] : corner[1] + 48]
    assert np.array_equal(panel, expected)
    assert picture.alt == "pixel-point on road-shift, frame 2 at x 40 y 30, 16x8 px, +1 stops, enlarged 3 times"
    assert f'alt="{picture.alt}"' in picture._repr_html_()


def test_comparisons_hold_every_panel_and_fit_a_page(road):
    side_by_side, grid = road.compare(zoom=5), road.compare(frames=[0, 1, 2], zoom=2)
    assert side_by_side.codes.shape[1] < 1000
    assert side_by_side.codes.shape[0] > 2 * 5 * 54  # three panels, two to a row
    assert grid.codes.shape[0] > 3 * 2 * 54
    assert grid.codes.shape[1] > 3 * 2 * 96


def test_errors_have_fixed_colours():
    reference = np.zeros((1, 4, 4), np.float32)
    reference[..., 3] = [1, 1, 1, 0.5]
    test = reference + np.array([0, 7, -0.5, 1], np.float32)[:, None] * np.array([1, 1, 1, 0], np.float32)
    white, red, blue, outside = error_colours(test, reference)[0].tolist()
    assert white == [247, 247, 247]
    assert red == [103, 0, 31]
    assert blue == [5, 48, 97]
    assert outside == [OUTSIDE] * 3


def test_the_scale_of_errors_is_printed(road):
    bar = scale_bar(160)
    assert bar[0, 0].tolist() == [5, 48, 97]
    assert bar[0, -1].tolist() == [103, 0, 31]
    assert (bar[20:] == INK).all(axis=2).any()
    assert "from -0.5 (blue, too dark) to +0.5 (red, too bright)" in road.errors().alt
    x, y, width, height = road.detail((20, 10), 1)
    assert (width, height) == (20, 10)
    assert 0 <= x <= 76
    assert 0 <= y <= 44


@pytest.mark.parametrize(
    ("ask", "answer"),
    [
        (lambda road: road.show("tsl"), "has no technique tsl; it has pixel-aniso, pixel-point, reference"),
        (lambda road: road.show(frame=9), "has no frame 9; it has 0, 1, 2, 3"),
        (lambda road: road.show(region=(96, 0, 8, 8)), "lies outside of the frame, 96x54 px"),
        (lambda road: swimlab.study("road-shift", ["tls"]), "technique 'tls': is not known; did you mean 'tsl'"),
        (lambda road: swimlab.study("road-shift", ["tsl"], frames="0-99"), "the sequence has frames 0-31"),
        (lambda road: swimlab.open(road.folder / "geometry"), "holds no run.json"),
        (lambda road: swimlab.study("road-shift", ["tsl"], output=road.folder), "holds a run of other settings"),
    ],
)
def test_mistakes_are_named(road, ask, answer):
    with pytest.raises(RunError, match=re.escape(answer)):
        ask(road)


def test_runs_are_opened(road, tmp_path):
    assert swimlab.open(road.folder).scores.to_dict() == road.scores.to_dict()
    render_run(make_plan("road-shift", ["pixel-point"], size=(16, 9), frames="0"), tmp_path / "only")
    with pytest.raises(RunError, match="measure the run first"):
        swimlab.open(tmp_path)
    (tmp_path / "again").symlink_to(road.folder)
    with pytest.raises(RunError, match="holds several runs; open one of"):
        swimlab.open(tmp_path)


def test_a_study_of_different_sizes_has_no_clip():
    scale = swimlab.study("road-scale", ["pixel-point"], size=(64, 36), frames="0-1", samples=4)
    assert set(scale.scores["pixel-point"]) >= {"scale rmse"}
    assert scale.show("pixel-point", 1).codes.shape < scale.show("pixel-point", 0).codes.shape
    with pytest.raises(RunError, match="different sizes"):
        scale.clip("pixel-point")


def test_frames_of_ones_own(road):
    test, reference = road.folder / "pixel-point", road.folder / "reference"
    own = swimlab.measure_frames(test, reference=reference, motion=(23 / 32, 19 / 32), alpha="mask")
    shown = own.scores["test"]
    assert shown["rms error"] == road.scores["pixel-point"]["rms error"]
    assert any("residuals: as given" in note for note in own.notes)
    assert own.curves
    assert "residuals: as given" in repr(own)
    assert "residuals: as given" in own._repr_html_()
    with pytest.raises(FrameError, match="convention 'unty': is not known; there are own, blender, unity"):
        swimlab.measure_frames(test, motion=road.folder / "geometry", convention="unty")
    with pytest.raises(FrameError, match="does not fit the frames"):
        swimlab.measure_frames(reference, motion=(-23 / 32, 19 / 32), alpha="mask")
    fields = swimlab.measure_frames(test, motion=road.folder / "geometry", convention=PRESETS["own"], alpha="mask")
    assert "residual" in fields.scores["test"]


@pytest.fixture
def folder(tmp_path):
    """A folder for techniques; what there was before is back afterwards."""
    path = swimlab.render.techniques.__path__
    yield tmp_path
    swimlab.render.techniques.__path__ = path
    sys.modules.pop("swimlab.render.techniques.own_one", None)
    catalogue.techniques.cache_clear()


def test_techniques_are_found_in_a_folder_of_ones_own(folder, road, tmp_path_factory):
    file = folder / "own_one.py"
    for summary in ("first", "other"):  # of the same length, within the same second
        file.write_text(FILE.format(name="own-one", summary=summary), encoding="utf-8")
        assert swimlab.add_techniques(folder) == ["own-one"]
        assert catalogue.techniques()["own-one"].summary == summary
    output = tmp_path_factory.mktemp("own")
    study = swimlab.study("road-shift", ["own-one", "pixel-trilinear"], size=(32, 18), frames="0", output=output)
    assert np.array_equal(study.frame("own-one"), study.frame("pixel-trilinear"))


def test_edited_code_renders_its_own_pictures_anew_and_no_others(folder, tmp_path_factory):
    file, output = folder / "own_one.py", tmp_path_factory.mktemp("own")
    text = FILE.format(name="own-one", summary="a")

    def rendered(code, names=("own-one", "pixel-trilinear")):
        file.write_text(code, encoding="utf-8")
        swimlab.add_techniques(folder)
        plan = make_plan("road-shift", [*names, "reference"], size=(32, 18), frames="0", samples=4)
        there = pictures_there(plan, output, force=False)
        record = render_run(plan, output)
        return there, record, {n: frame_path(output, n, 0).stat().st_mtime_ns for n in (*names, "geometry")}

    _, first, before = rendered(text)
    there, same, after = rendered(text)
    assert (there, same.hash, after) == (3, first.hash, before)
    there, other, after = rendered(text.replace("ISOTROPIC", "FINEST"))
    assert (there, other.hash) == (2, first.hash)
    assert {name for name in after if after[name] != before[name]} == {"own-one"}
    own, given = (read_frame(frame_path(output, name, 0)) for name in ("own-one", "pixel-trilinear"))
    assert not np.array_equal(own, given)
    # A run without it does not care, and keeps its pictures.
    there, _, same = rendered(text, ["pixel-trilinear"])
    assert (there, same) == (2, {name: after[name] for name in same})
    assert frame_path(output, "own-one", 0).stat().st_mtime_ns == after["own-one"]


def test_edited_code_makes_other_chunks_of_a_sweep(folder):
    file = folder / "own_one.py"
    text = FILE.format(name="own-one", summary="a")

    def chunks(code):
        file.write_text(code, encoding="utf-8")
        swimlab.add_techniques(folder)
        names = ["own-one", "pixel-point", "reference"]
        return {name: part.digest for name, (part,) in cut(make_plan("road-shift", names, frames="0"), 1).items()}

    before, after = chunks(text), chunks(text.replace("ISOTROPIC", "FINEST"))
    assert {name for name in before if before[name] != after[name]} == {"own-one"}


def test_commands_find_them_too(folder, monkeypatch):
    (folder / "own_one.py").write_text(FILE.format(name="own-one", summary="by name"), encoding="utf-8")
    monkeypatch.setenv("SWIMLAB_TECHNIQUES", str(folder))
    catalogue.techniques.cache_clear()
    assert "own-one" in catalogue.techniques()


def test_commands_say_which_folder_is_wrong(folder, monkeypatch):
    (folder / "own_one.py").write_text("def", encoding="utf-8")
    monkeypatch.setenv("SWIMLAB_TECHNIQUES", str(folder))
    catalogue.techniques.cache_clear()
    with pytest.raises(ValueError, match=r"SWIMLAB_TECHNIQUES=.*own_one\.py.*mend the file"):
        catalogue.techniques()


@pytest.mark.parametrize(
    ("file", "text", "answer"),
    [
        ("own_one.py", FILE.format(name="tsl", summary="taken"), "has a 'tsl' already"),
        ("own_one.py", "def", "invalid syntax"),
        ("own_one.py", "NOTHING = 1", "TECHNIQUE"),
        ("tsl.py", FILE.format(name="mine", summary="shadows"), "has a file of this name; give it another"),
        ("read.me", "", "is not a folder with a .py file in it"),
    ],
)
def test_a_bad_file_leaves_everything_as_it_was(folder, file, text, answer):
    before = list(catalogue.techniques())
    (folder / file).write_text(text, encoding="utf-8")
    with pytest.raises((ValueError, SyntaxError, AttributeError), match=answer):
        swimlab.add_techniques(folder)
    assert list(catalogue.techniques()) == before


def test_frames_are_measured_with_every_option_of_the_command():
    options = {field.name for field in fields(Request)} - {"look", "left_out"}  # of several builds
    assert options <= set(signature(swimlab.measure_frames).parameters)
