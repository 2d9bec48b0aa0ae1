"""Splines through pictures and motion fields, and pictures taken at other places, on all cores."""

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from metrics.kernels.splines import LINES, filter_lines
from metrics.kernels.unwarping import unwarp_rows

Values = NDArray[np.float32]


def field_spline(launcher: Launcher, motion: Values) -> Any:
    """Cubic coefficients [2, H, W] (x, y) of a motion field [H, W, 2], px."""
    field = launcher.view(motion, wp.float32)
    return _coefficients(launcher, [field[:, :, axis] for axis in range(2)], 3)


def picture_spline(launcher: Launcher, planes: Values) -> Any:
    """Quintic coefficients of a picture's planes [1 to 3, H, W]."""
    picture = launcher.view(planes, wp.float32)
    return _coefficients(launcher, [picture[channel] for channel in range(len(planes))], 5)


def _coefficients(launcher: Launcher, planes: list[Any], degree: int) -> Any:
    found = launcher.empty((len(planes), *planes[0].shape), wp.float32)
    for number, plane in enumerate(planes):
        _filter(launcher, plane, found[number], degree)
        _filter(launcher, found[number].transpose(), found[number].transpose(), degree)
    return found


def _filter(launcher: Launcher, source: Any, values: Any, degree: int) -> None:
    lines, length = values.shape

    def scratch(rows: int) -> list[Any]:
        return [launcher.empty(-(-rows // LINES) * LINES * length, wp.float32)]

    launcher.over(lines, filter_lines(degree, launcher.device), (), [source, values], each=LINES, own=scratch)


def taken(launcher: Launcher, spline: Any, away: Any, usable: Any, top: int, channels: int) -> Values:
    """Rows of a picture from `top` on, as many as `away` and `usable` have, taken `away`: [channels, rows, W]."""
    seen = launcher.empty((channels, *away.shape), wp.float32)
    launcher.over(away.shape[0], unwarp_rows(launcher.device), (), [spline, away, usable, top, seen])
    return np.asarray(seen.numpy())
