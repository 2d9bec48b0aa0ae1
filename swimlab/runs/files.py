"""Writing files so that none is ever half there: a temporary file first, then a rename."""

import json
import os
import re
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

TEMPORARY, OLD = "tmp", "old"


def temporary_path(path: Path, kind: str = TEMPORARY) -> Path:
    """Where `path` is written until it is whole: its own for every process of every machine."""
    return path.with_name(f".{path.name}.{socket.gethostname()}.{os.getpid()}.{kind}")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well and vanishes when it does not.

    Raises PermissionError naming `path` where another program holds it open, as on Windows; `path` is then as it was.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_path(path)
    try:
        yield temporary
        with _naming(path):
            temporary.replace(path)
    except BaseException:
        with suppress(FileNotFoundError):
            temporary.unlink()
        raise


@contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """As `replacing`, for a new folder: what it takes the place of is gone only once it is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary, old = temporary_path(path), temporary_path(path, OLD)
    # In a container every process may have the number of the killed one whose folder this is.
    shutil.rmtree(temporary, ignore_errors=True)
    temporary.mkdir()
    try:
        yield temporary
        with _naming(path):
            if path.exists():
                path.rename(old)
            temporary.rename(path)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        if old.exists() and not path.exists():
            old.rename(path)
        raise
    shutil.rmtree(old, ignore_errors=True)


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    try:
        yield
    except PermissionError as error:
        raise PermissionError(
            f"{path}: cannot be replaced, it is open in another program; close it there and give the command again"
        ) from error


def clear_leftovers(folder: Path, of: str | None = None) -> None:
    """Remove the temporary files and folders below a folder that killed processes of this machine left.

    of: only what was to become a file or folder of this name, directly in `folder`; None: everything below it.

    What a process that still runs is writing stays, and so does what other machines that share the folder write. A
    folder whose replacement was killed half-way gets its old content back. What another program holds open, as a
    virus scanner does on Windows, stays for the next run.
    """
    from metrics.machine import process_exists  # metrics is heavy

    host = re.escape(socket.gethostname())
    name = re.compile(rf"\.(?P<name>.+)\.{host}\.(?P<process>\d+)\.(?P<kind>{TEMPORARY}|{OLD})")
    there = folder.rglob(".*") if of is None else folder.glob(".*")
    for path in list(there):
        found = name.fullmatch(path.name)
        if found is None or of not in (None, found["name"]) or process_exists(int(found["process"])):
            continue
        target = path.with_name(found["name"])
        with suppress(PermissionError):
            if found["kind"] == OLD and not target.exists():
                path.rename(target)
            elif path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write text in UTF-8 with line feeds. Raises PermissionError as `replacing` does.

    Under a locale that is not UTF-8 Python holds the bytes of a file's name as lone surrogates. They are written as
    they were, which is UTF-8 again.
    """
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", errors="surrogateescape", newline="\n")


def write_json(path: Path, data: Any) -> None:
    """Write JSON, indented. Raises ValueError on NaN and Inf, which JSON does not have."""
    write_text(path, json.dumps(data, indent=1, allow_nan=False, ensure_ascii=False) + "\n")
