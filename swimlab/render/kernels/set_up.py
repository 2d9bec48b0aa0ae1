"""Set-up of triangles, one a thread: edge functions, plane equations, and the rows that a triangle reaches.

Two triangles that share an edge must hold bitwise opposite edge functions, so no product is fused with a sum here.
"""

import warp as wp

from swimlab.render.kernels.raster import NEAR
from swimlab.render.kernels.structs import Edges, Grid, Planes

wp.set_module_options({"enable_backward": False, "fuse_fp": False})

BEYOND = 1.0e300
"""A y that no sample has, px."""


@wp.func
def across(a: wp.vec3d, b: wp.vec3d) -> wp.vec3d:
    """a x b; across(b, a) is exactly its opposite, bit by bit."""
    return wp.vec3d(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@wp.func
def rows_reached(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d) -> wp.vec2d:
    """Lowest and highest y of a triangle, px; everything where a vertex is not in front of the near plane."""
    near = wp.float64(NEAR)
    if a[2] <= near or b[2] <= near or c[2] <= near:
        return wp.vec2d(wp.float64(-BEYOND), wp.float64(BEYOND))
    first = a[1] / a[2]
    second = b[1] / b[2]
    third = c[1] / c[2]
    return wp.vec2d(wp.min(wp.min(first, second), third), wp.max(wp.max(first, second), third))


@wp.kernel
def set_up_triangles(
    first: wp.int32,
    points: wp.array(dtype=wp.vec3d),
    uv: wp.array(dtype=wp.vec2d),
    positions: wp.array(dtype=wp.vec3d),
    slope: wp.array(dtype=wp.float64),
    corners: wp.array(dtype=wp.vec3i),
    drawn: wp.array(dtype=wp.bool),
    edges: wp.array(dtype=Edges),
    planes: wp.array(dtype=Planes),
    bounds: wp.array(dtype=wp.vec2d),
):
    """Edge functions and plane equations (Olano & Greer 1997) from homogeneous image coordinates.

    With e0 = v1 x v2 and so on and d = v0 . e0, 1/w = sum e_k / d and a/w = sum a_k e_k / d. A triangle seen from
    behind has all signs turned. What is not `drawn` reaches no row.
    """
    k = first + wp.tid()
    i = corners[k][0]
    j = corners[k][1]
    m = corners[k][2]
    zero = wp.float64(0.0)
    e0 = across(points[j], points[m])
    e1 = across(points[m], points[i])
    e2 = across(points[i], points[j])
    determinant = points[i][0] * e0[0] + points[i][1] * e0[1] + points[i][2] * e0[2]
    if determinant < zero:
        e0 = -e0
        e1 = -e1
        e2 = -e2
    area = wp.abs(determinant)
    if determinant == zero:
        e0 = wp.vec3d(zero, zero, zero)
        e1 = wp.vec3d(zero, zero, zero)
        e2 = wp.vec3d(zero, zero, zero)
        area = wp.float64(1.0)
    bounds[k] = rows_reached(points[i], points[j], points[m])
    if not drawn[k]:
        bounds[k] = wp.vec2d(wp.float64(BEYOND), wp.float64(-BEYOND))
    for column in range(3):
        x0 = e0[column]
        x1 = e1[column]
        x2 = e2[column]
        edges[k][0, column] = x0
        edges[k][1, column] = x1
        edges[k][2, column] = x2
        planes[k][0, column] = (x0 + x1 + x2) / area
        for axis in range(2):
            planes[k][1 + axis, column] = (uv[i][axis] * x0 + uv[j][axis] * x1 + uv[m][axis] * x2) / area
        for axis in range(3):
            value = positions[i][axis] * x0 + positions[j][axis] * x1 + positions[m][axis] * x2
            planes[k][3 + axis, column] = value / area
        planes[k][6, column] = (slope[i] * x0 + slope[j] * x1 + slope[m] * x2) / area


@wp.kernel
def find_sampled(
    points: wp.array(dtype=wp.vec3d),
    positions: wp.array(dtype=wp.vec3d),
    corners: wp.array(dtype=wp.vec3i),
    grid: Grid,
    sampled: wp.array(dtype=wp.bool),
):
    """Whether a triangle turns its upper side to the eye, and the middle of a row of the grid lies in its rows."""
    k = wp.tid()
    a = positions[corners[k][0]]
    normal = across(positions[corners[k][1]] - a, positions[corners[k][2]] - a)
    bounds = rows_reached(points[corners[k][0]], points[corners[k][1]], points[corners[k][2]])
    half = wp.float64(0.5)
    rounding = wp.float64(1.0e-6)
    last = wp.float64(grid.height - 1)
    first = wp.max((bounds[0] - grid.origin[1]) / grid.pitch[1] - half - rounding, wp.float64(0.0))
    stop = wp.min((bounds[1] - grid.origin[1]) / grid.pitch[1] - half + rounding, last)
    faces = normal[0] * a[0] + normal[1] * a[1] + normal[2] * a[2] < wp.float64(0.0)
    sampled[k] = faces and wp.ceil(first) <= wp.floor(stop)
