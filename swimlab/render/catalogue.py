"""Techniques and reflectance models by name, found in their folders."""

import hashlib
import os
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

import swimlab.render.brdfs
import swimlab.render.techniques
from metrics.plugins import added, discover, extend, retract
from sequences import Sequence
from swimlab.render.brdf import Brdf, Model
from swimlab.render.settings import Settings
from swimlab.render.technique import Technique

FOLDERS = "SWIMLAB_TECHNIQUES"
"""Environment variable: folders with your own techniques, separated as in PATH."""


@cache
def techniques() -> dict[str, Technique]:
    """Every technique by its name, including the ones in the folders of SWIMLAB_TECHNIQUES.

    Raises ValueError as `extend` and `discover` do; it names SWIMLAB_TECHNIQUES where the fault is in these folders.
    """
    given = os.environ.get(FOLDERS, "")
    try:
        for folder in filter(None, given.split(os.pathsep)):
            extend(swimlab.render.techniques, Path(folder))
        found = discover(swimlab.render.techniques, "TECHNIQUE")
        for module in added(swimlab.render.techniques):
            _code(module)
        return found
    except (ValueError, SyntaxError, ImportError, AttributeError) as error:
        if not given:
            raise
        raise ValueError(f"{FOLDERS}={given}: {error}; mend the file, or unset the variable") from error


def add_techniques(folder: str | Path) -> list[str]:
    """Add the techniques in a folder of your own, one a file; return their names.

    A folder that is added again is read again. Raises ValueError as `extend` and `discover` do; the folder is then not
    added.
    """
    modules = extend(swimlab.render.techniques, Path(folder))
    techniques.cache_clear()
    try:
        techniques()
    except BaseException:
        retract(swimlab.render.techniques, Path(folder))
        techniques.cache_clear()
        raise
    return sorted(import_module(module).TECHNIQUE.name for module in modules)


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
