"""Small SVG charts: lines and stacked bars with labelled axes, in the text colour of the page."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal

WIDTH, HEIGHT = 460, 290
LEFT, RIGHT, TOP, BOTTOM = 62, 12, 10, 44
BAR, BAR_GAP, BAR_LEFT = 20, 8, 118


@dataclass(frozen=True)
class Axis:
    """An axis: its label with the unit, and its scale. `octaves` is a logarithm to base 2."""

    label: str
    scale: Literal["linear", "log", "octaves"] = "linear"


@dataclass(frozen=True)
class Line:
    """A line of a chart; points where y is None, or not above 0 on a logarithmic axis, are left out."""

    label: str
    x: Sequence[float]
    y: Sequence[float | None]
    colour: str
    dash: str = ""


@dataclass(frozen=True)
class Bar:
    """A bar of parts (label, length, colour, hover text), laid end to end."""

    label: str
    parts: Sequence[tuple[str, float, str, str]]


class Plane:
    """A plane with two axes on paper, from the lowest to the highest values given; its text lies at left and below.

    margin: what is left free beyond these on every side, as a fraction of the plane.
    """

    def __init__(
        self,
        across: Sequence[float],
        up: Sequence[float],
        *,
        x: Axis,
        y: Axis,
        size: tuple[int, int] = (WIDTH, HEIGHT),
        margin: float = 0.0,
    ) -> None:
        self.size, self._x, self._y = size, x, y
        self._across = _widened(_limits(across, x.scale), x.scale, margin)
        self._up = _widened(_limits(up, y.scale), y.scale, margin)

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of where points lie."""
        return LEFT, TOP, self.size[0] - RIGHT, self.size[1] - BOTTOM

    def place(self, px: float, py: float) -> tuple[float, float]:
        """Where a point lies on the paper."""
        left, top, right, bottom = self.box
        across, up = _share(px, self._across, self._x.scale), _share(py, self._up, self._y.scale)
        return left + across * (right - left), bottom - up * (bottom - top)

    def drawn(self) -> list[str]:
        """The grid, and the axes with their ticks and labels."""
        left, top, right, bottom = self.box
        body = []
        for value, text in ticks(*self._across, self._x.scale):
            at, _ = self.place(value, self._up[0])
            body.append(f'<path class="grid" d="M{at:.1f} {top}V{bottom}"/>')
            body.append(drawn_text(at, bottom + 16, text, "middle"))
        for value, text in ticks(*self._up, self._y.scale):
            _, at = self.place(self._across[0], value)
            body.append(f'<path class="grid" d="M{left} {at:.1f}H{right}"/>')
            body.append(drawn_text(left - 6, at + 4, text, "end"))
        body.append(drawn_text((left + right) / 2, self.size[1] - 6, self._x.label, "middle"))
        middle = (top + bottom) / 2
        body.append(f'<g transform="rotate(-90 12 {middle})">{drawn_text(12, middle, self._y.label, "middle")}</g>')
        return body


def line_chart(lines: Sequence[Line], *, x: Axis, y: Axis, title: str) -> str:
    """An SVG of lines; "" when no line has a point to draw."""
    kept = [(line, _drawable(line, x, y)) for line in lines]
    points = [point for _, some in kept for point in some]
    if not points:
        return ""
    plane = Plane([point[0] for point in points], [point[1] for point in points], x=x, y=y)
    body = plane.drawn()
    for line, some in kept:
        path = "L".join(f"{px:.1f} {py:.1f}" for px, py in (plane.place(*point) for point in some))
        dash = f' stroke-dasharray="{line.dash}"' if line.dash else ""
        body.append(group(line.label))
        if path:
            body.append(f'<path class="line" d="M{path}" stroke="{line.colour}"{dash}/>')
        for point in some:
            px, py = plane.place(*point)
            hover = escape(f"{line.label}: {number(point[1])} at {number(point[0])}")
            body.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" fill="{line.colour}"><title>{hover}</title></circle>')
        body.append("</g>")
    return drawing(plane.size, title, body)


