"""Every command works where Linux's own facilities are missing: affinity, users, fork, links, Unix modules."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from one_interpreter import in_turn
from run_folders import entries, pixels

SEQUENCE = """
version = 1
name = "small"
frames = 4
size = [80, 45]
"""
SWEEP = """
version = 1
name = "killed"
sequences = ["small.toml"]
techniques = ["pixel-point"]
samples = 144
chunk = 1
"""
GATE = """
version = 1
[[rule]]
metric = "budget.mse"
technique = "pixel-aniso"
max = 10.0
[[rule]]
metric = "budget.mse"
technique = "pixel-point"
max = 0.0
"""
STUDY = ["study", "small.toml", "-t", "pixel-point,pixel-aniso,reference", "--samples", "4", "-o"]
OWN = ["--test", "run/pixel-point/####.exr", "--reference", "run/reference/####.exr", "--motion", "0.71875,0.59375"]
WITHOUT = os.environ | {"PYTHONPATH": str(Path(__file__).parent / "other_system")}
COMMAND = [sys.executable, "-m", "swimlab"]


def started(command, environment, **options):
    return subprocess.run(command, env=environment, capture_output=True, encoding="utf-8", check=False, **options)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study made there, with a sweep and a gate beside it."""
    folder = tmp_path_factory.mktemp("other")
    for name, text in (("small.toml", SEQUENCE), ("sweep.toml", SWEEP), ("gate.toml", GATE)):
        (folder / name).write_text(text, encoding="utf-8")
    done = started([*COMMAND, *STUDY, "run"], WITHOUT, cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_the_facilities_are_gone():
    code = "import os, multiprocessing as m; print(hasattr(os, 'sched_getaffinity'), m.get_start_method())"
    assert started([sys.executable, "-c", code], WITHOUT).stdout.split() == ["False", "spawn"]
    code = "import metrics.machine as m; exec('import resource', {'__name__': 'metrics.x'})"
    assert "No module named 'resource'" in started([sys.executable, "-c", code], WITHOUT).stderr


def test_a_study_has_the_pictures_of_linux(folder):
    assert started([*COMMAND, *STUDY, "here"], os.environ, cwd=folder).returncode == 0
    assert pixels(folder / "here") == pixels(folder / "run")
    assert entries(folder / "here" / "scores.json") == entries(folder / "run" / "scores.json")


COMMANDS = [
    (["doctor"], 0),
    (["measure", "run"], 0),
    (["measure", *OWN], 0),
    (["report", "run"], 0),
    (["report", "run", "--folder", "-o", "page"], 0),
    (["gate", "gate.toml", "run"], 1),
    (["info", "run"], 0),
    (["list", "techniques"], 0),
]


def test_commands_work(folder):
    found = in_turn([words for words, _ in COMMANDS], folder, WITHOUT)
    for (words, code), said in zip(COMMANDS, found, strict=True):
        assert said.code == code, (words, said.err)
        assert b"Traceback" not in said.err, words


def test_the_demo_works(folder):
    """Smaller than it is, for its time; what it is made of is the same."""
    code = "from swimlab.cli import demo_command as demo; demo.SIZE, demo.FRAMES = '64x36', '0-3'; demo.demo_command()"
    done = started([sys.executable, "-c", code], WITHOUT, cwd=folder)
    assert done.returncode == 0, done.stderr


def test_a_page_that_a_viewer_holds_open_is_named(folder):
    """The viewer is a file that the same process opened: of others nothing is known here."""
    page = folder / "run" / "report.html"
    before = page.read_bytes()
    code = f"from swimlab.cli.main import main; held = open({str(page)!r}, 'rb'); main()"
    done = started([sys.executable, "-c", code, "report", "run"], WITHOUT, cwd=folder)
    assert done.returncode == 2
    assert "report.html: cannot be replaced, it is open in another program" in done.stderr
    assert page.read_bytes() == before


def test_a_sweep_survives_the_loss_of_a_worker(folder):
    words = [*COMMAND, "sweep", "sweep.toml", "--engine", "dask", "--threads", "1", "-o", "swept", "-q"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    killed = []
    with subprocess.Popen(words, cwd=folder, env=WITHOUT, **pipes) as sweep:
        while sweep.poll() is None:
            for begun in [] if killed else (folder / "swept").glob("chunks/*/.*.tmp"):
                killed.append(int(begun.name.split(".")[-2]))
                psutil.Process(killed[0]).kill()
                break
            time.sleep(0.005)
        out, err = sweep.communicate()
    assert sweep.returncode == 0, err
    assert len(killed) == 1
    assert not list((folder / "swept").rglob("*.tmp"))
    scores = json.loads((folder / "swept" / "scores.json").read_text(encoding="utf-8"))
    assert [entry["technique"] for entry in scores["sequences"]] == ["pixel-point"]
    assert out.strip()
