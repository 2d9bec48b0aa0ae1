"""The motion-plane slice: what moves with the surface lies on one line, each order of aliases on another."""

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from metrics.levels import levels_of
from swimlab.report.charts import Axis, Plane, drawing, drawn_text
from swimlab.report.heat import cells, scale_bar

LOW, HIGH = -90.0, -30.0
"""Decibels to 1 radiance^2 at the scale's ends."""

SIZE = (420, 400)
APART = 0.052
"""Cycles/px between the names of two lines, so that they do not hide each other."""

NEAR = 2
"""Steps of the temporal frequency within which energy is counted to a line: the window over time spreads it so far."""


def plane_slice(entry: Mapping[str, Any]) -> tuple[str, str]:
    """An SVG of the curve `plane.slice` with lines for orders 0 and 1, and what to see in it; both "" without it."""
    curve = entry.get("curves", {}).get("plane.slice")
    if not curve:
        return "", ""
    speed = math.hypot(*curve["velocity"])
    step = curve["w"][1] - curve["w"][0]
    plane = Plane(
        [0.0, 0.5],
        [-0.5, 0.5],
        x=Axis("cycles/pixel along the motion"),
        y=Axis("cycles/frame"),
        size=(SIZE[0], SIZE[1] - 44),
    )
    levels = levels_of(curve["level"])
    half = 0.25 / (len(curve["k"]) - 1)
    left, top = plane.place(-half, curve["w"][-1] + step / 2)
    right, bottom = plane.place(0.5 + half, curve["w"][0] - step / 2)
    body = [*plane.drawn(), cells(levels[::-1], LOW, HIGH, (left, top, right, bottom))]
    for place, order in enumerate(sorted(product((-1, 0, 1), repeat=2), key=lambda n: n != (0, 0))):
        if not all(curve["velocity"][axis] or not order[axis] for axis in range(2)):
            continue  # nothing moves along that axis
        start = -float(np.dot(order, curve["velocity"]))
        path = _line(plane, start, speed)
        kind = "order" if any(order) else "order home"
        name = f"order ({order[0]}, {order[1]})" if any(order) else "moves with the surface"
        body.append(f'<path class="{kind}" d="{path}"><title>{name}</title></path>')
        k = place * APART
        x, y = plane.place(k, _folded(start - speed * k))
        body.append(f'<g class="on small">{drawn_text(x + 3, y - 3, f"{order[0]},{order[1]}", "start")}</g>')
    body += scale_bar(LOW, HIGH, label="dB to 1 radiance²", box=(plane.box[0], SIZE[1] - 40, plane.box[2], 0))
    sentence = (
        "Full line: what moves with the surface; dashed: aliases of order 1, which swim; "
        f"{share_at_home(curve, levels):.0%} of the error in this slice is at the full line (of a noise it would be "
        f"{(2 * NEAR + 1) / len(curve['w']):.0%})."
    )
    return drawing(SIZE, "Motion-plane slice of the error", body), sentence


def share_at_home(curve: Mapping[str, Sequence[Any]], levels: np.ndarray) -> float:
    """The share of the slice's energy within NEAR steps of the line of what moves with the surface."""
    power = 10 ** (levels / 10)
    w, k = np.array(curve["w"])[:, None], np.array(curve["k"])[None, :]
    away = (w + k * math.hypot(*curve["velocity"]) + 0.5) % 1.0 - 0.5
    near = np.abs(away) <= NEAR * float(curve["w"][1] - curve["w"][0]) + 1e-9
    return float(power[near].sum() / power.sum())


def _folded(w: float) -> float:
    """A temporal frequency within half a cycle a frame."""
    return (w + 0.5) % 1.0 - 0.5


def _line(plane: Plane, start: float, speed: float) -> str:
    """The line w = start - speed k, folded to half a cycle a frame, as a path."""
    path = []
    k, w = 0.0, _folded(start)
    while k < 0.5:
        until = min(0.5, k + (w + 0.5) / speed)
        ends = plane.place(k, w), plane.place(until, w - (until - k) * speed)
        path.append("M{:.1f} {:.1f}L{:.1f} {:.1f}".format(*ends[0], *ends[1]))
        k, w = until, 0.5
    return "".join(path)
