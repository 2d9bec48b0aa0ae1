"""Docstrings as this house writes them, for mkdocstrings: a line `name: what it is` becomes an item of a list."""

import re
from typing import Any

from griffe import Extension, Object

ITEM = re.compile(r"^(?P<names>[a-z_]\w*(?:, [a-z_]\w*)*): (?P<words>\S.*)$")


class Docstrings(Extension):
    """Rewrites every docstring as Markdown."""

    def on_instance(self, *, obj: Object, **kwargs: Any) -> None:
        """Called for every module, class, function and attribute."""
        del kwargs
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)


def as_markdown(text: str) -> str:
    """A docstring's text with its items as a list; indented lines belong to the item above them."""
    lines: list[str] = []
    inside = False
    for line in text.splitlines():
        found = ITEM.match(line)
        if found:
            names = ", ".join(f"`{name}`" for name in found["names"].split(", "))
            lines += ([] if inside else [""]) + [f"- {names}: {found['words']}"]
        elif inside and line.strip() and not line.startswith(" "):
            lines += ["", line]
        else:
            lines.append(line)
        inside = bool(found) or (inside and line.startswith(" "))
    return "\n".join(lines)
