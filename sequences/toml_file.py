"""Reading a TOML file, with errors that name it and say how to mend it."""

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any


class TomlError(ValueError):
    """A file that cannot be read as TOML; the message names it and says why."""


def read_toml(path: Path, *, syntax: str, unreadable: str) -> dict[str, Any]:
    """The content of a TOML file: UTF-8, with or without a byte order mark, lines ending in LF or CRLF.

    syntax: what is often forgotten in this kind of file. unreadable: what follows the reason where it cannot be opened.
    Raises TomlError.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except tomllib.TOMLDecodeError as error:
        raise TomlError(f"{path}: not TOML: {error} ({syntax})") from None
    except UnicodeDecodeError as error:
        raise TomlError(f"{path}: not UTF-8 text: {error.reason} at byte {error.start}") from None
    except OSError as error:
        raise TomlError(f"{path}: cannot be read: {error.strerror}{unreadable}") from None


def change(data: dict[str, Any], changes: Mapping[str, Any], path: Path) -> None:
    """Put values in the place of a file's, by dotted key, as {"camera.fov": 40.0}. Raises TomlError naming the file."""
    for dotted, value in changes.items():
        table = data
        *tables, key = dotted.split(".")
        for name in tables:
            table = table.setdefault(name, {})
            if not isinstance(table, dict):
                raise TomlError(f"{path}: {dotted}: {name} is not a table")
        table[key] = deepcopy(value)
