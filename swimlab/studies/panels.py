"""Several charts on one sheet, with one key."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from swimlab.report.charts import HEIGHT, WIDTH
from swimlab.studies.page import STYLE, Figure

HEAD, KEY = 24, 26
LETTER = 7.0

MORE_STYLE = (
    ".title{font-weight:bold}.dot{r:4px;stroke-width:1.6;fill-opacity:.9}.join{fill:none;stroke-width:1.2;opacity:.6}"
    ".front{fill:none;stroke:#222;stroke-width:1.2;stroke-dasharray:5 3;opacity:.75}.leader{stroke:#999;fill:none}"
    ".floor{stroke:#222;stroke-dasharray:1 3;fill:none}"
    ".name{font-size:11px;paint-order:stroke;stroke:#fff;stroke-width:2.5px;stroke-linejoin:round}"
)


@dataclass(frozen=True)
class Panel:
    """A chart, and what is written above it."""

    title: str
    svg: str


def panels(
    name: str,
    caption: str,
    drawn: Sequence[Panel],
    *,
    columns: int,
    key: Sequence[tuple[str, str]],
    size: tuple[int, int] = (WIDTH, HEIGHT),
) -> Figure:
    """Charts of one size in columns as an SVG file of their own; key: names with their colours."""
    wide, high = size
    head = HEAD if any(panel.title for panel in drawn) else 0
    width, body = wide * columns, []
    at, line = 12.0, 0
    for text, colour in key:
        needed = 18 + LETTER * len(text) + 14
        if at + needed > width:
            at, line = 12.0, line + 1
        body.append(f'<circle cx="{at + 5:.1f}" cy="{14 + KEY * line}" class="dot" fill="{colour}"/>')
        body.append(f'<text x="{at + 15:.1f}" y="{18 + KEY * line}">{escape(text)}</text>')
        at += needed
    top = KEY * (line + 1)
    for place, panel in enumerate(drawn):
        row, column = divmod(place, columns)
        x, y = column * wide, top + row * (head + high)
        if panel.title:
            body.append(f'<text class="title" x="{x + 12}" y="{y + 16}">{escape(panel.title)}</text>')
        body.append(panel.svg.replace("<svg ", f'<svg x="{x}" y="{y + head}" width="{wide}" height="{high}" ', 1))
    height = top + -(-len(drawn) // columns) * (head + high)
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"><style>{STYLE}{MORE_STYLE}</style>'
        f'<rect width="100%" height="100%" fill="white"/>{"".join(body)}</svg>\n'
    )
    return Figure(name, caption, svg.encode())
