"""Reuse of the previous frame: where a surface was, and whether it was seen there."""

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.footprint import surface_at
from swimlab.render.kernels.geometry import Previous, place_before
from swimlab.render.kernels.raster import inverse_depth, sample_position, see_row
from swimlab.render.kernels.structs import Edges, Grid, Planes

wp.set_module_options({"enable_backward": False})


PROJECT = """
    const double px = grid.pitch.c[0], py = grid.pitch.c[1], ox = grid.origin.c[0], oy = grid.origin.c[1];
    const double (*p)[3] = planes.data;
    const double (*m)[3] = previous.projection.data;
    const double *o = previous.offset.c;
    float* __restrict near = (float*)((char*)nearness.data + (long)j*nearness.strides[0]) + first;
    float* __restrict at = (float*)((char*)places.data + (long)j*places.strides[0]) + 4*first;
    const float slope = (float)(__builtin_fabs(p[0][0]*px) + __builtin_fabs(p[0][1]*py));
    const double y = oy + ((double)j + 0.5)*py;
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const double x = ox + ((double)(first + k) + 0.5)*px, inverse = p[0][0]*x + p[0][1]*y + p[0][2];
        const double w = 1.0/inverse;
        const double a = (p[3][0]*x + p[3][1]*y + p[3][2])*w + o[0];
        const double b = (p[4][0]*x + p[4][1]*y + p[4][2])*w + o[1];
        const double c = (p[5][0]*x + p[5][1]*y + p[5][2])*w + o[2];
        const double depth = m[2][0]*a + m[2][1]*b + m[2][2]*c;
        near[k] = (float)inverse;
        at[4*k] = (float)(((m[0][0]*a + m[0][1]*b + m[0][2]*c)/depth - previous.origin.c[0])/previous.pitch.c[0]);
        at[4*k + 1] = (float)(((m[1][0]*a + m[1][1]*b + m[1][2]*c)/depth - previous.origin.c[1])/previous.pitch.c[1]);
        at[4*k + 2] = (float)(1.0/depth);
        at[4*k + 3] = slope;
    }
"""


@form()
def projecting() -> Twins:
    """The function that finds where the previous frame saw a plane, for `count` pixels of row j from `first` on."""

    @wp.func(module="unique")
    def project(
        planes: Planes,
        grid: Grid,
        previous: Previous,
        first: wp.int32,
        j: wp.int32,
        count: wp.int32,
        nearness: wp.array2d(dtype=wp.float32),
        places: wp.array2d(dtype=wp.vec4),
    ):
        slope = wp.abs(planes[0, 0] * grid.pitch[0]) + wp.abs(planes[0, 1] * grid.pitch[1])
        for i in range(first, first + count):
            p = sample_position(grid, i, j)
            before = place_before(previous, surface_at(planes, grid, p).position)
            nearness[j, i] = wp.float32(inverse_depth(planes, p))
            places[j, i] = wp.vec4(
                wp.float32(before[0]),
                wp.float32(before[1]),
                wp.float32(wp.float64(1.0) / before[2]),
                wp.float32(slope),
            )

    return Twins(project, PROJECT)


@made_once
def reprojecting(device: str) -> wp.Function:
    """The function that finds the surface at each pixel's centre in row j, now and in the previous frame.

    nearness: 1/w (1/m) now. places: its place x, y (px) and 1/w in the previous frame, and the slope of 1/w,
    |d/dx| + |d/dy| a pixel. Where there is none, nearness is 0 and places stay as they are. Row `row` of `visible` is
    scratch.
    """
    project = projecting().on(device)

    @wp.func(module="unique")
    def reproject(
        row: wp.int32,
        j: wp.int32,
        grid: Grid,
        edges: wp.array(dtype=Edges),
        planes: wp.array(dtype=Planes),
        bounds: wp.array(dtype=wp.vec2d),
        previous: Previous,
        nearness: wp.array2d(dtype=wp.float32),
        places: wp.array2d(dtype=wp.vec4),
        visible: wp.array2d(dtype=wp.int32),
    ):
        see_row(row, j, grid, edges, planes, bounds, visible)
        i = wp.int32(0)
        while i < grid.width:
            triangle = visible[row, i]
            stop = wp.int32(i + 1)
            while stop < grid.width and visible[row, stop] == triangle:
                stop += 1
            if triangle >= 0:
                project(planes[triangle], grid, previous, i, j, stop - i, nearness, places)
            else:
                for k in range(i, stop):
                    nearness[j, k] = 0.0
            i = stop

    return reproject


@wp.func
def inside(image: wp.array2d(dtype=wp.float32), i: wp.int32, j: wp.int32) -> wp.bool:
    """Whether a pixel lies in the picture."""
    return i >= 0 and j >= 0 and i < image.shape[1] and j < image.shape[0]


