"""Scores that are older than the pictures beside them are refused wherever they are read, and measuring mends that."""

import json
import shutil
import sys

import pytest
from gate_files import write_gate

import swimlab as api
import swimlab.render.techniques as package
from swimlab.render import catalogue
from swimlab.runs.entries import read_entries
from swimlab.runs.frames import frame_path
from swimlab.runs.record import Record, RunError

SIZE, FRAMES, SAMPLES = ("--size", "96x54"), ("--frames", "0-2"), ("--samples", 4, "-q")
OWN = """
from swimlab.render import FINEST, ISOTROPIC, Technique, pixel_shading

TECHNIQUE = Technique(name="own-one", summary="", source="a test", render=pixel_shading(lambda _: ISOTROPIC))
"""
RENDERED_AGAIN = "was rendered again since it was measured"


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """A measured run, and a measured study of two sequences, to be copied."""
    folder = tmp_path_factory.mktemp("studied")
    options = {"size": (96, 54), "frames": "0-2", "samples": 4}
    api.study("road-shift", "pixel-point", output=folder / "run", **options)
    return folder


@pytest.fixture
def run(studied, tmp_path):
    return shutil.copytree(studied / "run", tmp_path / "run")


@pytest.fixture
def read_by(swimlab, tmp_path):
    """Exit codes and what is said by everything that reads scores of a folder."""
    write_gate(tmp_path / "gate.toml", 'metric = "frame.mse"\nmax = 1000')
    write_gate(tmp_path / "base.toml", 'metric = "frame.mse"\nmax_increase = 0', baseline='file = "base.json"')

    def read_by(run):
        commands = {
            "gate": ("gate.toml", run),
            "baseline": ("update", "base.toml", run),
            "report": (run, "-q"),
            "compare": (run, run),
            "table": (run,),
        }
        said = {name: swimlab(name, *words) for name, words in commands.items()}
        return {name: (code, RENDERED_AGAIN in err) for name, (code, _, err) in said.items()}

    return read_by


def render(
    swimlab, run, *words, sequence="road-shift", techniques="pixel-point,reference", size=SIZE, frames=FRAMES, ends=0
):
    command = ("render", sequence, "-t", techniques, "-o", run, *size, *frames, *SAMPLES)
    assert swimlab(*command, *words)[0] == ends


