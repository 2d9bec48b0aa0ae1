"""Shots on the engine of sweeps, and sweeps of builds by settings: the same bits, each build once, nothing lost."""

import json
import os
import shutil
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from distributed import LocalCluster
from small_shot import SHOT, SIDE, write_picture, write_shot
from turning_shot import write_turning_shot

from swimlab.footage.shot import load_shot
from swimlab.runs.record import RunError
from swimlab.sweep import build, engine, shots
from swimlab.sweep.engine import ANY_PORT

SWEEP = """
version = 1
name = "looks"
sequences = ["corridor.toml"]
techniques = ["one", "two"]
[grid]
"builds.two.colorspace" = ["linear", "srgb"]
"""


@pytest.fixture
def home(tmp_path):
    """Two shots of the same frames, and a sweep of one."""
    write_shot(tmp_path)
    (tmp_path / "hall.toml").write_text(SHOT.replace("corridor", "hall"), encoding="utf-8")
    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    return tmp_path


@pytest.fixture
def measured(monkeypatch):
    """The builds that are measured from now on."""
    names = []
    real = build.measure_build

    def note(shot, name, *rest, **options):
        names.append((shot, name))
        return real(shot, name, *rest, **options)

    monkeypatch.setattr(build, "measure_build", note)
    return names


@pytest.fixture
def here(monkeypatch):
    """The engine of this process under the name of the cluster's."""

    class Here:
        def __init__(self, *_, **__):
            pass

        def __enter__(self):
            return engine.local

        def __exit__(self, *_):
            pass

    monkeypatch.setattr("swimlab.cli.engines.dask_engine", Here)


def scores(path: Path):
    """Scores by sequence and build."""
    found = json.loads(path.read_text(encoding="utf-8"))["sequences"]
    return {(entry["sequence"], entry["technique"]): entry for entry in found}


def test_builds_on_an_engine_score_as_in_this_process(swimlab, home, measured, here):
    words = ("study", home / "corridor.toml", home / "hall.toml", "-q", "-o")
    assert swimlab(*words, home / "plain")[0] == 0
    code, _, err = swimlab(*words, home / "engine", "--engine", "dask")
    assert code == 0, err
    assert [name for _, name in measured] == ["one", "two"]  # of two shots of the same frames
    plain, other = (scores(home / name / "scores.json") for name in ("plain", "engine"))
    assert other == plain
    assert not list((home / "engine").glob(".scores/*"))
    assert (home / "engine" / "report.html").is_file()


def test_what_runs_have_is_not_measured_again_on_an_engine(swimlab, home, measured, here):
    words = ("study", home / "corridor.toml", home / "hall.toml", "-q", "-o", home / "run", "--engine", "dask")
    assert swimlab(*words)[0] == 0
    before = (home / "run" / "corridor" / "scores.json").read_bytes()
    assert swimlab(*words)[0] == 0
    assert [name for _, name in measured] == ["one", "two"]
    assert (home / "run" / "corridor" / "scores.json").read_bytes() == before
    write_picture(home / "two" / "1.exr", np.ones((SIDE, SIDE, 3)))
    assert swimlab(*words)[0] == 0
    assert [name for _, name in measured] == ["one", "two", "two"]


def test_a_build_that_fails_loses_no_other(swimlab, home, measured, here):
    good = (home / "two" / "1.exr").read_bytes()
    (home / "two" / "1.exr").write_bytes(b"no picture")
    words = ("study", home / "corridor.toml", "-q", "-o", home / "run", "--engine", "dask")
    code, _, err = swimlab(*words)
    assert (code, "corridor, two: " in err, "1.exr" in err, "skip_bad_frames = true" in err) == (2, True, True, True)
    (home / "two" / "1.exr").write_bytes(good)
    assert swimlab(*words)[0] == 0
    assert measured == [("corridor", "one"), ("corridor", "two")]


def test_a_bad_frame_is_left_out_of_all_builds_on_an_engine_too(swimlab, home, here):
    (home / "two" / "2.exr").write_bytes(b"no picture")
    (home / "skip.toml").write_text(
        SHOT.replace("[reference]", "skip_bad_frames = true\n[reference]"), encoding="utf-8"
    )
    found = {}
    for name, words in (("plain", ()), ("engine", ("--engine", "dask"))):
        code, _, err = swimlab("study", home / "skip.toml", "-q", "-o", home / name, *words)
        assert code == 0, err
        found[name] = scores(home / name / "scores.json")
    assert found["engine"] == found["plain"]
    assert {row["frame"] for row in found["engine"]["corridor", "one"]["frames"]} == {0, 1}


def test_only_shots_go_to_an_engine(swimlab, home):
    code, _, err = swimlab("study", "road-shift", "--engine", "dask")
    assert (code, "'swimlab sweep'" in err) == (2, True)
    code, _, err = swimlab("study", home / "corridor.toml", "--scheduler", "tcp://none:1")
    assert (code, "is for --engine dask" in err) == (2, True)


