"""The OpenColorIO configuration that `$OCIO` names, as a hash of what it is made of."""

import os
import re
from pathlib import Path
from typing import NamedTuple

from swimlab.runs.hashes import hash_file, hash_of

UNTOLD = (
    "$OCIO: depends on more than its own files, so that it cannot be told which scores are there; give a configuration "
    "without variables, or measure one by one"
)
"""What is said where scores cannot be named by what they are made of."""

_BUILT_IN = "ocio://"


class Configuration(NamedTuple):
    """digest: of its text, its files and OpenColorIO's variables. whole: whether it depends on nothing else."""

    digest: str
    whole: bool


def configuration() -> Configuration | None:
    """What `$OCIO` names; None where it is not set: the built-in one is a part of OpenImageIO.

    It is not whole where it cannot be read, names files by variables of its own, or names one that is not found.
    """
    variables = {name: value for name, value in os.environ.items() if name.startswith("OCIO")}
    if not variables:
        return None
    named = variables.pop("OCIO", "")
    if not named or named.startswith(_BUILT_IN):
        return Configuration(hash_of([named, variables]), whole=True)
    path = Path(named)
    try:
        # An archive holds its files.
        text = "" if path.suffix == ".ocioz" else path.read_text(encoding="utf-8", errors="replace")
        files = _files(path.parent, text)
        digests = [hash_file(each) for each in (path, *(files or ()))]
    except OSError:
        return Configuration(hash_of([named, variables]), whole=False)
    return Configuration(hash_of([digests, variables]), whole=files is not None)


def _files(folder: Path, text: str) -> list[Path] | None:
    """The files of look-up tables that a configuration names, in order; None where they cannot all be told."""
    named = [re.search(r"\bsrc:\s*([^,}\n]+)", each) for each in re.findall(r"<FileTransform>\s*\{([^}]*)\}", text)]
    if re.search(r"\$|%\w+%", text) or len(named) != text.count("FileTransform>") or None in named:
        return None
    searched = re.search(r"^search_path:(.*(?:\n\s*-.*)*)", text, re.MULTILINE)
    places = re.split(r"[:\n]", searched[1]) if searched else []
    folders = [folder / bare for place in places if (bare := _bare(place))] or [folder]
    names = dict.fromkeys(_bare(each[1]) for each in named if each)
    found = {name: [path for place in folders if (path := place / name).is_file()] for name in names}
    return [path for paths in found.values() for path in paths] if all(found.values()) else None


def _bare(word: str) -> str:
    """A word of YAML without what stands about it."""
    return word.strip(" -\"'[]\r")
