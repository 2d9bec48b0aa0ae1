"""The error's spectrum in two dimensions with its peaks named, and their stripes drawn on the picture."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from metrics.levels import levels_of
from swimlab.report.charts import Axis, Plane, drawing, drawn_text, number
from swimlab.report.heat import cells, scale_bar

LOW, HIGH = -90.0, -30.0
"""Decibels to 1 radiance^2 at the scale's ends."""

SIZE = (300, 480)
NAMED = 4
"""Peaks that are named."""

STRIPES = 6
"""Lines that are drawn for a peak's stripes, at most; so few that the picture stays visible."""


class Peak(NamedTuple):
    """A spectral peak: x and y, cycles/px to the right and down, and dB over its surroundings."""

    x: float
    y: float
    strength: float

    @property
    def frequency(self) -> float:
        """Cycles/px."""
        return math.hypot(self.x, self.y)

    @property
    def degrees(self) -> int:
        """Direction that the stripes run in, 0 to 179, from level, counter-clockwise as seen."""
        return round(math.degrees(math.atan2(-self.x, -self.y))) % 180

    def words(self) -> str:
        """Frequency, orientation, period and strength."""
        return (
            f"{number(self.frequency)} cycles/pixel, stripes at {self.degrees}° every "
            f"{number(1 / self.frequency)} px, {self.strength:.0f} dB over their surroundings"
        )


def peaks_of(entry: Mapping[str, Any]) -> list[Peak]:
    """The peaks of an entry's error, the strongest first."""
    curve = entry.get("curves", {}).get("moire.peaks") or {"x": [], "y": [], "strength": []}
    return [Peak(*each) for each in zip(curve["x"], curve["y"], curve["strength"], strict=True) if each[0] or each[1]]


def spectrum_map(entry: Mapping[str, Any]) -> tuple[str, str]:
    """An SVG of the curve `moire.map` with the peaks numbered, and what to see in it; both "" where there is none."""
    curve = entry.get("curves", {}).get("moire.map")
    if not curve:
        return "", ""
    plane = Plane(
        [0.0, 0.5],
        [-0.5, 0.5],
        x=Axis("cycles/pixel across"),
        y=Axis("cycles/pixel up"),
        size=(SIZE[0], SIZE[1] - 44),
    )
    half = 0.5 / len(curve["y"])
    # Rows run downwards from -1/2, as the picture's do: the first is the top of an axis that counts upwards.
    left, top = plane.place(-half, 0.5 + half)
    right, bottom = plane.place(0.5 + half, -0.5 + half)
    body = [*plane.drawn(), cells(levels_of(curve["level"]), LOW, HIGH, (left, top, right, bottom))]
    peaks = peaks_of(entry)[:NAMED]
    for place, peak in enumerate(peaks, start=1):
        x, y = (peak.x, peak.y) if peak.x >= 0 else (-peak.x, -peak.y)
        px, py = plane.place(x, -y)
        body.append(f'<circle class="peak" cx="{px:.1f}" cy="{py:.1f}" r="6"><title>{peak.words()}</title></circle>')
        body.append(f'<g class="on">{drawn_text(px + 9, py + 4, str(place), "start")}</g>')
    bar = (plane.box[0], SIZE[1] - 40, plane.box[2], 0)
    body += scale_bar(LOW, HIGH, label="dB to 1 radiance²", box=bar)
    if not peaks:
        return drawing(SIZE, "Spectrum of the error", body), (
            "No peak stands over its surroundings: the error has no stripes of its own."
        )
    named = "; ".join(f"({place}) {peak.words()}" for place, peak in enumerate(peaks, start=1))
    more = len(peaks_of(entry)) - len(peaks)
    return drawing(SIZE, "Spectrum of the error", body), (
        f"Bright spots are stripes in the error: {named}{f', and {more} weaker ones' if more else ''}."
    )


def stripes(picture: str, size: tuple[int, int], peaks: Sequence[Peak]) -> str:
    """An SVG of a picture (a data URL, width and height in px) with the stripes of peaks on it; "" without any.

    Stripes have their direction and spacing; where along it they lie is not known.
    """
    if not peaks:
        return ""
    width, height = size
    body = [f'<image class="cells" width="{width}" height="{height}" href="{picture}"/>']
    chosen = peaks[:NAMED]
    for place, peak in enumerate(chosen):
        # Each peak's lines about a place of its own, in a circle.
        middle = ((place + 0.5) * width / len(chosen), height / 2)
        reach = min(width / len(chosen), height) / 2 * 0.85
        reach = min(max(reach, 1.1 / peak.frequency), height / 2)
        across = (peak.x / peak.frequency, peak.y / peak.frequency)
        period = 1 / peak.frequency
        fit = min(STRIPES // 2, int(reach / period))
        lines = []
        for line in range(-fit, fit + 1):
            away = line * period
            long = math.sqrt(max(0.0, reach**2 - away**2))
            x, y = middle[0] + away * across[0], middle[1] + away * across[1]
            dx, dy = -across[1] * long, across[0] * long
            lines.append(f"M{x - dx:.1f} {y - dy:.1f}L{x + dx:.1f} {y + dy:.1f}")
        path = "".join(lines)
        body.append(f'<path class="under" d="{path}"/>')
        body.append(f'<path class="stripe" d="{path}"><title>{peak.words()}</title></path>')
        body.append(f'<text class="mark" x="{middle[0] - reach:.1f}" y="{height - 3}">{place + 1}</text>')
    return drawing(size, "Stripes of the peaks on the picture", body)
