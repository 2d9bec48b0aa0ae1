"""Files are whole or not there, and what a killed process left is cleaned."""

import errno
import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from swimlab.render.plan import make_plan
from swimlab.render.run import render_run
from swimlab.runs.files import clear_leftovers, replacing, replacing_folder, temporary_path, write_json, write_text

KILLED = """
import os, signal, sys
from pathlib import Path
from swimlab.runs.files import replacing, replacing_folder
with {how}(Path(sys.argv[1])) as temporary:
    (temporary / "half" if temporary.is_dir() else temporary).write_text("half")
    print("ready", flush=True)
    sys.stdin.read()
"""


def kill_while_writing(path, how):
    """What a process that is killed while it writes `path` leaves."""
    command = [sys.executable, "-c", KILLED.format(how=how), str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "ready\n"
        process.kill()
    left = list(path.parent.glob(".*.tmp"))
    assert len(left) == 1
    assert not path.exists()
    return left[0]


@pytest.mark.parametrize("how", ["replacing", "replacing_folder"])
def test_what_a_killed_process_left_is_cleaned(tmp_path, how):
    left = kill_while_writing(tmp_path / "deep" / "a.b", how)
    clear_leftovers(tmp_path, "a.b")
    assert left.exists()
    clear_leftovers(tmp_path)
    assert not left.exists()


def test_the_next_run_over_the_folder_cleans_it(tmp_path):
    left = kill_while_writing(tmp_path / "run" / "pixel-point" / "0000.exr", "replacing")
    render_run(make_plan("road-shift", ["pixel-point"], size=(16, 9), frames="1"), tmp_path / "run")
    assert not left.exists()


def test_what_others_are_writing_stays(tmp_path):
    host, own = socket.gethostname(), os.getpid()
    others = [f".a.{host}.{own}.tmp", ".a.another-host.999999999.tmp", ".a.tmp", ".gitignore", "a.tmp"]
    for name in others:
        (tmp_path / name).touch()
    clear_leftovers(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(others)


def test_a_folder_whose_replacement_was_killed_gets_its_content_back(tmp_path):
    (tmp_path / f".page.{socket.gethostname()}.999999999.old").mkdir()
    clear_leftovers(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["page"]


def test_what_is_left_and_held_open_stays_for_the_next_run(tmp_path, monkeypatch):
    left = tmp_path / f".a.{socket.gethostname()}.999999999.tmp"
    left.touch()

    def refuse(self, missing_ok=False):
        raise PermissionError(13, "The process cannot access the file")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", refuse)
        clear_leftovers(tmp_path)
    assert left.exists()
    clear_leftovers(tmp_path)
    assert not left.exists()


def test_a_folder_left_by_a_killed_process_of_the_same_number_is_replaced(tmp_path):
    left = temporary_path(tmp_path / "page")
    left.mkdir()
    (left / "half").touch()
    with replacing_folder(tmp_path / "page") as new:
        (new / "whole").touch()
    assert [path.name for path in tmp_path.rglob("*")] == ["page", "whole"]


@pytest.mark.parametrize("how", [replacing, replacing_folder])
def test_what_another_program_holds_open_is_named_and_kept(tmp_path, monkeypatch, how):
    """As on Windows, where a file that is open cannot be replaced."""
    target = tmp_path / "report"
    target.mkdir() if how is replacing_folder else target.write_text("before", encoding="utf-8")

    def refuse(self, to):
        raise PermissionError(13, "The process cannot access the file")

    monkeypatch.setattr(Path, "replace", refuse)
    monkeypatch.setattr(Path, "rename", refuse)
    with (
        pytest.raises(PermissionError, match=r"report: cannot be replaced, it is open in another program"),
        how(target) as new,
    ):
        (new / "page" if new.is_dir() else new).write_text("after", encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["report"]
    assert target.is_dir() or target.read_text(encoding="utf-8") == "before"


@pytest.mark.parametrize("how", [replacing, replacing_folder])
@pytest.mark.parametrize("deep", ["x", "x/y"])
def test_a_file_in_the_way_is_named_with_what_was_to_be_written(tmp_path, how, deep):
    (tmp_path / "x").write_text("in the way", encoding="utf-8")
    target = tmp_path / deep / "out"
    with pytest.raises(OSError, match="cannot be written") as raised, how(target):
        pytest.fail("nothing can be written there")
    assert raised.value.filename == str(target)
    assert raised.value.strerror == f"cannot be written: {tmp_path / 'x'} is a file, not a folder"


def test_errors_inside_name_what_was_asked_for_and_keep_their_kind(tmp_path):
    """Also where one file is written by way of another; what is only read keeps its own name."""
    target = tmp_path / "a"
    with pytest.raises(PermissionError) as raised, replacing(target) as outer, replacing(outer) as inner:
        raise PermissionError(errno.EACCES, "Permission denied", str(inner))
    assert (raised.value.filename, raised.value.strerror) == (str(target), "cannot be written: Permission denied")
    with pytest.raises(OSError, match="cannot be written: No space") as raised, replacing_folder(target):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert raised.value.filename == str(target)
    with pytest.raises(FileNotFoundError) as raised, replacing(target):
        raise FileNotFoundError(errno.ENOENT, "No such file or directory", "source")
    assert raised.value.filename == "source"
    assert list(tmp_path.iterdir()) == []


def test_names_of_files_are_written_in_utf_8_under_every_locale(tmp_path):
    """Under a locale of ASCII the two bytes of an e with an accent are two lone surrogates."""
    name = "caf\u00e9".encode().decode("ascii", "surrogateescape")
    write_json(tmp_path / "a.json", {"command": f"swimlab measure {name}"})
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8")) == {"command": "swimlab measure caf\u00e9"}


def test_text_has_line_feeds_on_every_system(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "linesep", "\r\n")
    write_text(tmp_path / "a.txt", "one\ntwo\n")
    assert (tmp_path / "a.txt").read_bytes() == b"one\ntwo\n"
    assert temporary_path(tmp_path / "a.txt").parent == tmp_path
