"""Contact sheets of variants: details near the eye and far from it, enlarged, in consecutive frames."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from swimlab.report.clips import Region
from swimlab.report.contact import CELL, ENLARGED, GAP, HEADER, PAPER, column, enlarge, exposure, write
from swimlab.report.display import srgb
from swimlab.runs.frames import Image, png

FAR = 16.0
"""Metres: a detail lies on the one side or the other."""
LINE = 18


def contact_sheet(pictures: Mapping[str, Sequence[Image]], depth: Image) -> bytes:
    """A PNG, sRGB: a row for each label, its frames [H, W, 4] side by side, first of the near detail, then of the far.

    The details are where the first frames of all rows differ most; depth: [H, W] of these, m. Exposure is the same for
    all, set by the last row.
    """
    labels, frames = list(pictures), list(range(len(next(iter(pictures.values())))))
    last = pictures[labels[-1]][0]
    stops = exposure(last)
    coded = {label: [srgb(2.0**stops * rgba[..., :3]) for rgba in rows] for label, rows in pictures.items()}
    spread = np.stack([rows[0].mean(axis=2) for rows in coded.values()]).std(axis=0) * (last[..., 3] == 1)
    details = {"near": _detail(spread * (depth < FAR)), "far": _detail(spread * (depth >= FAR))}
    columns = [(f"{where}, frame {frame}", frame, region) for where, region in details.items() for frame in frames]
    sheet = np.full((HEADER + len(labels) * (CELL[1] + GAP), column(len(columns)), 3), PAPER, np.uint8)
    for place, (heading, _, _) in enumerate(columns):
        write(sheet, f"{heading}, x{ENLARGED}, {stops:+d} EV", (column(place), HEADER - 8))
    for row, label in enumerate(labels):
        top = HEADER + row * (CELL[1] + GAP)
        for line, text in enumerate(label.split("\n")):
            write(sheet, text, (6, top + CELL[1] // 2 + LINE * line))
        for place, (_, frame, region) in enumerate(columns):
            cell = enlarge(coded[label][frame], region)
            sheet[top : top + CELL[1], column(place) : column(place) + CELL[0]] = cell
    return png(sheet)


def _detail(spread: Image) -> Region:
    """The region (x, y, width, height) of a cell's size with the largest sum."""
    height, width = spread.shape
    w, h = min(CELL[0] // ENLARGED, width), min(CELL[1] // ENLARGED, height)
    sums = cv2.boxFilter(spread.astype(np.float64), -1, (w, h), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
    inside = sums[: height - h + 1, : width - w + 1]
    y, x = np.unravel_index(int(np.argmax(inside)), inside.shape)
    return int(x), int(y), w, h
