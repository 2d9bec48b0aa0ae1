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


def line_chart(lines: Sequence[Line], *, x: Axis, y: Axis, title: str) -> str:
    """An SVG of lines; "" when no line has a point to draw."""
    kept = [(line, _drawable(line, x, y)) for line in lines]
    points = [point for _, some in kept for point in some]
    if not points:
        return ""
    x_low, x_high = _limits([point[0] for point in points], x.scale)
    y_low, y_high = _limits([point[1] for point in points], y.scale)

    def place(px: float, py: float) -> tuple[float, float]:
        across = (_unit(px, x.scale) - _unit(x_low, x.scale)) / (_unit(x_high, x.scale) - _unit(x_low, x.scale))
        up = (_unit(py, y.scale) - _unit(y_low, y.scale)) / (_unit(y_high, y.scale) - _unit(y_low, y.scale))
        return LEFT + across * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    body = []
    for value, text in ticks(x_low, x_high, x.scale):
        at, _ = place(value, y_low)
        body.append(f'<path class="grid" d="M{at:.1f} {TOP}V{HEIGHT - BOTTOM}"/>')
        body.append(_text(at, HEIGHT - BOTTOM + 16, text, "middle"))
    for value, text in ticks(y_low, y_high, y.scale):
        _, at = place(x_low, value)
        body.append(f'<path class="grid" d="M{LEFT} {at:.1f}H{WIDTH - RIGHT}"/>')
        body.append(_text(LEFT - 6, at + 4, text, "end"))
    for line, some in kept:
        path = "L".join(f"{px:.1f} {py:.1f}" for px, py in (place(*point) for point in some))
        dash = f' stroke-dasharray="{line.dash}"' if line.dash else ""
        if path:
            body.append(f'<path class="line" d="M{path}" stroke="{line.colour}"{dash}/>')
        for point in some:
            px, py = place(*point)
            hover = escape(f"{line.label}: {number(point[1])} at {number(point[0])}")
            body.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" fill="{line.colour}"><title>{hover}</title></circle>')
    body.append(_text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 6, x.label, "middle"))
    middle = (TOP + HEIGHT - BOTTOM) / 2
    body.append(f'<g transform="rotate(-90 12 {middle})">{_text(12, middle, y.label, "middle")}</g>')
    return _svg(HEIGHT, title, body)


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
        body.append(_text(at, height - BOTTOM + 16, text, "middle"))
    for row, bar in enumerate(bars):
        top = TOP + row * (BAR + BAR_GAP) + BAR_GAP / 2
        body.append(_text(BAR_LEFT - 6, top + BAR / 2 + 4, bar.label, "end"))
        at = float(BAR_LEFT)
        for name, length, colour, hover in bar.parts:
            wide = length / high * room
            body.append(
                f'<rect x="{at:.1f}" y="{top}" width="{wide:.2f}" height="{BAR}" fill="{colour}">'
                f"<title>{escape(f'{bar.label}, {name}: {hover}')}</title></rect>"
            )
            at += wide
    body.append(_text((BAR_LEFT + WIDTH - RIGHT) / 2, height - 6, label, "middle"))
    return _svg(height, title, body)


def ticks(low: float, high: float, scale: str) -> list[tuple[float, str]]:
    """Round values between two limits with their texts: powers of ten or two, or steps of 1, 2 or 5."""
    if scale == "octaves":
        exponents = range(math.ceil(math.log2(low) - 1e-9), math.floor(math.log2(high) + 1e-9) + 1)
        return [(2.0**e, f"1/{2**-e}" if e < 0 else str(2**e)) for e in exponents]
    if scale == "log":
        decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        steps = (1,) if len(decades) > 3 else (1, 2, 5)
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


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _svg(height: float, title: str, body: Sequence[str]) -> str:
    head = f'<svg viewBox="0 0 {WIDTH} {height:g}" role="img" aria-label="{escape(title)}">'
    return head + "".join(body) + "</svg>"
