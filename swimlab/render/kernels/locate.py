"""Where the samples of a packet lie on the surface: a run of cells in one row of a grid that see one triangle.

Texture coordinates and their derivatives go to `places`, rows of LANES doubles: u, v, du/dx, dv/dx, du/dy, dv/dy, by
cell. Position (m, relative to the eye) and slope go to the last four rows of the packet.
"""

import functools

import warp as wp

from swimlab.render.kernels.structs import LANES, Grid, Planes, Surface

PLACES = 6 * LANES
"""Doubles that `places` has."""

wp.set_module_options({"enable_backward": False})


@functools.cache
def locate_before(width: int) -> wp.Function:
    """The function that locates a packet behind texels of `width` floats.

    Native, in a loop that a CPU compiler vectorises: `surface_at` of each cell, operation by operation, bit by bit.
    """
    snippet = f"""
    const double px = grid.pitch.c[0], py = grid.pitch.c[1], ox = grid.origin.c[0], oy = grid.origin.c[1];
    const double (*p)[3] = planes.data;
    double* __restrict q = places.data;
    float* __restrict a = lanes.data + {width * LANES};
    const bool jittered = grid.jittered == 1;
    const int seed = grid.seed, cell = row*grid.width + first;
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {{
        const wp::uint32 hashed = wp::rand_init(seed, cell + k);
        const wp::uint32 bits = wp::rand_pcg(hashed);
        const double fx = jittered ? ((double)(int)(bits & 65535u) + 0.5)*0x1p-16 : 0.5;
        const double fy = jittered ? ((double)(int)(bits >> 16) + 0.5)*0x1p-16 : 0.5;
        const double x = ox + ((double)(first + k) + fx)*px, y = oy + ((double)row + fy)*py;
        const double w = 1.0/(p[0][0]*x + p[0][1]*y + p[0][2]);
        const double u = (p[1][0]*x + p[1][1]*y + p[1][2])*w, v = (p[2][0]*x + p[2][1]*y + p[2][2])*w;
        const double across = w*px, down = w*py;
        q[k] = u;
        q[{LANES} + k] = v;
        q[{2 * LANES} + k] = (p[1][0] - u*p[0][0])*across;
        q[{3 * LANES} + k] = (p[2][0] - v*p[0][0])*across;
        q[{4 * LANES} + k] = (p[1][1] - u*p[0][1])*down;
        q[{5 * LANES} + k] = (p[2][1] - v*p[0][1])*down;
        a[k] = (float)((p[3][0]*x + p[3][1]*y + p[3][2])*w);
        a[{LANES} + k] = (float)((p[4][0]*x + p[4][1]*y + p[4][2])*w);
        a[{2 * LANES} + k] = (float)((p[5][0]*x + p[5][1]*y + p[5][2])*w);
        a[{3 * LANES} + k] = (float)((p[6][0]*x + p[6][1]*y + p[6][2])*w);
    }}
"""

    @wp.func_native(snippet)
    def locate(
        planes: Planes,
        grid: Grid,
        first: wp.int32,
        row: wp.int32,
        count: wp.int32,
        places: wp.array(dtype=wp.float64),
        lanes: wp.array(dtype=wp.float32),
    ): ...

    return locate


@wp.func
def footprint_of(places: wp.array(dtype=wp.float64), lane: wp.int32) -> Surface:
    """Texture coordinates of a lane, and their derivatives."""
    surface = Surface()
    surface.uv = wp.vec2d(places[lane], places[LANES + lane])
    surface.dx = wp.vec2d(places[2 * LANES + lane], places[3 * LANES + lane])
    surface.dy = wp.vec2d(places[4 * LANES + lane], places[5 * LANES + lane])
    return surface
