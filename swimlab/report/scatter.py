"""Scatter charts with a name at every point and the Pareto front drawn: cost against error."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

from swimlab.report.charts import HEIGHT, WIDTH, Axis, Plane, drawing, group, number
from swimlab.report.palette import Ink
from swimlab.report.weighing import front

Box = tuple[float, float, float, float]

LETTER, LINE = 6.0, 12.0
"""Width of a letter and height of a line of text, as SVG units."""

DOT = 4.0
NEAR = 1.9
"""Radii of a dot within which a name needs no line to it."""

DISTANCES = (7.0, 13.0, 21.0, 31.0, 43.0, 57.0, 73.0)
DIRECTIONS = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1))


@dataclass(frozen=True)
class Point:
    """A dot at (x, y), both above 0 or the point is not drawn; its name, its colour and the dash of its ink."""

    name: str
    x: float
    y: float | None
    colour: str
    dash: str = ""


def scatter(
    series: Sequence[Sequence[Point]],
    *,
    x: Axis,
    y: Axis,
    title: str,
    size: tuple[int, int] = (WIDTH, HEIGHT),
    floor: float | None = None,
) -> str:
    """An SVG with logarithmic axes, less being better on both; "" when there is no point to draw.

    series: points that are joined in their order, each list on its own. Points on the Pareto front are filled and
    joined by steps. floor: a value of y that is marked by a line, as the least that means anything.
    """
    kept = [[(p, p.y) for p in points if p.y is not None and min(p.x, p.y) > 0] for points in series]
    flat = [each for some in kept for each in some]
    if not flat:
        return ""
    low = [floor] if floor else []
    plane = Plane([p.x for p, _ in flat], [*(y for _, y in flat), *low], x=x, y=y, size=size, margin=0.05)
    left, top, right, bottom = plane.box
    body = plane.drawn()
    if floor:
        _, at = plane.place(flat[0][0].x, floor)
        body.append(f'<path class="floor" d="M{left} {at:.1f}H{right}"/>')
    for some in kept:
        path = "L".join(f"{px:.1f} {py:.1f}" for px, py in (plane.place(p.x, y) for p, y in some))
        if len(some) > 1:
            body.append(f'<path class="join" d="M{path}" stroke="{some[0][0].colour}"/>')
    held = front([(p.x, y) for p, y in flat])
    best = sorted({plane.place(p.x, y) for (p, y), on in zip(flat, held, strict=True) if on})
    steps = "".join(f"H{after[0]:.1f}V{after[1]:.1f}" for _, after in pairwise(best))
    body.append(f'<path class="front" d="M{best[0][0]:.1f} {top}V{best[0][1]:.1f}{steps}H{right}"/>')
    places = [plane.place(p.x, y) for p, y in flat]
    for (point, value), on, (px, py) in zip(flat, held, places, strict=True):
        kind = "dot best" if on else "dot"
        about = f"{point.name}: {number(value)} at {number(point.x)}" + (", on the front" if on else "")
        mark = Ink(point.colour, point.dash).mark(px, py, DOT)
        body.append(
            f'{group(point.name)}<{mark} class="{kind}" stroke="{point.colour}" '
            f'fill="{point.colour if on else "none"}"><title>{escape(about)}</title></{mark.split()[0]}>'
        )
        body.append("</g>")
    body += _names([point.name for point, _ in flat], places, (left, top, right, bottom))
    return drawing(size, title, body)


def _names(names: Sequence[str], places: Sequence[tuple[float, float]], inside: Box) -> list[str]:
    """Names beside their dots, where they hide neither a dot nor each other as far as there is room."""
    taken: list[Box] = [(x - DOT, y - DOT, x + DOT, y + DOT) for x, y in places]
    body = []
    for name, (x, y) in sorted(zip(names, places, strict=True), key=lambda each: each[1]):
        body.append(group(name))
        box, distance = _room(name, x, y, taken, inside)
        taken.append(box)
        if distance > NEAR * DISTANCES[0]:
            ends = min(max(x, box[0]), box[2]), min(max(y, box[1]), box[3])
            body.append(f'<path class="leader" d="M{x:.1f} {y:.1f}L{ends[0]:.1f} {ends[1]:.1f}"/>')
        body.append(f'<text class="name" x="{box[0]:.1f}" y="{box[3] - 2.5:.1f}">{escape(name)}</text></g>')
    return body


def _room(name: str, x: float, y: float, taken: Sequence[Box], inside: Box) -> tuple[Box, float]:
    """The nearest place for a name that is free, or the one that hides the least; and how far away it is."""
    wide = LETTER * len(name)
    found: list[tuple[float, float, Box]] = []
    for distance in DISTANCES:
        for right, down in DIRECTIONS:
            far = distance if 0 in (right, down) else 0.8 * distance
            left = x + right * far - (0 if right > 0 else wide if right < 0 else wide / 2)
            top = y + down * far - (0 if down > 0 else LINE if down < 0 else LINE / 2)
            box = (left, top, left + wide, top + LINE)
            if left < inside[0] or top < inside[1] or box[2] > inside[2] or box[3] > inside[3]:
                continue
            hidden = sum(_common(box, other) for other in taken)
            if hidden == 0:
                return box, distance
            found.append((hidden, distance, box))
    if not found:
        return (x, y, x + wide, y + LINE), 0.0
    _, distance, box = min(found)
    return box, distance


def _common(one: Box, other: Box) -> float:
    wide = min(one[2], other[2]) - max(one[0], other[0])
    high = min(one[3], other[3]) - max(one[1], other[1])
    return max(wide, 0.0) * max(high, 0.0)