def stacked_bars(bars: Sequence[Bar], *, label: str, title: str) -> str:
    """An SVG of horizontal bars on one linear axis from 0; "" when every bar is empty."""
    lengths = [sum(part[1] for part in bar.parts) for bar in bars]
    if not any(length > 0 for length in lengths):
        return ""
    high = max(lengths)
    height = TOP + len(bars) * (BAR + BAR_GAP) + BOTTOM
    room = WIDTH - BAR_LEFT - RIGHT
    body = []
    for value, text in ticks(0, high, "linear"):
        at = BAR_LEFT + value / high * room
        body.append(f'<path class="grid" d="M{at:.1f} {TOP}V{height - BOTTOM}"/>')
        body.append(drawn_text(at, height - BOTTOM + 16, text, "middle"))
    for row, bar in enumerate(bars):
        top = TOP + row * (BAR + BAR_GAP) + BAR_GAP / 2
        body.append(group(bar.label))
        body.append(drawn_text(BAR_LEFT - 6, top + BAR / 2 + 4, bar.label, "end"))
        at = float(BAR_LEFT)
        for name, length, colour, hover in bar.parts:
            wide = length / high * room
            body.append(
                f'<rect x="{at:.1f}" y="{top}" width="{wide:.2f}" height="{BAR}" fill="{colour}">'
                f"<title>{escape(f'{bar.label}, {name}: {hover}')}</title></rect>"
            )
            at += wide
        body.append("</g>")
    body.append(drawn_text((BAR_LEFT + WIDTH - RIGHT) / 2, height - 6, label, "middle"))
    return drawing((WIDTH, height), title, body)


def ticks(low: float, high: float, scale: str) -> list[tuple[float, str]]:
    """Round values between two limits with their texts: powers of ten or two, or steps of 1, 2 or 5."""
    if scale == "octaves":
        exponents = range(math.ceil(math.log2(low) - 1e-9), math.floor(math.log2(high) + 1e-9) + 1)
        return [(2.0**e, f"1/{2**-e}" if e < 0 else str(2**e)) for e in exponents]
    if scale == "log":
        decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        steps = (1,) if math.log10(high / low) > 3 else (1, 2, 5)
        values = [step * 10.0**e for e in decades for step in steps]
    else:
        rough = (high - low) / 5
        power = 10.0 ** math.floor(math.log10(rough))
        step = next(s * power for s in (1, 2, 5, 10) if s * power >= rough * 0.999)
        values = [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
    slack = 1e-9 * (high - low)
    return [(value, number(value)) for value in values if low - slack <= value <= high + slack]


def number(value: float) -> str:
    """A value in three significant digits, without needless zeros."""
    if value != 0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.2e}".split("e")
        return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    text = f"{value:.3g}"
    return f"{float(text):.0f}" if "e" in text else text


def _drawable(line: Line, x: Axis, y: Axis) -> list[tuple[float, float]]:
    return [
        (px, py)
        for px, py in zip(line.x, line.y, strict=True)
        if py is not None and (x.scale == "linear" or px > 0) and (y.scale == "linear" or py > 0)
    ]


def _unit(value: float, scale: str) -> float:
    return value if scale == "linear" else math.log(value)


def _limits(values: Sequence[float], scale: str) -> tuple[float, float]:
    low, high = min(values), max(values)
    if scale == "linear":
        low = min(low, 0.0)
        return (low, high) if high > low else (low, low + 1)
    return (low, high) if high > low * 1.05 else (low / 2, high * 2)


def _widened(limits: tuple[float, float], scale: str, margin: float) -> tuple[float, float]:
    low, high = limits
    if scale == "linear":
        return low - margin * (high - low), high + margin * (high - low)
    return low * (low / high) ** margin, high * (high / low) ** margin


def _share(value: float, limits: tuple[float, float], scale: str) -> float:
    low, high = (_unit(limit, scale) for limit in limits)
    return (_unit(value, scale) - low) / (high - low)


def group(name: str) -> str:
    """The start of a group of elements that belong to a technique, or to another name in the key."""
    return f'<g data-name="{escape(name)}">'


def drawn_text(x: float, y: float, text: str, anchor: str) -> str:
    """A text element."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def drawing(size: tuple[float, float], title: str, body: Sequence[str]) -> str:
    """An SVG of some elements."""
    head = f'<svg viewBox="0 0 {size[0]:g} {size[1]:g}" role="img" aria-label="{escape(title)}">'
    return head + "".join(body) + "</svg>"
