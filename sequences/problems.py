"""What is wrong with a sequence, in lines that say where and how to mend it."""

import difflib
import reprlib
from collections.abc import Iterable
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo


class SequenceError(ValueError):
    """A sequence that cannot be loaded. `problems` holds every problem found, a line each."""

    def __init__(self, problems: Iterable[str]) -> None:
        self.problems = list(problems)
        super().__init__("\n".join(self.problems))


def hint(word: str, known: Iterable[str]) -> str:
    """What a mistyped `word` may have been meant to be: the nearest of `known`, and all of them."""
    names = sorted(known)
    near = difflib.get_close_matches(word, names, n=1)
    guess = f"did you mean {near[0]!r}? " if near else ""
    return f"({guess}known: {', '.join(names) or 'none'})"


def describe(error: ValidationError, model: type[BaseModel], *, prefix: str = "") -> list[str]:
    """Every problem of a validation of `model` as `key.path: what is wrong (hint)`, in the order found.

    `prefix` goes before each path: the path of the table that `model` was read from.
    """
    return [_line(details, model, prefix) for details in error.errors(include_url=False)]


def _line(details: Any, model: type[BaseModel], prefix: str) -> str:
    path, field, keys = _locate(model, details["loc"])
    context = details.get("ctx", {})
    given = reprlib.repr(details["input"])
    match details["type"]:
        case "extra_forbidden":
            what = f"unknown key {hint(str(details['loc'][-1]), keys)}"
        case "missing":
            what = "missing"
        case "union_tag_not_found":
            path, what = f"{path}.kind", f"missing {hint('', _variants(field.annotation) if field else ())}"
        case "union_tag_invalid":
            known = _variants(field.annotation) if field else ()
            path, what = f"{path}.kind", f"there is no {context['tag']!r} {hint(context['tag'], known)}"
        case "value_error":
            what = str(context["error"])
        case "model_type" | "model_attributes_type" | "dict_type":
            what = f"should be a table, got {given}"
        case _:
            what = f"{details['msg'].removeprefix('Input ')}, got {given}"
    meaning = field.description if field and "(" not in what else None
    return f"{prefix}{path}: {what}" + (f" ({meaning})" if meaning else "")


def _locate(model: type[BaseModel], place: Iterable[int | str]) -> tuple[str, FieldInfo | None, list[str]]:
    """Path as the file spells it, the field at it if there is one, and the keys of the table it is in."""
    kind: Any = model
    path: list[str] = []
    field: FieldInfo | None = None
    keys: list[str] = []
    for key in place:
        if key == "[key]":  # the name of a table is what is wrong
            break
        if key in (variants := _variants(kind)):
            kind = variants[str(key)]
            continue
        path.append(str(key))
        kind = _table_of(kind)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            fields = {each.alias or name: each for name, each in kind.model_fields.items()}
            keys, field = list(fields), fields.get(str(key))
            kind = field.annotation if field else None
        elif get_origin(kind) is dict:
            kind = get_args(kind)[1]
        elif isinstance(key, int):
            kind = next(iter(get_args(kind)), None)
    return ".".join(path), field, keys


def _table_of(kind: Any) -> Any:
    """The table of one that may be left out (`Table | None`); anything else as it is."""
    tables = [each for each in get_args(kind) if isinstance(each, type) and issubclass(each, BaseModel)]
    return tables[0] if len(tables) == 1 and type(None) in get_args(kind) else kind


def _variants(kind: Any) -> dict[str, type[BaseModel]]:
    """Tables that a union chooses from by the key `kind`; empty for anything else."""
    tables = (each for each in get_args(kind) if isinstance(each, type) and issubclass(each, BaseModel))
    return {each.model_fields["kind"].default: each for each in tables if "kind" in each.model_fields}
