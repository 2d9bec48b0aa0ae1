"""Builds of brought frames are measured once: what is kept is told apart from what has changed."""

import json
import os
import shutil

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from small_shot import COUNT, SHOT, SIDE, write_picture, write_shot

from swimlab.runs.frames import FrameError
from swimlab.runs.record import RunError
from swimlab.scoring import brought, footage, kept


def write(path, seed):
    """A frame of noise about 1."""
    write_picture(path, 1 + 0.1 * np.random.default_rng(seed).standard_normal((SIDE, SIDE, 3)))


@pytest.fixture
def shot(tmp_path):
    return write_shot(tmp_path)


@pytest.fixture
def measured(monkeypatch):
    """The builds that are measured from now on."""
    names = []
    real = footage.measure_build

    def note(sequence, name, *rest, **options):
        names.append(name)
        return real(sequence, name, *rest, **options)

    monkeypatch.setattr(footage, "measure_build", note)
    return names


@pytest.fixture
def study(swimlab, shot):
    def study(*words, code=0):
        ended, _, err = swimlab("study", shot, "-o", shot.parent / "run", *words)
        assert ended == code, err
        return err

    return study


def entries(run):
    content = json.loads((run / "scores.json").read_text(encoding="utf-8"))
    return {entry["technique"]: entry for entry in content["sequences"]}


def test_a_second_study_measures_and_writes_nothing_and_says_the_same(study, shot, measured):
    first = study()
    names = ("run.json", "scores.json", "frames.csv", "report.html", "contact.png")
    before = [(shot.parent / "run" / name).stat().st_mtime_ns for name in names]
    notes = {line for line in study().splitlines() if line.startswith("swimlab: ")}
    assert measured == ["one", "two"]
    assert [(shot.parent / "run" / name).stat().st_mtime_ns for name in names] == before
    assert notes
    assert notes <= set(first.splitlines())


def test_a_new_build_alone_is_measured_and_scores_are_those_of_all_at_once(study, shot, measured):
    study("-t", "one", "-q")
    study("-q")
    assert measured == ["one", "two"]
    together = entries(shot.parent / "run")
    (shot.parent / "run" / "scores.json").unlink()
    study("-q")
    assert measured == ["one", "two", "one", "two"]
    assert entries(shot.parent / "run") == together


def test_a_changed_build_is_measured_alone_and_a_changed_reference_by_all(study, shot, measured):
    study("-q")
    write(shot.parent / "two" / "1.exr", 5)
    study("-q")
    assert measured == ["one", "two", "two"]
    write(shot.parent / "ref" / "1.exr", 6)
    study("-q")
    assert measured[3:] == ["one", "two"]


def test_settings_and_code_are_measured_again(study, shot, measured, monkeypatch):
    study("-q")
    shot.write_text(SHOT.replace("[builds.two]", '[builds.two]\ncolorspace = "linear"'), encoding="utf-8")
    study("-q")
    assert measured == ["one", "two", "two"]
    monkeypatch.setattr(kept, "hash_of_code", lambda: "of another version")
    study("-q")
    assert measured[3:] == ["one", "two"]


def test_files_that_are_touched_are_the_same(study, shot, measured):
    study("-q")
    os.utime(shot.parent / "one" / "0.exr", ns=(1, 1))
    study("-q")
    assert measured == ["one", "two"]
    record = json.loads((shot.parent / "run" / "run.json").read_text(encoding="utf-8"))
    assert record["inputs"]["one"]["files"][0]["modified"] == 1


