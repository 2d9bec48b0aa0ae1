"""Coverage, motion and depth of each pixel."""

import warp as wp

from swimlab.render.kernels.footprint import surface_at
from swimlab.render.kernels.structs import Grid, Planes

wp.set_module_options({"enable_backward": False})


@wp.struct
class Previous:
    """The previous frame: its grid, and the projection of a position about the present eye to px (x w, y w, w)."""

    projection: wp.mat33d
    offset: wp.vec3d
    origin: wp.vec2d
    pitch: wp.vec2d


@wp.func
def place_before(previous: Previous, position: wp.vec3d) -> wp.vec3d:
    """Where the previous frame saw a position relative to the eye now: cells right and down, and m along its axis."""
    before = previous.projection @ (position + previous.offset)
    return wp.vec3d(
        (before[0] / before[2] - previous.origin[0]) / previous.pitch[0],
        (before[1] / before[2] - previous.origin[1]) / previous.pitch[1],
        before[2],
    )


@wp.kernel
def describe(
    first_row: wp.int32,
    n: wp.int32,
    grid: Grid,
    planes: wp.array(dtype=Planes),
    centres: wp.array2d(dtype=wp.int32),
    cells: wp.array2d(dtype=wp.int32),
    previous: Previous,
    coverage: wp.array2d(dtype=wp.float32),
    motion: wp.array2d(dtype=wp.vec2),
    depth: wp.array2d(dtype=wp.float32),
):
    """Coverage from n x n cells a pixel; motion (px) and depth (m) at the pixel's centre, 0 where it sees nothing."""
    row, i = wp.tid()
    j = first_row + row
    hits = wp.int32(0)
    for y in range(n):
        for x in range(n):
            if cells[row * n + y, i * n + x] >= 0:
                hits += 1
    coverage[j, i] = wp.float32(hits) / wp.float32(n * n)
    motion[j, i] = wp.vec2(0.0, 0.0)
    depth[j, i] = 0.0
    triangle = centres[row, i]
    if triangle >= 0:
        half = wp.float64(0.5)
        cell = wp.vec2d(wp.float64(i) + half, wp.float64(j) + half)
        p = wp.vec2d(grid.origin[0] + cell[0] * grid.pitch[0], grid.origin[1] + cell[1] * grid.pitch[1])
        surface = surface_at(planes[triangle], grid, p)
        was = place_before(previous, surface.position)
        motion[j, i] = wp.vec2(wp.float32(cell[0] - was[0]), wp.float32(cell[1] - was[1]))
        plane = planes[triangle]
        depth[j, i] = wp.float32(wp.float64(1.0) / (plane[0, 0] * p[0] + plane[0, 1] * p[1] + plane[0, 2]))
