"""What the rasteriser and the plane equations say about each sample of a grid, for tests."""

from typing import NamedTuple

import numpy as np
import warp as wp

from swimlab.kernels.footprint import surface_at
from swimlab.kernels.raster import sample_position
from swimlab.kernels.structs import Grid, Planes
from swimlab.launch import Launcher, Strip
from swimlab.triangles import Triangles, visibility


class Seen(NamedTuple):
    """[H, W, ...] of each sample: whether it hits, uv, d(uv) by cell right and down, position relative to the eye."""

    hit: np.ndarray
    uv: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    position: np.ndarray


@wp.kernel(enable_backward=False)
def look(
    grid: Grid,
    visible: wp.array2d(dtype=wp.int32),
    planes: wp.array(dtype=Planes),
    uv: wp.array2d(dtype=wp.vec2d),
    dx: wp.array2d(dtype=wp.vec2d),
    dy: wp.array2d(dtype=wp.vec2d),
    position: wp.array2d(dtype=wp.vec3d),
):
    j, i = wp.tid()
    triangle = visible[j, i]
    if triangle >= 0:
        surface = surface_at(planes[triangle], grid, sample_position(grid, i, j))
        uv[j, i] = surface.uv
        dx[j, i] = surface.dx
        dy[j, i] = surface.dy
        position[j, i] = surface.position


def see(launcher: Launcher, triangles: Triangles, grid: Grid) -> Seen:
    """Look at every sample of a grid."""
    size = (grid.height, grid.width)
    visible = visibility(launcher, triangles, grid, Strip(0, grid.height))
    found = [wp.zeros(size, dtype=kind, device="cpu") for kind in (wp.vec2d, wp.vec2d, wp.vec2d, wp.vec3d)]
    launcher.launch(look, size, [grid, visible, triangles.planes, *found])
    return Seen(visible.numpy() >= 0, *(each.numpy() for each in found))
