"""What there is to choose from, as `swimlab list` has it."""

import io
import json
from contextlib import redirect_stdout
from typing import get_args

from swimlab.cli.list_command import Kind, list_command

TITLES = {
    "techniques": "Techniques",
    "sequences": "Sequences of the library",
    "brdfs": "Reflectance models",
    "conventions": "Conventions of motion vectors",
}
OPENING = """# Techniques, models, conventions

This page is made from `swimlab list KIND --json`. Colour spaces and views of displays depend on OpenColorIO's
configuration: `swimlab list colorspaces` and `swimlab list views` name them.
"""


def page() -> str:
    """The page, a table a kind."""
    return "\n".join(
        [OPENING, *(f"## {TITLES[kind]}\n\n{_table(kind)}\n" for kind in get_args(Kind) if kind in TITLES)]
    )


def _table(kind: Kind) -> str:
    printed = io.StringIO()
    with redirect_stdout(printed):
        list_command(kind, json_output=True)
    rows = [{key: value for key, value in row.items() if key != "file"} for row in json.loads(printed.getvalue())]
    lines = [list(rows[0]), ["---"] * len(rows[0])]
    lines += [[f"`{first}`", *map(cell, rest)] for first, *rest in (row.values() for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cell(text: str) -> str:
    """A text that a cell of a table can hold."""
    return text.replace("|", "\\|").replace("*", "\\*").replace("_", "\\_") if "`" not in text else text
