"""The strip: when, and at which fineness, a technique errs. Frames to the right, bands of frequency upwards."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from swimlab.report.charts import drawing, drawn_text, number, ticks
from swimlab.report.heat import cells, numbers, scale_bar

LOW, HIGH = -3.0, 0.0
"""Powers of ten of the rms error at the scale's ends."""

SIZE = (460, 260)
BOX = (112.0, 10.0, 448.0, 172.0)


def strip(entry: Mapping[str, Any]) -> tuple[str, str]:
    """An SVG of the curve `budget.strip`, and what to see in it; both "" where there is none."""
    curve = entry.get("curves", {}).get("budget.strip")
    if not curve or not curve["error"] or not curve["error"][0]:
        return "", ""
    error = numbers(curve["error"])
    if not np.isfinite(error).any():
        return "", ""
    frames = [row["frame"] for row in entry["frames"]]
    names = _bands(curve["frequency"])
    left, top, right, bottom = BOX
    high, wide = (bottom - top) / len(names), (right - left) / error.shape[1]
    body = [cells(np.log10(np.maximum(error[::-1], 1e-9)), LOW, HIGH, BOX)]
    for row, name in enumerate(names):
        at = bottom - (row + 0.5) * high
        body.append(drawn_text(left - 6, at + 4, name, "end"))
    for value, text in ticks(0, max(1, len(frames) - 1), "linear"):
        if value == int(value) and value < len(frames):
            label = str(frames[int(value)]) if len(frames) > 1 else text
            body.append(drawn_text(left + (value + 0.5) * wide, bottom + 16, label, "middle"))
    body.append(drawn_text((left + right) / 2, bottom + 32, "frame", "middle"))
    middle = (top + bottom) / 2
    body.append(f'<g transform="rotate(-90 12 {middle})">{drawn_text(12, middle, "cycles/pixel", "middle")}</g>')
    body += scale_bar(LOW, HIGH, label="rms error", box=(left, bottom + 42, right, 0), log=True)
    band, frame = np.unravel_index(int(np.nanargmax(error)), error.shape)
    mean = np.sqrt(np.nanmean(error**2, axis=1))
    sentence = (
        f"Upright stripes are bad frames, level ones lasting errors: most error lies at {names[int(np.argmax(mean))]} "
        f"cycles/pixel (rms {number(float(mean.max()))}), at its worst {number(float(error[band, frame]))} "
        f"at {names[band]} in frame {frames[frame]}."
    )
    return drawing(SIZE, "Error by frame and frequency band", body), sentence


def _bands(edges: list[float]) -> list[str]:
    """Octaves in words: from each edge to the next."""
    words = [f"1/{round(1 / edge)}" if edge else "0" for edge in edges]
    return [f"{low} to {high}" for low, high in pairwise(words)] + [f"over {words[-1]}"]
