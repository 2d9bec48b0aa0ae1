"""Docstrings as this house writes them, for mkdocstrings: `name: what it is` becomes an item of a list.

The names are those of a function's parameters or of a class' attributes; several items may stand in one paragraph.
"""

import re
from collections.abc import Collection
from typing import Any

from griffe import Class, Extension, Function, Object


class Docstrings(Extension):
    """Rewrites every docstring as Markdown."""

    def on_instance(self, *, obj: Object, **kwargs: Any) -> None:
        """Called for every module, class, function and attribute."""
        del kwargs
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value, names_of(obj))


def names_of(obj: Object) -> list[str]:
    """What a docstring may explain."""
    if isinstance(obj, Function):
        return [parameter.name for parameter in obj.parameters]
    if isinstance(obj, Class):
        return [*obj.members, *(parameter.name for parameter in obj.parameters)]
    return []


def as_markdown(text: str, names: Collection[str]) -> str:
    """A docstring's text with its items as lists; what is indented or a list already stays as it is."""
    if not names:
        return text
    kept = re.split(r"\n\s*\n", text)
    return "\n\n".join(part if part.startswith(("-", " ")) else _paragraph(part, names) for part in kept)


def _paragraph(text: str, names: Collection[str]) -> str:
    one = "|".join(map(re.escape, names))
    flat = " ".join(text.split())
    before, *rest = re.split(rf"(?:^|(?<=[.;)] ))((?:{one})(?:, (?:{one}))*): ", flat)
    if not rest:
        return text
    items = []
    after = ""
    for name, words in zip(rest[::2], rest[1::2], strict=True):
        said, raises, more = words.partition(". Raises ")
        items.append(f"- `{name.replace(', ', '`, `')}`: {said.strip()}{'.' if raises else ''}")
        after = f"Raises {more}" if raises else after
    return "\n\n".join(part for part in (before.strip(), "\n".join(items), after) if part)
