"""Techniques and reflectance models by name, found in their folders."""

import hashlib
import os
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

import swimlab.render.brdfs
import swimlab.render.techniques
from metrics.plugins import added, discover, extend, retract
from sequences import Sequence
from sequences.names import check_name
from swimlab.render.brdf import Brdf, Model
from swimlab.render.settings import Settings
from swimlab.render.technique import Technique
from swimlab.runs.record import PARTS

FOLDERS = "SWIMLAB_TECHNIQUES"
"""Environment variable: folders with your own techniques, separated as in PATH."""


@cache
def techniques() -> dict[str, Technique]:
    """Every technique by its name, including the ones in the folders of SWIMLAB_TECHNIQUES.

    Raises ValueError as `add_techniques` does; it names SWIMLAB_TECHNIQUES where the fault is in these folders.
    """
    given = os.environ.get(FOLDERS, "")
    try:
        for folder in filter(None, given.split(os.pathsep)):
            _extend(Path(folder))
        found = discover(swimlab.render.techniques, "TECHNIQUE")
        for module in added(swimlab.render.techniques):
            _code(module)
        _check_case(found)
        return found
    except ValueError as error:
        if not given:
            raise
        raise ValueError(f"{FOLDERS}={given}: {error}; mend the file, or unset the variable") from error


def add_techniques(folder: str | Path) -> list[str]:
    """Add the techniques in a folder of your own, one a file; return their names.

    A folder that is added again is read again. Raises ValueError as `extend` and `discover` do, and naming a file that
    fails, defines no technique, or one whose name cannot be that of a folder in a run; the folder is then not added.
    """
    try:
        names = _extend(Path(folder))
        techniques.cache_clear()
        techniques()
    except BaseException:
        retract(swimlab.render.techniques, Path(folder))
        techniques.cache_clear()
        raise
    return sorted(names)


def _extend(folder: Path) -> list[str]:
    """Let the techniques in a folder be found; their names. Raises ValueError naming the file that is at fault."""
    names = []
    for module in extend(swimlab.render.techniques, folder):
        path = folder / f"{module.rpartition('.')[2]}.py"
        try:
            names.append(_check(import_module(module).TECHNIQUE))
        except Exception as error:  # whatever your own code raises
            kind = "" if type(error) is ValueError else f"{type(error).__name__}: "
            raise ValueError(f"{path}: {kind}{error}") from error
    return names


def _check(technique: object) -> str:
    """The name of what a file defines as TECHNIQUE, by which its folder in a run is called. Raises ValueError."""
    if not isinstance(technique, Technique):
        raise ValueError("TECHNIQUE is no Technique; swimlab.render's docstring has an example")
    if technique.name.casefold() in PARTS:
        raise ValueError(f"{technique.name!r} is what a run calls a part of its own: name the technique otherwise")
    return check_name(technique.name, "a technique")


def _check_case(names: Iterable[str]) -> None:
    """Raise ValueError where names would be those of one folder on systems that take no heed of case."""
    known: dict[str, str] = {}
    for name in names:
        if (other := known.setdefault(name.casefold(), name)) != name:
            raise ValueError(f"{other!r} and {name!r}: techniques differ by more than case; name one otherwise")


def own_code() -> dict[str, str]:
    """Your own technique -> hash of its file as it was when it was read."""
    techniques()
    return {module.TECHNIQUE.name: _code(module) for module in added(swimlab.render.techniques)}


@cache
def _code(module: ModuleType) -> str:
    return hashlib.sha256(Path(str(module.__file__)).read_bytes()).hexdigest()[:16]


@cache
def brdfs() -> dict[str, Brdf]:
    """Every reflectance model by its name."""
    return discover(swimlab.render.brdfs, "BRDF")


def model_of(sequence: Sequence) -> Model:
    """The reflectance model of a sequence's material, with its parameters."""
    material = sequence.scene.material
    brdf = brdfs()[material.brdf]
    return brdf.model(brdf.settings.model_validate(material.parameters))


def brdf_settings() -> dict[str, type[Settings]]:
    """The parameters of every reflectance model, to check sequence files by."""
    return {name: brdf.settings for name, brdf in brdfs().items()}


def technique_settings() -> dict[str, type[Settings]]:
    """The settings of every technique, to check sequence files by."""
    return {name: technique.settings for name, technique in techniques().items()}
