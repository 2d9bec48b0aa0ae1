"""Pictures that a notebook shows: labelled panels side by side, as PNG with a text for readers who cannot see them."""

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from swimlab.report.display import COVERED, ERROR_COLOURS, ERROR_RANGE
from swimlab.runs.files import replacing
from swimlab.runs.frames import Image, png

Codes = NDArray[np.uint8]
"""[H, W, 3] sRGB codes."""
Panel = tuple[str, Codes]
"""A label and what it stands over."""

GAP = 6
HEADER = 20
PAPER = 250
INK = (30, 30, 30)
LETTER = 8
"""Width of a letter of a label, px, about."""
OUTSIDE = 128


class Picture:
    """A picture as PNG. alt: what it shows, in words; it is also the caption."""

    def __init__(self, codes: Codes, alt: str) -> None:
        self.codes = codes
        self.alt = alt

    @property
    def png(self) -> bytes:
        """The file's bytes."""
        return png(self.codes)

    def save(self, path: str | Path) -> Path:
        """Write the PNG, whole or not at all."""
        with replacing(Path(path)) as temporary:
            temporary.write_bytes(self.png)
        return Path(path)

    def __repr__(self) -> str:
        return f"Picture({self.alt!r})"

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.png).decode("ascii")
        words = escape(self.alt)
        image = f'<img alt="{words}" src="data:image/png;base64,{data}" style="max-width:none">'
        return f"<figure>{image}<figcaption>{words}</figcaption></figure>"


def enlarge(codes: Codes, zoom: int) -> Codes:
    """Every pixel as zoom x zoom pixels."""
    return codes.repeat(zoom, axis=0).repeat(zoom, axis=1)


def error_colours(test: Image, reference: Image) -> Codes:
    """Colours of test - reference (both RGBA [H, W, 4]), mean of R, G and B, on the fixed scale +-ERROR_RANGE.

    Grey where the reference does not cover the pixel wholly.
    """
    error = np.mean(test[..., :3] - reference[..., :3], axis=2)
    coloured = on_scale(np.clip(error / ERROR_RANGE, -1, 1))
    coloured[reference[..., 3] < COVERED] = OUTSIDE
    return coloured


def on_scale(value: NDArray[np.floating]) -> Codes:
    """Colours [..., 3] of values -1..1."""
    place = (np.asarray(value, np.float64) + 1) / 2 * (len(ERROR_COLOURS) - 1)
    channels = [np.interp(place, np.arange(len(ERROR_COLOURS)), stops) for stops in zip(*ERROR_COLOURS, strict=True)]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)


def scale_bar(width: int) -> Codes:
    """The scale of errors with its ends printed, [2 HEADER, width, 3]."""
    bar = on_scale(np.broadcast_to(np.linspace(-1, 1, width), (HEADER - GAP, width)))
    words = np.full((HEADER + GAP, width, 3), PAPER, np.uint8)
    top, middle = f"+{ERROR_RANGE:g}", "0"
    for text, left in ((f"-{ERROR_RANGE:g}", 0), (middle, width // 2 - 4), (top, width - LETTER * len(top))):
        _write(words, text, left, HEADER - 5)
    return np.concatenate([bar, words])


def sheet(rows: Sequence[Sequence[Panel]]) -> Codes:
    """Rows of labelled panels on paper; a column is as wide as its widest panel or label."""
    across = max(len(row) for row in rows)
    widths = [
        max(max(row[i][1].shape[1], LETTER * len(row[i][0])) for row in rows if i < len(row)) for i in range(across)
    ]
    lefts = np.concatenate([[0], np.cumsum([width + GAP for width in widths])])
    strips = []
    for row in rows:
        height = HEADER + max(panel.shape[0] for _, panel in row)
        strip = np.full((height + GAP, int(lefts[-1]) - GAP, 3), PAPER, np.uint8)
        for left, (label, panel) in zip(lefts, row, strict=False):
            strip[HEADER : HEADER + panel.shape[0], left : left + panel.shape[1]] = panel
            _write(strip, label, int(left), HEADER - 6)
        strips.append(strip)
    return np.concatenate(strips)


def _write(codes: Codes, text: str, left: int, base: int) -> None:
    cv2.putText(codes, text, (left, base), cv2.FONT_HERSHEY_SIMPLEX, 0.42, INK, 1, cv2.LINE_AA)
