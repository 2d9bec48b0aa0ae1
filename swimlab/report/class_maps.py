"""Where on the picture tiles reach, where there are edges, what comes into view, and where edges flicker."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrics.levels import levels_of
from swimlab.report.charts import drawing, drawn_text, number
from swimlab.report.heat import cells, image, scale_bar
from swimlab.report.palette import CLASSES

LOW, HIGH = -3.0, 0.0
"""Powers of ten of the rms flicker at the scale's ends."""

WIDTH = 420.0
LEFT, TOP = 20.0, 10.0
BELOW = 48.0


def class_map(entry: Mapping[str, Any]) -> tuple[str, str]:
    """An SVG of the classes of pixels, mean over the frames, and what to see in it; both "" where there is none."""
    curve, scores = entry.get("curves", {}).get("frame.map"), entry["scores"]
    if not curve or not {"measured.fraction", "edges.fraction", "new.fraction"} <= scores.keys():
        return "", ""
    shares = {name: levels_of(curve[name]) / 100 for name in CLASSES}
    colours = np.sum([share[..., None] * rgb(CLASSES[name]) for name, share in shares.items()], axis=0)
    box = _box(colours.shape)
    body = [image(np.rint(colours).astype(np.uint8), box)]
    words = {"measured": "tiles reach", "edges": "edges", "new": "just come into view"}
    for place, (name, text) in enumerate(words.items()):
        left = LEFT + place * WIDTH / 3
        body.append(f'<rect x="{left:.1f}" y="{box[3] + 14:.1f}" width="12" height="12" fill="{CLASSES[name]}"/>')
        body.append(drawn_text(left + 18, box[3] + 24, text, "start"))
    sentence = (
        f"Of the covered pixels tiles reach {scores['measured.fraction']:.0%}, of which budget, residual and plane "
        f"speak; edges.* speak of {scores['edges.fraction']:.0%}, new.* of {scores['new.fraction']:.0%}. "
        "Black is not covered."
    )
    return drawing((int(2 * LEFT + WIDTH), int(box[3] + BELOW)), "Classes of pixels", body), sentence


def edge_map(entry: Mapping[str, Any]) -> tuple[str, str]:
    """An SVG of the rms flicker of edges, and what to see in it; both "" where there is none."""
    curve = entry.get("curves", {}).get("frame.map", {})
    if "flicker" not in curve or "edges.flicker" not in entry["scores"]:
        return "", ""
    has_edges = levels_of(curve["edges"]) > 0
    rms = np.where(has_edges, levels_of(curve["flicker"]) / 20, np.nan)
    box = _box(rms.shape)
    body = [cells(rms, LOW, HIGH, box)]
    body += scale_bar(LOW, HIGH, label="rms flicker of edges", box=(LEFT, box[3] + 10, LEFT + WIDTH, 0), log=True)
    sentence = "No cell of the picture has edges in one pixel of a hundred."
    if has_edges.any():
        row, column = np.unravel_index(int(np.nanargmax(rms)), rms.shape)
        side = curve["cell"][0]
        sentence = (
            f"Grey has no edges. They flicker most, rms {number(float(10 ** rms[row, column]))}, "
            f"about ({(int(column) + 0.5) * side:.0f}, {(int(row) + 0.5) * side:.0f}) px; "
            f"on average {number(float(np.sqrt(entry['scores']['edges.flicker'])))}."
        )
    return drawing((int(2 * LEFT + WIDTH), int(box[3] + BELOW)), "Flicker of edges", body), sentence


def rgb(colour: str) -> NDArray[np.float64]:
    """[3] sRGB codes of #rrggbb."""
    return np.array([int(colour[start : start + 2], 16) for start in (1, 3, 5)], dtype=np.float64)


def _box(shape: tuple[int, ...]) -> tuple[float, float, float, float]:
    return LEFT, TOP, LEFT + WIDTH, TOP + WIDTH * shape[0] / shape[1]
