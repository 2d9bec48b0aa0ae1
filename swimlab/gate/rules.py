"""Gate files: which scores of which clips are held to what."""

import reprlib
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    WithJsonSchema,
    model_validator,
)

from sequences.problems import hint
from sequences.table import Real, Table
from sequences.toml_file import TomlError, read_toml

Level = Literal["off", "warn", "error"]
Cell = tuple[str, str, str]
"""Sequence, technique and metric."""


class GateError(ValueError):
    """A gate that cannot be run; the message names the file, the key and how to mend it.

    paste: rules that would mend it, to be added to the gate file.
    """

    def __init__(self, message: str, paste: str = "") -> None:
        super().__init__(message)
        self.paste = paste


class Increase(NamedTuple):
    """How much worse than the baseline a score may be: the larger of a share of it and an absolute amount."""

    relative: float = 0.0
    absolute: float = 0.0

    def allowance(self, base: float) -> float:
        """What may be added to `base`."""
        return max(self.relative * abs(base), self.absolute)


def _increase(given: Any) -> Increase:
    """Read 0.001 (absolute), "5%" (of the baseline) or both as ["5%", 0.001]."""
    parts = given if isinstance(given, list) else [given]
    shares = [part for part in parts if isinstance(part, str)]
    amounts = [part for part in parts if isinstance(part, int | float) and not isinstance(part, bool)]
    if len(shares) > 1 or len(amounts) > 1 or not parts or len(shares) + len(amounts) != len(parts):
        raise ValueError('should be "5%", an amount as 0.001, or both as ["5%", 0.001]')
    return Increase(_share(shares[0]) if shares else 0.0, _amount(amounts[0]) if amounts else 0.0)


def _share(text: str) -> float:
    try:
        return _amount(float(text.strip().removesuffix("%")) / 100) if text.strip().endswith("%") else _bad(text)
    except ValueError:
        return _bad(text)


def _bad(text: str) -> float:
    raise ValueError(f'should be "5%", an amount as 0.001, or both as ["5%", 0.001], got {text!r}')


def _amount(value: float) -> float:
    if not 0 <= value < float("inf"):
        raise ValueError(f"should be 0 or more, got {value}")
    return float(value)


def _not_empty(pattern: str) -> str:
    if not pattern.strip():
        raise ValueError("should not be empty; * stands for anything")
    return pattern


Pattern = Annotated[str, AfterValidator(_not_empty)]

_PARTS: list[dict[str, Any]] = [{"type": "number", "minimum": 0}, {"type": "string", "pattern": "%\\s*$"}]
_INCREASE = {"anyOf": [*_PARTS, {"type": "array", "items": {"anyOf": _PARTS}, "minItems": 1, "maxItems": 2}]}
"""As an editor is told of it."""


class Baselines(Table):
    """Where the baseline is, and what a clip or score that it lacks means."""

    file: Pattern = Field(description="JSON file that 'swimlab baseline update' writes, relative to the gate file")
    missing: Literal["error", "warn"] = Field("error", description="for what is measured and not in the baseline")


