"""Commands print a whole result on a stream of any encoding."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

MAIN = [sys.executable, "-c", "from swimlab.cli.main import main; main()"]
SHOW = "from swimlab.cli.encoding import make_streams_safe; make_streams_safe(); "
SHOW += "print('caf\\u00e9 \\u2191 \\u2248 1 \\u03c3 \\u732b')"
ENCODINGS = [
    {"PYTHONIOENCODING": "cp1252"},
    {"PYTHONIOENCODING": "cp932"},
    {"PYTHONIOENCODING": "ascii"},
    {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
]


def _run(words: list[str], settings: dict[str, str]) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(words, env=os.environ | settings, capture_output=True, check=False)


@pytest.mark.parametrize("settings", ENCODINGS, ids=str)
@pytest.mark.parametrize(
    "words", [["list", "metrics"], ["info", "road-shift"], ["--help"], ["gate", "none\u2191.toml", "x"]]
)
def test_a_command_ends_as_it_does_on_a_utf8_stream(words: list[str], settings: dict[str, str]) -> None:
    expected, found = _run(MAIN + words, {"PYTHONIOENCODING": "utf-8"}), _run(MAIN + words, settings)
    assert found.returncode == expected.returncode
    assert b"codec" not in found.stderr
    assert bool(found.stdout) == bool(expected.stdout)


def test_what_ascii_lacks_is_written_plainly() -> None:
    assert (
        _run([sys.executable, "-c", SHOW], {"PYTHONIOENCODING": "ascii"}).stdout.split()
        == b"cafe up ~ 1 sigma ?".split()
    )


def test_a_file_gets_the_whole_table(tmp_path: Path) -> None:
    with (tmp_path / "list.txt").open("wb") as file:
        subprocess.run([*MAIN, "list", "metrics"], env=os.environ | ENCODINGS[0], stdout=file, check=True)
    assert "budget.flicker" in (tmp_path / "list.txt").read_text(encoding="cp1252")


def test_a_closed_pipe_is_not_a_failed_gate() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    result = subprocess.run([*MAIN, "list", "metrics"], stdout=writing, stderr=subprocess.PIPE, check=False)
    os.close(writing)
    assert (result.returncode, result.stderr) == (2, b"")
