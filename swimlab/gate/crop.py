"""The region of a frame where its error is largest, and a picture of it beside the reference."""

from pathlib import Path

import numpy as np

from swimlab.report.contact import GAP, PAPER, write
from swimlab.report.display import COVERED, ERROR_RANGE, Picture, srgb
from swimlab.runs.files import replacing
from swimlab.runs.frames import read_frame
from swimlab.runs.png import png

Region = tuple[int, int, int, int]

SIDE = 64
"""Width and height of the region, px, where the frame is as large."""
ENLARGED = 4
HEADER = 24


def worst_region(test: Path, reference: Path) -> Region:
    """The square (x, y, width, height) of the largest squared error, over wholly covered pixels."""
    exact = read_frame(reference)
    squared = np.square(read_frame(test)[..., :3].astype(np.float64) - exact[..., :3]).sum(axis=2)
    squared[exact[..., 3] < COVERED] = 0.0
    height, width = squared.shape
    w, h = min(SIDE, width), min(SIDE, height)
    summed = np.pad(squared, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    boxes = summed[h:, w:] - summed[:-h, w:] - summed[h:, :-w] + summed[:-h, :-w]
    y, x = np.unravel_index(int(np.argmax(boxes)), boxes.shape)
    return int(x), int(y), w, h


def write_crop(path: Path, test: Path, reference: Path, region: Region) -> None:
    """Write a region as PNG, enlarged pixel by pixel: picture, reference, and their difference.

    Pictures are sRGB at exposure 1. The difference is grey where there is none; a channel is 255 where the picture
    is brighter by ERROR_RANGE of linear radiance and 1 where it is darker by as much, in any frame.
    """
    x, y, width, height = region
    cut, exact = (read_frame(each)[y : y + height, x : x + width, :3] for each in (test, reference))
    error = np.rint(np.clip((cut - exact) / ERROR_RANGE, -1, 1) * 127 + 128).astype(np.uint8)
    panels = {
        test.parent.name: srgb(cut),
        reference.parent.name: srgb(exact),
        f"error +-{ERROR_RANGE:g}": error,
    }
    with replacing(path) as temporary:
        temporary.write_bytes(png(_sheet(panels)))


def _sheet(panels: dict[str, Picture]) -> Picture:
    large = {name: panel.repeat(ENLARGED, axis=0).repeat(ENLARGED, axis=1) for name, panel in panels.items()}
    height, width = next(iter(large.values())).shape[:2]
    sheet: Picture = np.empty((HEADER + height, len(large) * (width + GAP) - GAP, 3), np.uint8)
    sheet[:] = PAPER
    for place, (name, panel) in enumerate(large.items()):
        left = place * (width + GAP)
        sheet[HEADER:, left : left + width] = panel
        write(sheet, name, (left + 4, HEADER - 8))
    return sheet
