"""Commands print a whole result on a stream of any encoding.

An interpreter gets its encodings when it starts, and starting one costs more than most commands: each encoding has one
interpreter, which runs all commands in turn.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from one_interpreter import Said, in_turn

MAIN = [sys.executable, "-c", "from swimlab.cli.main import main; main()"]
SHOW = "from swimlab.cli.encoding import make_streams_safe; make_streams_safe(); "
SHOW += "print('caf\\u00e9 \\u2191 \\u2248 1 \\u03c3 \\u732b')"
SETTINGS = {
    "cp1252": {"PYTHONIOENCODING": "cp1252"},
    "cp932": {"PYTHONIOENCODING": "cp932"},
    "ascii": {"PYTHONIOENCODING": "ascii"},
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
}


def _run(words: list[str], settings: dict[str, str]) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(words, env=os.environ | settings, capture_output=True, check=False)


def test_what_ascii_lacks_is_written_plainly() -> None:
    assert (
        _run([sys.executable, "-c", SHOW], {"PYTHONIOENCODING": "ascii"}).stdout.split()
        == b"cafe up ~ 1 sigma ?".split()
    )


def test_a_file_gets_the_whole_table(tmp_path: Path) -> None:
    with (tmp_path / "list.txt").open("wb") as file:
        subprocess.run([*MAIN, "list", "metrics"], env=os.environ | SETTINGS["cp1252"], stdout=file, check=True)
    assert "budget.flicker" in (tmp_path / "list.txt").read_text(encoding="cp1252")


def test_a_closed_pipe_is_not_a_failed_gate() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    result = subprocess.run([*MAIN, "list", "metrics"], stdout=writing, stderr=subprocess.PIPE, check=False)
    os.close(writing)
    assert (result.returncode, result.stderr) == (2, b"")


GATE = """
version = 1
[[rule]]
metric = "budget.mse"
max = 10.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study and a gate in a folder whose names need more than ASCII."""
    folder = tmp_path_factory.mktemp("caf\u00e9 [1] 100% \u732b")
    (folder / "gate.toml").write_text(GATE, encoding="utf-8-sig", newline="\r\n")
    words = [
        "study",
        "road-shift",
        "-t",
        "pixel-point,pixel-aniso,reference",
        "--size",
        "64x36",
        "--frames",
        "0-3",
        "--samples",
        "4",
        "-o",
    ]
    subprocess.run([*MAIN, *words, "run \u00e9#1"], cwd=folder, check=True, capture_output=True)
    return folder


RESULTS = {
    "list metrics": (["list", "metrics"], "budget.flicker"),
    "info": (["info", "road-shift"], "road-shift"),
    "help": (["--help"], "measure"),
    "measure": (["measure", "run \u00e9#1"], "pixel-aniso"),
    "compare": (["compare", "run \u00e9#1", "run \u00e9#1", "--metric", "*"], "standard errors"),
    "gate": (["gate", "gate.toml", "run \u00e9#1"], "passed"),
    "report": (["report", "run \u00e9#1"], "report.html"),
    "measure frames": (
        ["measure", "--test", "run \u00e9#1/pixel-point/####.exr", "--motion", "0.71875,0.59375"],
        "test",
    ),
    "doctor": (["doctor"], "stdout"),
    "no gate": (["gate", "none\u2191.toml", "x"], ""),
}
"""Words of commands, and what is to be found on stdout; nothing where the command fails."""


@pytest.fixture(scope="module")
def said(folder: Path) -> Callable[[str], dict[str, Said]]:
    """What every command said, by its name, in one of SETTINGS."""

    @cache
    def said(encoding: str) -> dict[str, Said]:
        found = in_turn([words for words, _ in RESULTS.values()], folder, SETTINGS[encoding])
        return dict(zip(RESULTS, found, strict=True))

    return said


@pytest.mark.parametrize("encoding", SETTINGS)
@pytest.mark.parametrize("name", RESULTS)
def test_results_are_whole(said: Callable[[str], dict[str, Said]], name: str, encoding: str) -> None:
    result = RESULTS[name][1]
    code, out, err = said(encoding)[name]
    assert code == (0 if result else 2), err
    assert result.encode() in out
    assert bool(out) == bool(result)
    assert b"codec" not in err


@pytest.mark.parametrize("file", ["run.json", "scores.json"])
def test_files_of_a_run_are_read_as_windows_editors_write_them(folder: Path, tmp_path: Path, file: str) -> None:
    copy = tmp_path / "run"
    shutil.copytree(folder / "run \u00e9#1", copy)
    text = (copy / file).read_text(encoding="utf-8")
    (copy / file).write_text(text, encoding="utf-8-sig", newline="\r\n")
    found = subprocess.run([*MAIN, "gate", str(folder / "gate.toml"), str(copy)], capture_output=True, check=False)
    assert found.returncode == 0, found.stderr