CHANGES = {
    "other settings": lambda swimlab, run: render(swimlab, run, "--force", size=("--size", "64x36")),
    "other code by force": lambda swimlab, run: render(swimlab, run, "--force"),
    "another sequence": lambda swimlab, run: render(swimlab, run, "--force", sequence="road-hills"),
    "other techniques": lambda swimlab, run: render(swimlab, run, "--force", techniques="vmf,reference"),
    "a picture in place of one": lambda swimlab, run: (
        frame_path(run, "pixel-point", 1).unlink(),
        render(swimlab, run),
    ),
    "the reference in place of one": lambda swimlab, run: (
        frame_path(run, "reference", 1).unlink(),
        render(swimlab, run),
    ),
    "geometry in place of one": lambda swimlab, run: (
        frame_path(run, "geometry", 2).unlink(),
        render(swimlab, run),
    ),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_older_scores_are_refused_until_the_run_is_measured(swimlab, run, read_by, change):
    assert set(read_by(run).values()) == {(0, False)}
    assert "measured    yes" in swimlab("info", run)[1]
    change(swimlab, run)
    assert set(read_by(run).values()) == {(2, True)}
    with pytest.raises(RunError, match=rf"{RENDERED_AGAIN}.*; measure it: swimlab measure "):
        api.open(run)
    assert f"measured    no: {run}: {RENDERED_AGAIN}" in swimlab("info", run)[1]
    assert json.loads(swimlab("info", run, "--json")[1])["measured"] is False
    assert swimlab("measure", run, "-q")[0] == 0
    assert set(read_by(run).values()) == {(0, False)}
    assert api.open(run).scores


@pytest.mark.parametrize("more", [{}, {"frames": ("--frames", "0-3")}, {"techniques": "pixel-point,vmf,reference"}])
def test_scores_hold_where_pictures_came_to_those_that_were_measured(swimlab, run, read_by, more):
    before = Record.read(run).rendered["pixel-point"]
    render(swimlab, run, **more)
    assert Record.read(run).rendered["pixel-point"] == before
    assert set(read_by(run).values()) == {(0, False)}


def test_scores_of_an_own_technique_are_older_once_its_file_is_edited(swimlab, tmp_path, read_by, monkeypatch):
    monkeypatch.setattr(package, "__path__", list(package.__path__))
    (tmp_path / "own").mkdir()
    run = tmp_path / "run"

    def rendered(command, code):
        (tmp_path / "own" / "own_one.py").write_text(code, encoding="utf-8")
        api.add_techniques(tmp_path / "own")
        words = ("-t", "own-one,vmf,reference", "-o", run, *SIZE, *FRAMES, *SAMPLES)
        assert swimlab(command, "road-shift", *words)[0] == 0
        return Record.read(run)

    try:
        first = rendered("study", OWN)
        assert rendered("render", OWN).rendered == first.rendered
        assert set(read_by(run).values()) == {(0, False)}
        edited = rendered("render", OWN.replace("_: ISOTROPIC", "_: FINEST"))
        assert edited.hash == first.hash
        assert {name for name in first.rendered if edited.rendered[name] != first.rendered[name]} == {"own-one"}
        assert set(read_by(run).values()) == {(2, True)}
        assert swimlab("measure", run, "-q")[0] == 0
        assert set(read_by(run).values()) == {(0, False)}
    finally:
        sys.modules.pop("swimlab.render.techniques.own_one", None)
        catalogue.techniques.cache_clear()


def test_a_render_that_was_killed_leaves_older_scores_older(swimlab, run, read_by, monkeypatch):
    def killed(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("swimlab.render.renderer.Renderer.write_picture", killed)
        render(swimlab, run, "--force", ends=130)
    assert set(read_by(run).values()) == {(2, True)}


def test_a_runs_scores_without_the_time_of_rendering_open_as_before(run, read_by):
    """As released versions wrote them."""
    for name in ("run.json", "scores.json"):
        content = json.loads((run / name).read_text(encoding="utf-8"))
        content.pop("rendered", None)
        for entry in content.get("sequences", ()):
            del entry["rendered"]
        (run / name).write_text(json.dumps(content), encoding="utf-8")
    assert set(read_by(run).values()) == {(0, False)}


def test_scores_of_a_study_are_older_than_a_run_of_it(swimlab, tmp_path):
    study = tmp_path / "study"
    assert (
        swimlab("study", "road-shift", "road-drive", "-t", "pixel-point", "-o", study, *SIZE, *FRAMES, *SAMPLES)[0] == 0
    )
    write_gate(tmp_path / "gate.toml", 'metric = "frame.mse"\nmax = 1000')
    assert swimlab("gate", "gate.toml", study)[0] == 0
    render(swimlab, study / "road-drive", "--force", sequence="road-drive")
    assert swimlab("measure", study / "road-drive", "-q")[0] == 0
    code, _, err = swimlab("gate", "gate.toml", study)
    assert code == 2
    assert f"{RENDERED_AGAIN}; measure it: swimlab measure {study / 'road-drive'}, and name it in place of" in err
    assert swimlab("gate", "gate.toml", study / "road-drive")[0] == 0


def test_a_copy_of_scores_from_before_a_change_of_code_is_still_compared(swimlab, run, tmp_path):
    assert swimlab("measure", run, "-o", run / "before.json", "-q")[0] == 0
    render(swimlab, run, "--force")
    assert swimlab("measure", run, "-q")[0] == 0
    assert swimlab("compare", run / "before.json", run)[0] == 0
    (before,), (now,) = read_entries(run / "before.json"), read_entries(run)
    assert (before.folder, now.folder) == (None, run)
