"""What the rasteriser and the plane equations say about each sample of a grid, for tests."""

from typing import NamedTuple

import numpy as np
import warp as wp

from metrics.kernels.launch import Launcher, Strip
from swimlab.render.kernels.inspection import surfaces
from swimlab.render.kernels.structs import Grid
from swimlab.render.triangles import Triangles, visibility


class Seen(NamedTuple):
    """[H, W, ...] of each sample: whether it hits, uv, d(uv) by cell right and down, position relative to the eye."""

    hit: np.ndarray
    uv: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    position: np.ndarray


def see(launcher: Launcher, triangles: Triangles, grid: Grid) -> Seen:
    """Look at every sample of a grid."""
    size = (grid.height, grid.width)
    visible = visibility(launcher, triangles, grid, Strip(0, grid.height))
    found = [wp.zeros(size, dtype=kind, device="cpu") for kind in (wp.vec2d, wp.vec2d, wp.vec2d, wp.vec3d)]
    launcher.launch(surfaces, size, [grid, visible, triangles.planes, *found])
    return Seen(visible.numpy() >= 0, *(each.numpy() for each in found))
