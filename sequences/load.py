"""Sequence files: from TOML, and as a JSON schema for editors."""

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.json_schema import models_json_schema

from .problems import SequenceError, describe, hint
from .scene import Material
from .sequence import Sequence
from .toml_file import TomlError, change, read_toml

Settings = Mapping[str, type[BaseModel]]


def library() -> dict[str, Path]:
    """Sequence files that come with the package, by name, in alphabetical order."""
    folder = Path(str(files(__package__))) / "library"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load(
    name_or_path: str | Path,
    *,
    technique_settings: Settings | None = None,
    brdfs: Settings | None = None,
    changes: Mapping[str, Any] | None = None,
) -> Sequence:
    """The sequence of a name in the library or of a `.toml` file. Map files are not read.

    `technique_settings` are the known techniques with the model of their settings, `brdfs` the known
    reflectance models with that of their parameters; what is not given is not checked. `changes` are values
    that take the place of the file's, by dotted key, as `{"camera.fov": 40.0}`. Raises SequenceError
    with every problem at once, each as `file: key.path: what is wrong (hint)`.
    """
    path = _find(name_or_path)
    data = _read(path)
    try:
        change(data, changes or {}, path)
    except TomlError as error:
        raise SequenceError([str(error)]) from None
    problems: list[str] = []
    sequence = None
    try:
        sequence = Sequence.model_validate(data, context={"folder": path.parent.resolve()})
    except ValidationError as error:
        problems += describe(error, Sequence)
    if technique_settings is not None:
        problems += _technique_problems(data.get("techniques"), technique_settings)
    if brdfs is not None:
        problems += _brdf_problems(data, brdfs)
    if sequence is None or problems:
        raise SequenceError(f"{path}: {problem}" for problem in problems)
    return sequence


def schema(technique_settings: Settings | None = None) -> dict[str, Any]:
    """JSON schema (2020-12) of a sequence file; with the settings of the techniques if they are given."""
    settings = dict(technique_settings or {})
    models: list[type[BaseModel]] = list(dict.fromkeys((Sequence, *settings.values())))
    references, shared = models_json_schema([(model, "validation") for model in models])
    definitions = shared["$defs"]

    def name_of(model: type[BaseModel]) -> str:
        return str(references[model, "validation"]["$ref"]).removeprefix("#/$defs/")

    root = definitions.pop(name_of(Sequence))
    if technique_settings is not None:
        techniques = root["properties"]["techniques"]
        techniques["properties"] = {name: {"$ref": f"#/$defs/{name_of(model)}"} for name, model in settings.items()}
        techniques["additionalProperties"] = False
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **root, "$defs": definitions}


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix == ".toml":
        return path
    known = library()
    if str(name_or_path) not in known:
        what = f"{name_or_path}: no such sequence {hint(str(name_or_path), known)}"
        raise SequenceError([f"{what}; a file of your own has to end in .toml"])
    return known[str(name_or_path)]


def _read(path: Path) -> dict[str, Any]:
    known = f" (the library has {', '.join(library())})"
    try:
        return read_toml(path, syntax="text needs quotes, a table is a [name] line", unreadable=known)
    except TomlError as error:
        raise SequenceError([str(error)]) from None


def _technique_problems(given: Any, known: Settings) -> list[str]:
    problems: list[str] = []
    for name, settings in given.items() if isinstance(given, dict) else ():
        if name not in known:
            problems.append(f"techniques.{name}: unknown technique {hint(name, known)}")
        else:
            problems += _settings_problems(settings, known[name], prefix=f"techniques.{name}.")
    return problems


def _brdf_problems(data: dict[str, Any], known: Settings) -> list[str]:
    table: Any = data
    for key in ("scene", "material"):
        table = table.get(key, {}) if isinstance(table, dict) else None
    if not isinstance(table, dict):
        return []
    name = table.get("brdf", Material.model_fields["brdf"].default)
    if not isinstance(name, str):
        return []
    if name not in known:
        return [f"scene.material.brdf: there is no {name!r} {hint(name, known)}"]
    return _settings_problems(table.get("parameters"), known[name], prefix="scene.material.parameters.")


def _settings_problems(given: Any, settings: type[BaseModel], *, prefix: str) -> list[str]:
    if not isinstance(given, dict):
        return []
    try:
        settings.model_validate(given)
    except ValidationError as error:
        return describe(error, settings, prefix=prefix)
    return []
