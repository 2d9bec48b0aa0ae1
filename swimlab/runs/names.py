"""Names that are read from files and become part of a path: none may lead out of the folder that it is put into."""

import re
from pathlib import Path

_OTHERS = re.compile(r"[^\w .,+=@()-]")
"""Characters that a file's name cannot have on every system."""


def check_part(name: str, of: str) -> str:
    """The name, where it is one part of a path and stays in its folder. of: "sequence". Raises ValueError."""
    if name in ("", "..") or Path(name).name != name:
        raise ValueError(f"{of} {name!r} is no name, it leads to another folder")
    return name


def file_name(*parts: str) -> str:
    """Parts joined by dashes to what a file can be called on every system."""
    return _OTHERS.sub("_", "-".join(parts))
