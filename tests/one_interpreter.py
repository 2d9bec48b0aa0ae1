"""Several commands in one interpreter, one after the other: to start one costs more than most commands do."""

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

IN_TURN = """
import sys
from swimlab.cli.main import main
given, end = sys.argv[1:], "//"
while given:
    at = given.index(end)
    sys.argv, given, code = ["swimlab", *given[:at]], given[at + 1 :], 0
    try:
        main()
    except SystemExit as error:
        code = error.code or 0
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
        stream.buffer.write(b"\\0%d\\0" % code)
        stream.flush()
"""
"""Runs the commands that its words name, each ended by `//`, and writes each one's exit code behind what it said."""


class Said(NamedTuple):
    """How a command ended, and what it wrote."""

    code: int
    out: bytes
    err: bytes


def in_turn(commands: Sequence[Sequence[str]], folder: Path, settings: Mapping[str, str]) -> list[Said]:
    """Run commands, each the words behind `swimlab`, in a folder; settings: of the environment, beside this one's."""
    words = [word for command in commands for word in (*command, "//")]
    run = [sys.executable, "-c", IN_TURN, *words]
    done = subprocess.run(run, cwd=folder, env=os.environ | settings, capture_output=True, check=True)
    out, err = (stream.split(b"\0")[:-1] for stream in (done.stdout, done.stderr))
    return [Said(int(code), *said) for code, *said in zip(out[1::2], out[::2], err[::2], strict=True)]
