"""Splines through pictures and motion fields, and pictures taken at other places, on all cores."""

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from metrics.kernels.splines import LINES, filter_lines, interleave_rows, unwarp_rows

Values = NDArray[np.float32]


def field_spline(launcher: Launcher, motion: Values) -> Any:
    """Cubic coefficients of a motion field [H, W, 2], px (x, y), on the device."""
    return _filtered(launcher, launcher.array(motion, wp.vec2), 2, 3)


def picture_spline(launcher: Launcher, planes: Values) -> Any:
    """Quintic coefficients of a picture's planes [1 to 3, H, W], on the device, as vectors of 4."""
    height, width = planes.shape[1:]
    picture = launcher.empty((height, width), wp.vec4)
    launcher.over(height, interleave_rows(launcher.device), (), [launcher.view(planes, wp.float32), picture])
    return _filtered(launcher, picture, 4, 5)


def _filtered(launcher: Launcher, values: Any, width: int, degree: int) -> Any:
    kernel = filter_lines(width, degree, launcher.device)
    for lines in (values, values.transpose()):
        launcher.over(lines.shape[0], kernel, (), [lines], each=LINES)
    return values


def taken(launcher: Launcher, spline: Any, away: Any, usable: Any, top: int, channels: int) -> Values:
    """Rows of a picture from `top` on, as many as `away` and `usable` have, taken `away`: [channels, rows, W]."""
    seen = launcher.empty((channels, *away.shape), wp.float32)
    launcher.over(away.shape[0], unwarp_rows(launcher.device), (), [spline, away, usable, top, seen])
    return np.asarray(seen.numpy())