def test_a_sweep_of_builds_by_settings_measures_each_look_once(swimlab, home, measured):
    words = ("sweep", home / "sweep.toml", "-o", home / "out", "-q")
    code, out, err = swimlab(*words)
    assert code == 0, err
    assert [name for _, name in measured] == ["one", "two", "two"]
    found = scores(home / "out" / "scores.json")
    assert len(found) == 4
    linear, srgb = "corridor_two.colorspace-linear", "corridor_two.colorspace-srgb"
    assert found[linear, "one"]["scores"] == found[srgb, "one"]["scores"]
    assert found[linear, "two"]["scores"]["budget.mse"] < found[srgb, "two"]["scores"]["budget.mse"]
    assert sum("one" in line.split() for line in out.splitlines()) == 1  # a row for each distinct result
    assert (home / "out" / "runs" / srgb / "run.json").is_file()
    assert swimlab("report", home / "out" / "runs" / srgb)[0] == 0
    assert swimlab(*words)[0] == 0
    assert len(measured) == 3


def test_a_second_sweep_measures_frames_that_changed(swimlab, home, measured):
    words = ("sweep", home / "sweep.toml", "-o", home / "out", "-q")
    assert swimlab(*words)[0] == 0
    for path in (home / "one").iterdir():
        shutil.copy(path, home / "two" / path.name)
    assert swimlab(*words)[0] == 0
    found = scores(home / "out" / "scores.json")
    linear = "corridor_two.colorspace-linear"
    assert found[linear, "two"]["scores"] == found[linear, "one"]["scores"]
    assert measured[3:] == [("corridor_two.colorspace-linear", "two"), ("corridor_two.colorspace-srgb", "two")]


def test_a_worker_that_would_make_another_key_refuses(home, monkeypatch):
    request = load_shot(home / "corridor.toml").requests(home, None)
    (one, _) = shots.Shots([shots.Asked("corridor", request, home / "run")]).builds.values()
    monkeypatch.setenv("OCIO", "ocio://default")
    with pytest.raises(RunError, match=r"another \$OCIO"):
        build.measure_into(one, home / "out", 1)


def test_shares_of_a_sweep_of_shots_are_done_apart(swimlab, home, measured):
    words = ("sweep", home / "sweep.toml", "-o", home / "out", "-q")
    assert swimlab(*words, "--only", "2/3")[0] == 0
    assert [name for _, name in measured] == ["two"]
    code, out, _ = swimlab(*words, "--dry-run", "--json")
    assert code == 0
    rows = {row["technique"]: (row["chunks"], row["done"]) for row in json.loads(out)["work"]}
    assert rows == {"one": (1, 0), "two": (2, 1)}
    code, _, err = swimlab(*words, "--export", "openjd", home / "job.json")
    assert code == 0, err
    assert "in 3 chunks" in (home / "job.json").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('"two"]\n', '"tow"]\n'), "techniques: build 'tow': corridor has one, two"),
        (('"corridor.toml"', '"corridor.toml", "road-shift"'), "sweep them apart"),
        (("[grid]", "samples = 4\n[grid]"), "samples: is of rendering"),
        (('"srgb"', '"linear"'), "'linear' is listed twice"),
        (("two.colorspace", "two.colourspace"), "colourspace: unknown key (did you mean 'colorspace'?"),
        (('"builds.two.colorspace" = ["linear", "srgb"]', '"name.x" = [1]'), "name.x: name is not a table"),
    ],
)
def test_a_mistaken_sweep_of_shots_is_told(swimlab, home, change, said):
    (home / "sweep.toml").write_text(SWEEP.replace(*change), encoding="utf-8")
    code, _, err = swimlab("sweep", home / "sweep.toml", "-o", home / "out")
    assert (code, said in err) == (2, True), err


def kill_at_first(pattern, out, process, killed, finished):
    """Kill a process when there is a file of a pattern."""
    while not finished.is_set():
        if list(out.glob(pattern)):
            os.kill(process, signal.SIGKILL)
            killed.append(process)
            return
        time.sleep(0.002)


@pytest.mark.parametrize("pattern", [".scores/*.json", ".scores/*.part"], ids=["between builds", "between parts"])
def test_a_killed_worker_loses_nothing(swimlab, home, pattern):
    """One of two processes of a cluster is killed: scores are those of one process."""
    shot = home / "corridor.toml"
    if pattern.endswith(".part"):
        shot = write_turning_shot(home / "long", count=132, cut=66, side=48)
    words = ("study", shot, "-q", "-o")
    assert swimlab(*words, home / "plain")[0] == 0
    killed, finished = [], threading.Event()
    with LocalCluster(n_workers=2, threads_per_worker=1, memory_limit=0, dashboard_address=ANY_PORT) as cluster:
        process = next(iter(cluster.workers.values())).pid
        killer = threading.Thread(target=kill_at_first, args=(pattern, home / "engine", process, killed, finished))
        killer.start()
        at = ("--engine", "dask", "--scheduler", cluster.scheduler_address)
        code, _, err = swimlab(*words, home / "engine", *at)
        finished.set()
        killer.join()
    assert code == 0, err
    assert killed
    assert scores(home / "engine" / "scores.json") == scores(home / "plain" / "scores.json")
