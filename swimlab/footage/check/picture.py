"""A picture of where the motion does not fit."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swimlab.footage.check.grey import COLUMNS, ROWS
from swimlab.footage.check.regions import Region
from swimlab.runs.files import replacing
from swimlab.runs.frames import Image, png

_CALM = 0.35
"""Brightness of what fits."""


def write_region(path: Path, picture: Image, region: Region) -> None:
    """Write a frame [H, W, 3] of radiance as PNG, what fits the motion darkened."""
    with replacing(path) as temporary:
        temporary.write_bytes(png(marked(picture, region.blocks)))


def marked(picture: Image, unfit: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """A frame [H, W, 3] as codes of its root, darkened but in blocks [ROWS, COLUMNS] that are unfit."""
    height, width = picture.shape[:2]
    row, column = np.arange(height) * ROWS // height, np.arange(width) * COLUMNS // width
    white = float(np.percentile(picture, 99)) or 1.0
    code = np.sqrt(np.clip(picture / white, 0, 1)) * np.where(unfit[row[:, None], column], 1.0, _CALM)[..., None]
    return np.asarray(np.rint(255 * code), np.uint8)
