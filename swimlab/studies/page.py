"""A report as Markdown: sections of text, tables and pictures, with the tables' numbers as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from swimlab.report.charts import HEIGHT, WIDTH, Axis, Line, line_chart
from swimlab.runs.files import replacing, write_text

Cell = str | float | int | None
KEY_WIDTH = 190

STYLE = (
    "text{font:12.5px sans-serif;fill:#222}.grid{stroke:#ddd;fill:none}.line{fill:none;stroke-width:1.8}circle{r:2.5px}"
)


@dataclass(frozen=True)
class Table:
    """Rows of cells under headings; `name` is its key in JSON. Floats are shown in three digits, None as a dash."""

    name: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]


@dataclass(frozen=True)
class Figure:
    """A picture file beside the page, and what it shows."""

    name: str
    caption: str
    content: bytes


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it."""

    title: str
    parts: Sequence[str | Table | Figure]


def write_page(path: Path, title: str, opening: str, sections: Sequence[Section]) -> None:
    """Write a Markdown page, and its pictures into the folder beside it that has the page's name."""
    blocks = [f"# {title}", opening]
    for section in sections:
        blocks.append(f"## {section.title}")
        for part in section.parts:
            if isinstance(part, Figure):
                with replacing(path.with_suffix("") / part.name) as temporary:
                    temporary.write_bytes(part.content)
                blocks += [f"![{part.caption}]({path.stem}/{part.name})", f"*{part.caption}*"]
            else:
                blocks.append(markdown(part) if isinstance(part, Table) else part)
    write_text(path, "\n\n".join(blocks) + "\n")


def tables(sections: Sequence[Section]) -> dict[str, Any]:
    """The tables by their names, each a list of rows by column, for JSON."""
    found = [part for section in sections for part in section.parts if isinstance(part, Table)]
    return {table.name: [dict(zip(table.columns, row, strict=True)) for row in table.rows] for table in found}


def markdown(table: Table) -> str:
    """A table in Markdown; columns of numbers are set to the right."""
    numeric = [any(isinstance(row[place], int | float) for row in table.rows) for place in range(len(table.columns))]
    lines = [table.columns, ["---:" if right else "---" for right in numeric]]
    lines += [[shown(cell) for cell in row] for row in table.rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def shown(cell: Cell) -> str:
    """A cell as text: whole numbers in full, others in three significant digits, a dash for None."""
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell
    if isinstance(cell, int) or abs(cell) >= 1000:
        return f"{round(cell):,}"
    return f"{cell:#.3g}".rstrip(".") if cell == 0 or abs(cell) >= 1e-3 else f"{cell:.2g}"


def chart(name: str, caption: str, lines: Sequence[Line], *, x: Axis, y: Axis) -> Figure:
    """A chart of lines as an SVG file of its own, with its key; an empty one where no line has a point."""
    plot = line_chart(lines, x=x, y=y, title=caption).replace("<svg ", f'<svg width="{WIDTH}" height="{HEIGHT}" ', 1)
    key = []
    for place, line in enumerate(lines):
        at = 24 + 20 * place
        dash = f' stroke-dasharray="{line.dash}"' if line.dash else ""
        key.append(f'<path class="line" d="M{WIDTH + 10} {at}h24" stroke="{line.colour}"{dash}/>')
        key.append(f'<text x="{WIDTH + 40}" y="{at + 4}">{escape(line.label)}</text>')
    size = f"{WIDTH + KEY_WIDTH} {HEIGHT}"
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size}"><style>{STYLE}</style>'
        f'<rect width="100%" height="100%" fill="white"/>{plot}{"".join(key)}</svg>\n'
    )
    return Figure(name, caption, svg.encode())