def test_a_shot_that_moved_as_a_whole_is_not_measured_again(swimlab, study, shot, measured, tmp_path_factory):
    """And what is said of its files names them where they are now."""
    for path in sorted((shot.parent / "one").iterdir()):
        picture = oiio.ImageBuf(str(path))
        picture.specmod().attribute("compression", "dwaa:45")
        assert picture.write(str(path))
    study("-q")
    before = entries(shot.parent / "run")
    assert before["one"]["notes"][0].startswith(f"{shot.parent / 'one'}")
    moved = shot.parent.rename(tmp_path_factory.mktemp("new") / "home")
    code, _, err = swimlab("study", moved / shot.name, "-o", moved / "run", "-q")
    assert code == 0, err
    assert measured == ["one", "two"]
    after = entries(moved / "run")
    assert after["two"] == before["two"]
    assert after["one"]["scores"] == before["one"]["scores"]
    assert after["one"]["notes"][0].startswith(f"{moved / 'one'}")
    assert after["one"]["notes"][1:] == before["one"]["notes"][1:]
    (moved / "one").rename(moved / "other")
    text = SHOT.replace('frames = "one"', 'frames = "other"')
    (moved / shot.name).write_text(text, encoding="utf-8")
    swimlab("study", moved / shot.name, "-o", moved / "run", "-q")
    assert measured == ["one", "two", "one"]


def test_a_build_that_was_measured_when_another_failed_is_kept(study, shot, measured, monkeypatch):
    noted = footage.measure_build

    def fail(sequence, name, *rest, **options):
        if name == "two":
            raise FrameError("2.exr: cannot be read any more")
        return noted(sequence, name, *rest, **options)

    with monkeypatch.context() as failing:
        failing.setattr(footage, "measure_build", fail)
        assert "2.exr" in study("-q", code=2)
    study("-q")
    assert measured == ["one", "two"]
    assert not (shot.parent / "run" / "measured").exists()


def test_scores_of_other_frames_that_a_kill_left_are_not_taken(study, shot, monkeypatch):
    """Killed when all builds are measured anew, and before the run is written."""
    study("-q")
    for t in range(COUNT):
        write(shot.parent / "two" / f"{t}.exr", t)
    with monkeypatch.context() as patched:
        patched.setattr(brought, "write_brought", lambda *_: (_ for _ in ()).throw(RunError("killed")))
        study("-q", code=2)
    study("-q")
    found = entries(shot.parent / "run")
    shutil.rmtree(shot.parent / "run")
    study("-q")
    assert entries(shot.parent / "run") == found


def test_a_run_of_another_shot_or_of_several_is_not_written_over(study, shot):
    study("-q")
    run = shot.parent / "run"
    before = (run / "scores.json").read_bytes()
    shot.write_text(SHOT.replace('"corridor"', '"hall"'), encoding="utf-8")
    assert "holds the run of corridor; choose another folder" in study("-q", code=2)
    (run / "run.json").unlink()
    assert "holds the scores of several runs" in study("-q", code=2)
    assert (run / "scores.json").read_bytes() == before


def test_a_file_that_changes_while_it_is_measured_is_told_and_nothing_is_kept(study, shot, monkeypatch):
    real = footage.measure_build

    def disturbed(sequence, name, *rest, **options):
        entry = real(sequence, name, *rest, **options)
        write(shot.parent / "one" / "1.exr", 9)
        return entry

    monkeypatch.setattr(footage, "measure_build", disturbed)
    err = study("-q", code=2)
    assert f"{shot.parent / 'one' / '1.exr'}: has changed while it was measured (one)" in err
    assert not list((shot.parent / "run").rglob("*.json"))


def test_all_inputs_that_are_not_there_are_told_at_once(study, shot):
    shot.write_text(SHOT.replace('"one"', '"gone"').replace('"ref"', '"lost"'), encoding="utf-8")
    err = study(code=2)
    assert f"swimlab: {shot}: one: {shot.parent / 'gone'}: no such file" in err
    assert f"swimlab: {shot}: {shot.parent / 'lost'}: no such file" in err


def test_a_changed_configuration_of_colours_is_measured_again(study, shot, measured, monkeypatch):
    study("-q")
    monkeypatch.setenv("OCIO", "ocio://default")
    study("-q")
    assert measured == ["one", "two"] * 2
    monkeypatch.setenv("OCIO", str(shot.parent / "none.ocio"))  # of which nothing can be told
    study("-q")
    study("-q")
    assert measured == ["one", "two"] * 4
