"""One colour per technique, the same in every table, legend and chart, distinguished with any colour vision.

Colours of techniques: Paul Tol's "bright" scheme (Tol, Colour Schemes, SRON/EPS/TN/09-002, 2021), with dashes, and
other marks, when it runs out. Colours of parts and of classes of pixels: Okabe and Ito, Color Universal Design, 2008.
"""

from collections.abc import Sequence
from typing import NamedTuple

from swimlab.runs.record import REFERENCE


class Ink(NamedTuple):
    """A colour and the SVG dash pattern of a line ("" is solid)."""

    colour: str
    dash: str

    def mark(self, x: float, y: float, radius: float) -> str:
        """The SVG tag and place of a mark at (x, y); its shape tells inks of one colour apart as their dashes do."""
        r = radius
        if self.dash == DASHES[1]:
            return f'path d="M{x - r:.1f} {y - r:.1f}h{2 * r:g}v{2 * r:g}h{-2 * r:g}Z"'
        if self.dash == DASHES[2]:
            return f'path d="M{x:.1f} {y - 1.3 * r:.1f}l{1.3 * r:g} {2.2 * r:g}h{-2.6 * r:g}Z"'
        return f'circle cx="{x:.1f}" cy="{y:.1f}" r="{r:g}"'


TECHNIQUES = ("#ee6677", "#ccbb44", "#66ccee", "#4477aa", "#aa3377", "#228833")
DASHES = ("", "6 3", "2 3")
CLASSES = {"measured": "#0072b2", "edges": "#e69f00", "new": "#cc79a7"}
PARTS = {
    "bias": "#999999",
    "detail": "#56b4e9",
    "flicker": "#d55e00",
    "on the plane": "#56b4e9",
    "order 1": "#d55e00",
    "order 2": "#e69f00",
    "off every plane": "#999999",
}


def inks(techniques: Sequence[str]) -> dict[str, Ink]:
    """Ink of each technique by its place in the list; the reference has the colour of the text."""
    chosen = {REFERENCE: Ink("currentColor", "")}
    for place, name in enumerate(name for name in techniques if name != REFERENCE):
        turn, colour = divmod(place, len(TECHNIQUES))
        chosen[name] = Ink(TECHNIQUES[colour], DASHES[turn % len(DASHES)])
    return chosen