class Rule(Table):
    """What the scores that a rule matches are held to. The last rule that matches a score is the one that counts."""

    sequence: Pattern = Field("*", description="name of a sequence; * and ? stand for other characters")
    technique: Pattern = Field("*", description="name of a technique; * and ? stand for other characters")
    metric: Pattern = Field(description="name of a score, as 'swimlab list metrics' prints; * and ? are allowed")
    level: Level = Field("error", description="off, warn or error: what a score beyond its limit is")
    max: Real | None = Field(None, description="ceiling: the largest value that passes")
    min: Real | None = Field(None, description="floor: the smallest value that passes")
    max_increase: Annotated[Increase, BeforeValidator(_increase), WithJsonSchema(_INCREASE)] | None = Field(
        None, description='how much worse than the baseline: "5%", an amount, or both (the larger counts)'
    )
    noise_sigma: Annotated[Real, Field(ge=0, le=100)] | None = Field(
        None, description="how many standard deviations of the baseline's runs are granted on top of max_increase"
    )

    @model_validator(mode="after")
    def _limits_something(self) -> Self:
        if self.level != "off" and self.max is None and self.min is None and self.max_increase is None:
            raise ValueError('limits nothing; give max, min or max_increase, or level = "off"')
        if self.noise_sigma is not None and self.max_increase is None:
            raise ValueError("noise_sigma says nothing without max_increase; give that too, as 0")
        if self.max is not None and self.min is not None and self.min > self.max:
            raise ValueError(f"min is {self.min:g} and max {self.max:g}: no value passes")
        return self

    def matches(self, sequence: str, technique: str, metric: str) -> bool:
        """Whether the rule speaks of a score."""
        patterns = (self.sequence, self.technique, self.metric)
        return all(map(fnmatchcase, (sequence, technique, metric), patterns))


class Gate(Table):
    """A gate file, version 1."""

    version: Literal[1] = Field(description="version of the file format: 1")
    baseline: Baselines | None = Field(None, description="what was measured earlier")
    rule: list[Rule] = Field(min_length=1, description="rules, each a [[rule]] table; the last match counts")

    _path: Path = PrivateAttr(default=Path())

    @property
    def path(self) -> Path:
        """The gate file."""
        return self._path

    @property
    def baseline_path(self) -> Path | None:
        """The baseline's file, if the gate has one."""
        return None if self.baseline is None else self._path.parent / self.baseline.file

    def governing(self, sequence: str, technique: str, metric: str) -> int:
        """Number of the rule that counts for a score: the last that matches, from 0; -1 for none."""
        found = [n for n, rule in enumerate(self.rule) if rule.matches(sequence, technique, metric)]
        return found[-1] if found else -1


def load_gate(path: Path) -> Gate:
    """Read a gate file. Raises GateError with every problem at once, each as `file: key: what (hint)`."""
    try:
        data = read_toml(path, syntax="text needs quotes, a rule starts with [[rule]]", unreadable="; name a gate file")
    except TomlError as error:
        raise GateError(str(error)) from None
    try:
        gate = Gate.model_validate(data)
    except ValidationError as error:
        raise GateError("\n".join(f"{path}: {_problem(each)}" for each in error.errors(include_url=False))) from None
    gate._path = path
    if gate.baseline is None:
        needy = [number for number, rule in enumerate(gate.rule, 1) if rule.max_increase is not None]
        if needy:
            raise GateError(
                f"{path}: rule {needy[0]}: max_increase compares with a baseline; add a [baseline] table with a file"
            )
    return gate


def gate_schema() -> dict[str, Any]:
    """JSON schema (2020-12) of a gate file."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Gate.model_json_schema()}


def _problem(details: Any) -> str:
    """One mistake as `key: what is wrong (hint)`; rules are counted from 1, as a reader does."""
    place = list(details["loc"])
    tables: dict[str, type[BaseModel]] = {"baseline": Baselines, "rule": Rule}
    model = tables.get(str(place[0]), Gate) if len(place) > 1 else Gate
    where = " ".join(str(part + 1) if isinstance(part, int) else str(part) for part in place[:2])
    where = ".".join([where, *map(str, place[2:])]) if place[0] == "rule" else ".".join(map(str, place))
    field = model.model_fields.get(str(place[-1]))
    meaning = f" ({field.description})" if field is not None and field.description else ""
    match details["type"]:
        case "extra_forbidden":
            return f"{where}: unknown key {hint(str(place[-1]), model.model_fields)}"
        case "missing":
            return f"{where}: missing{meaning}"
        case "value_error":
            return f"{where}: {details['ctx']['error']}{meaning}"
        case _:
            return f"{where}: {details['msg'].removeprefix('Input ')}, got {reprlib.repr(details['input'])}{meaning}"
