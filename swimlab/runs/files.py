"""Writing files so that none is ever half there: a temporary file first, then a rename."""

import json
import os
import re
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import ENOTDIR
from pathlib import Path
from typing import Any

TEMPORARY, OLD = "tmp", "old"


def temporary_path(path: Path, kind: str = TEMPORARY) -> Path:
    """Where `path` is written until it is whole: its own for every process of every machine."""
    return path.with_name(f".{path.name}.{socket.gethostname()}.{os.getpid()}.{kind}")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well and vanishes when it does not.

    Raises OSError naming `path` where it cannot be written, PermissionError where another program holds it open, as on
    Windows; `path` is then as it was.
    """
    temporary = temporary_path(path)
    with writing(path, temporary):
        path.parent.mkdir(parents=True, exist_ok=True)
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
    temporary, old = temporary_path(path), temporary_path(path, OLD)
    with writing(path, temporary):
        path.parent.mkdir(parents=True, exist_ok=True)
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
def writing(path: Path, temporary: Path) -> Iterator[None]:
    """Say of `path` what goes wrong with `temporary`, what is in it or the folders of `path`, and of a full disk."""
    try:
        yield
    except OSError as error:
        if error.errno is None or not _is_of(error.filename, path, temporary):
            raise
        at_fault = next((each for each in path.parents if each.exists() and not each.is_dir()), None)
        why = f"{at_fault} is a file, not a folder" if at_fault is not None else error.strerror
        said = str(why) if str(why).startswith(UNWRITTEN) else f"{UNWRITTEN}: {why}"
        raise OSError(error.errno, said, str(path)) from error


def check_writable(folder: Path) -> None:
    """Raise OSError with the reason where a folder, which need not be there, cannot be written; nothing is left."""
    there = next(each for each in (folder, *folder.parents) if each.exists())
    if not there.is_dir():
        raise NotADirectoryError(ENOTDIR, f"{there} is a file, not a folder", str(folder))
    attempt = temporary_path(there / "output")
    attempt.touch()
    attempt.unlink()


UNWRITTEN = "cannot be written"


def _is_of(name: object, path: Path, temporary: Path) -> bool:
    """Whether an error's file is one that is written; a disk that is full tells no name."""
    if not isinstance(name, str | os.PathLike):
        return name is None
    concerned = Path(name)
    return concerned in (temporary, *path.parents) or temporary in concerned.parents


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
