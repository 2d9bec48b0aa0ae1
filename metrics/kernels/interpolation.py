"""Splines through pictures and motion fields, and pictures taken at other places, on all cores."""

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from metrics.kernels.splines import LINES, filter_lines
from metrics.kernels.unwarping import unwarp_rows

Values = NDArray[np.float32]


class Splines:
    """Makes coefficients of splines on the device."""

    def __init__(self, launcher: Launcher) -> None:
        self.launcher = launcher

    def of_field(self, motion: Values) -> Any:
        """Cubic coefficients [2, H, W] (x, y) of a motion field [H, W, 2], px."""
        field = self.launcher.view(motion, wp.float32)
        return self._coefficients([field[:, :, axis] for axis in range(2)], 3)

    def of_picture(self, planes: Values) -> Any:
        """Quintic coefficients of a picture's planes [1 to 3, H, W]."""
        picture = self.launcher.view(planes, wp.float32)
        return self._coefficients([picture[channel] for channel in range(len(planes))], 5)

    def _coefficients(self, planes: list[Any], degree: int) -> Any:
        found = self.launcher.empty((len(planes), *planes[0].shape), wp.float32)
        for number, plane in enumerate(planes):
            self._filter(plane, found[number], degree)
            self._filter(found[number].transpose(), found[number].transpose(), degree)
        return found

    def _filter(self, source: Any, values: Any, degree: int) -> None:
        launcher, (lines, length) = self.launcher, values.shape

        def scratch(rows: int) -> list[Any]:
            return [launcher.empty(-(-rows // LINES) * LINES * length, wp.float32)]

        kernel = filter_lines(degree, launcher.device)
        launcher.over(lines, kernel, (), [source, values], each=LINES, own=scratch)


def taken(launcher: Launcher, spline: Any, away: Any, usable: Any, top: int, channels: int) -> Values:
    """Rows of a picture from `top` on, as many as `away` and `usable` have, taken `away`: [channels, rows, W]."""
    seen = launcher.empty((channels, *away.shape), wp.float32)
    launcher.over(away.shape[0], unwarp_rows(launcher.device), (), [spline, away, usable, top, seen])
    return np.asarray(seen.numpy())
