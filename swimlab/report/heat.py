"""Pictures of numbers on a fixed, printed scale: a row of cells per row of values, in a map that any eye can rank."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from swimlab.report.charts import drawn_text, ticks
from swimlab.report.display import webp

Values = NDArray[np.float64]
Box = tuple[float, float, float, float]

STEPS = 64
UNKNOWN = (128, 128, 128)
BAR = 8.0


def cells(values: Values, low: float, high: float, box: Box) -> str:
    """An SVG image of [rows, columns] in a box (left, top, right, bottom), the first row at the top.

    Values from `low` (dark) to `high` (bright) in STEPS colours, beyond them the ends'; NaN is grey.
    """
    share = np.nan_to_num(np.clip((values - low) / (high - low), 0.0, 1.0))
    colours = _colours()[np.rint(share * (STEPS - 1)).astype(int)]
    colours[np.isnan(values)] = UNKNOWN
    return image(colours, box)


def image(codes: NDArray[np.uint8], box: Box) -> str:
    """An SVG image of sRGB codes [rows, columns, 3] in a box (left, top, right, bottom)."""
    return _picture(webp(codes), box)


def scale_bar(low: float, high: float, *, label: str, box: Box, log: bool = False) -> list[str]:
    """The colours from `low` to `high` with their values and what they are; `log`: the values are powers of ten."""
    left, top, right, _ = box
    body = [_picture(_all_colours(), (left, top, right, top + BAR))]
    marks = [(k, f"{10.0**k:g}") for k in range(math.ceil(low), math.floor(high) + 1)] if log else _ticks(low, high)
    for value, text in marks:
        at = left + (value - low) / (high - low) * (right - left)
        body.append(drawn_text(at, top + BAR + 13, text, "middle"))
    body.append(drawn_text((left + right) / 2, top + BAR + 29, label, "middle"))
    return body


def numbers(rows: Sequence[Sequence[float | None]]) -> Values:
    """[rows, columns], NaN where there is no value."""
    return np.array([[math.nan if value is None else value for value in row] for row in rows], dtype=np.float64)


def _picture(picture: str, box: Box) -> str:
    left, top, right, bottom = box
    return (
        f'<image class="cells" x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" height="{bottom - top:.1f}" '
        f'preserveAspectRatio="none" href="data:image/webp;base64,{picture}"/>'
    )


@lru_cache(maxsize=1)
def _all_colours() -> str:
    return webp(_colours()[None])


def _ticks(low: float, high: float) -> list[tuple[float, str]]:
    return ticks(low, high, "linear")


def _colours() -> NDArray[np.uint8]:
    """[STEPS, 3] sRGB, from dark to bright: Inferno (Smith and van der Walt 2015), of even steps to the eye."""
    import cv2  # heavy

    codes = np.rint(np.linspace(0, 255, STEPS)).astype(np.uint8)[:, None]
    return np.array(cv2.applyColorMap(codes, cv2.COLORMAP_INFERNO)[:, 0, ::-1], dtype=np.uint8)
