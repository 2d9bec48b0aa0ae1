"""Sweep files: what is varied, and over which sequences and techniques."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr, ValidationError

from metrics.display import Domain
from sequences.names import LONGEST, NAME
from sequences.problems import describe, hint
from sequences.sequence import Side
from sequences.table import Table, Whole
from sequences.toml_file import TomlError, read_toml
from swimlab.render.catalogue import techniques
from swimlab.runs.record import REFERENCE

SET_ELSEWHERE = {"version": "is not for a sweep to vary", "name": "is made from what is varied"}


class SweepError(ValueError):
    """A sweep that cannot be run; the message names the file, the key and how to mend it."""


class Sweep(Table):
    """A sweep file, version 1."""

    version: Literal[1] = Field(description="version of the file format: 1")
    name: str = Field(pattern=NAME, max_length=LONGEST, description="name of the sweep")
    sequences: list[str] = Field(
        min_length=1, description="names in the library, or .toml files beside this one; or shot files"
    )
    techniques: list[str] = Field(
        min_length=1, description="techniques by name, the reference is always rendered; or builds of shots"
    )
    frames: str | None = Field(None, description="frames as '0-31' or '3,5'; all of each sequence where left out")
    size: tuple[Side, Side] | None = Field(None, description="width and height in pixels; else each sequence's")
    samples: Whole = Field(64, description="samples a pixel of the reference, a square number")
    chunk: Whole = Field(8, ge=1, description="frames a chunk, the piece of work that is done or lost as a whole")
    domain: Domain = Field("linear", description="what is measured: linear radiance, or display codes")
    grid: dict[str, Annotated[list[Any], Field(min_length=1)]] = Field(
        {}, description="values by dotted key of the sequence or shot file; every combination is measured"
    )

    _path: Path = PrivateAttr(default=Path())

    def place(self, source: str) -> str:
        """Where one of the sequences is: a name in the library, or a path."""
        return str(self.path.parent / source) if source.endswith(".toml") else source

    @property
    def path(self) -> Path:
        """The sweep file; sequence files are relative to its folder."""
        return self._path

    def names(self) -> tuple[str, ...]:
        """The techniques in the order of the catalogue, the reference among them."""
        return tuple(name for name in techniques() if name in {*self.techniques, REFERENCE})


def load_sweep(path: Path) -> Sweep:
    """Read a sweep file. Raises SweepError with every problem of its form, each as `file: key: what (hint)`."""
    try:
        data = read_toml(path, syntax="text and dotted keys need quotes", unreadable="; name a sweep file")
    except TomlError as error:
        raise SweepError(str(error)) from None
    try:
        sweep = Sweep.model_validate(data)
    except ValidationError as error:
        raise SweepError("\n".join(f"{path}: {problem}" for problem in describe(error, Sweep))) from None
    sweep._path = path
    return sweep


def sweep_schema() -> dict[str, Any]:
    """JSON schema (2020-12) of a sweep file."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Sweep.model_json_schema()}


def check(sweep: Sweep) -> list[str]:
    """What is wrong between keys that are well formed by themselves, as `key: what (hint)`, where all is rendered."""
    known = techniques()
    problems = [
        f"techniques: there is no {name!r} {hint(name, known)}" for name in sweep.techniques if name not in known
    ]
    for key in sweep.grid:
        first, _, rest = key.partition(".")
        technique = rest.partition(".")[0]
        if first == "techniques" and technique in known and technique not in {*sweep.techniques, REFERENCE}:
            problems.append(f"grid: {key!r}: {technique} is not among the techniques; add it there")
    return problems + check_lists(sweep)


def check_lists(sweep: Sweep) -> list[str]:
    """What is listed twice, or is not for a sweep to vary, as `key: what (hint)`."""
    problems: list[str] = []
    for key in ("sequences", "techniques"):
        values = getattr(sweep, key)
        problems += [f"{key}: {value!r} is listed twice" for value in _repeated(values)]
    for key, values in sweep.grid.items():
        problems += [f"grid: {key!r}: {value!r} is listed twice" for value in _repeated(values)]
        if key in SET_ELSEWHERE:
            problems.append(f"grid: {key!r}: {SET_ELSEWHERE[key]}; leave it out")
    return problems


def _repeated(values: list[Any]) -> list[Any]:
    return [value for place, value in enumerate(values) if value in values[:place]]