@wp.func
def surface_beside(nearness: wp.array2d(dtype=wp.float32), i: wp.int32, j: wp.int32) -> wp.vec2i:
    """The pixel that a pixel moves with: itself, or the neighbour nearest to the eye where its centre sees none.

    (-1, -1) where no neighbour sees one. So a pixel that the road's edge cuts moves with the road.
    """
    found = wp.vec2i(-1, -1)
    nearest = wp.float32(0.0)
    if nearness[j, i] > 0.0:
        return wp.vec2i(i, j)
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            if inside(nearness, x, y):
                if nearness[y, x] > nearest:
                    nearest = nearness[y, x]
                    found = wp.vec2i(x, y)
    return found


@wp.func
def was_seen(nearness: wp.array2d(dtype=wp.float32), place: wp.vec4) -> wp.bool:
    """Whether the previous frame saw this surface: one of the 3 x 3 pixels about its place has its 1/w.

    The tolerance is a tenth, and the slope of 1/w (constant over a plane) times the distance to the pixel's centre.
    """
    i = wp.int32(wp.floor(place[0]))
    j = wp.int32(wp.floor(place[1]))
    if place[2] <= 0.0 or not inside(nearness, i, j):
        return False
    apart = 0.1 * place[2] + 1.5 * place[3]
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            if inside(nearness, x, y):
                if nearness[y, x] > 0.0 and wp.abs(nearness[y, x] - place[2]) <= apart:
                    return True
    return False


PLACE = """
    typedef float vec __attribute__((ext_vector_type(4), aligned(4)));
    const int right = nearness.shape[1] - 1, low = nearness.shape[0] - 1;
    auto line = [&](int y) { return (const float*)((const char*)nearness.data + (long)y*nearness.strides[0]); };
    auto before = [&](int y) { return (const float*)((const char*)earlier.data + (long)y*earlier.strides[0]); };
    const wp::vec_t<3, float> nowhere(0.0f, 0.0f, 0.0f);
    int x = i, y = j;
    float nearest = line(j)[i];
    if (!(nearest > 0.0f)) {
        nearest = 0.0f;
        for (int v = j > 0 ? j - 1 : 0; v <= (j < low ? j + 1 : low); ++v)
            for (int u = i > 0 ? i - 1 : 0; u <= (i < right ? i + 1 : right); ++u)
                if (line(v)[u] > nearest) { nearest = line(v)[u]; x = u; y = v; }
        if (nearest == 0.0f) return nowhere;
    }
    const vec place = ((const vec*)((const char*)places.data + (long)y*places.strides[0]))[x];
    const float at = place.x + (float)(i - x), below = place.y + (float)(j - y);
    if (!(at >= 0.0f && below >= 0.0f && at <= (float)(right + 1) && below <= (float)(low + 1))) return nowhere;
    const int m = (int)__builtin_floorf(place.x), n = (int)__builtin_floorf(place.y);
    if (place.z <= 0.0f || m < 0 || n < 0 || m > right || n > low) return nowhere;
    const float apart = 0.1f*place.z + 1.5f*place.w;
    for (int v = n > 0 ? n - 1 : 0; v <= (n < low ? n + 1 : low); ++v)
        for (int u = m > 0 ? m - 1 : 0; u <= (m < right ? m + 1 : right); ++u) {
            const float was = before(v)[u];
            if (was > 0.0f && __builtin_fabsf(was - place.z) <= apart) return wp::vec_t<3, float>(at, below, 1.0f);
        }
    return nowhere;
"""


@form()
def placing() -> Twins:
    """The function that finds where the previous frame saw what pixel (i, j) shows: x, y (px) and 1; 0 where it
    did not. `earlier` is that frame's nearness."""

    @wp.func(module="unique")
    def place_before_of(
        nearness: wp.array2d(dtype=wp.float32),
        places: wp.array2d(dtype=wp.vec4),
        earlier: wp.array2d(dtype=wp.float32),
        i: wp.int32,
        j: wp.int32,
    ) -> wp.vec3:
        owner = surface_beside(nearness, i, j)
        if owner[0] >= 0:
            place = places[owner[1], owner[0]]
            x = place[0] + wp.float32(i - owner[0])
            y = place[1] + wp.float32(j - owner[1])
            width = wp.float32(nearness.shape[1])
            height = wp.float32(nearness.shape[0])
            on_screen = x >= 0.0 and y >= 0.0 and x <= width and y <= height
            if on_screen and was_seen(earlier, place):
                return wp.vec3(x, y, 1.0)
        return wp.vec3(0.0, 0.0, 0.0)

    return Twins(place_before_of, PLACE)
