"""Packets: samples gathered side by side, so that one reflectance model is evaluated over many of them at once.

A packet is a run of up to LANES cells in one row of a grid that see one triangle, in two local arrays. `places`, rows
of LANES doubles: u, v, du/dx, dv/dx, du/dy, dv/dy, by cell. `lanes`, rows of LANES floats: the texel's values (8, or as
many as its kind has), then position (m, relative to the eye) and slope. Shading leaves radiance in the first three rows
of `lanes`.
"""

from typing import Any

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.footprint import surface_at
from swimlab.render.kernels.raster import sample_position
from swimlab.render.kernels.shading import shade_with
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Grid, Planes, Sun, Surface

PLACES = 6 * LANES
"""Doubles that `places` has."""

wp.set_module_options({"enable_backward": False})

WIDTHS = [(width,) for width in TEXELS]


def rows_of(width: int) -> int:
    """Values of a sample whose texel has `width` floats."""
    return width + 4


@wp.func
def packet_end(visible: wp.array2d(dtype=wp.int32), row: wp.int32, x: wp.int32, width: wp.int32) -> wp.int32:
    """One past the last cell of the packet that begins at x: a run of cells that see the same triangle."""
    stop = wp.int32(x + 1)
    last = wp.min(x + LANES, width)
    while stop < last and visible[row, stop] == visible[row, x]:
        stop += 1
    return stop


@form(cases=WIDTHS)
def put_in(width: int) -> Twins:
    """The function that stores a texel of `width` floats in a lane; the plain form's indexed stores are slow."""
    texel_type = TEXELS[width]

    @wp.func(module="unique")
    def put(lanes: wp.array(dtype=wp.float32), lane: wp.int32, texel: texel_type):
        for row in range(wp.static(width)):
            lanes[LANES * row + lane] = texel[row]

    return Twins(put, f"for (int row = 0; row < {width}; ++row) lanes.data[{LANES}*row + lane] = texel.c[row];", width)


@form(cases=WIDTHS)
def take_from(width: int) -> Twins:
    """The function that reads a texel of `width` floats from a lane."""
    texel_type = TEXELS[width]

    @wp.func(module="unique")
    def take(lanes: wp.array(dtype=wp.float32), lane: wp.int32) -> texel_type:
        texel = texel_type()
        for row in range(wp.static(width)):
            texel[row] = lanes[LANES * row + lane]
        return texel

    snippet = f"""
    wp::vec_t<{width}, float> texel;
    for (int row = 0; row < {width}; ++row) texel.c[row] = lanes.data[{LANES}*row + lane];
    return texel;
"""
    return Twins(take, snippet, width)


@form(cases=WIDTHS)
def locate_before(width: int) -> Twins:
    """The function that locates `count` cells from `first` on, behind texels of `width` floats.

    The native form is `surface_at` of each cell, operation by operation.
    """

    @wp.func(module="unique")
    def locate(
        planes: Planes,
        grid: Grid,
        first: wp.int32,
        row: wp.int32,
        count: wp.int32,
        places: wp.array(dtype=wp.float64),
        lanes: wp.array(dtype=wp.float32),
    ):
        for k in range(count):
            surface = surface_at(planes, grid, sample_position(grid, first + k, row))
            for axis in range(2):
                places[axis * LANES + k] = surface.uv[axis]
                places[(2 + axis) * LANES + k] = surface.dx[axis]
                places[(4 + axis) * LANES + k] = surface.dy[axis]
            for axis in range(3):
                lanes[(width + axis) * LANES + k] = wp.float32(surface.position[axis])
            lanes[(width + 3) * LANES + k] = surface.slope

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
    return Twins(locate, snippet, width)


@wp.func
def footprint_of(places: wp.array(dtype=wp.float64), lane: wp.int32) -> Surface:
    """Texture coordinates of a lane, and their derivatives."""
    surface = Surface()
    surface.uv = wp.vec2d(places[lane], places[LANES + lane])
    surface.dx = wp.vec2d(places[2 * LANES + lane], places[3 * LANES + lane])
    surface.dy = wp.vec2d(places[4 * LANES + lane], places[5 * LANES + lane])
    return surface


@made_once
def each_lane(texture_filter: wp.Function, width: int, shape: Any = Chain) -> wp.Function:
    """The filling of a packet with filtered texels lane by lane: the plain form of every filter.

    `texture_filter(texels, chain, surface) -> texel`, of `width` floats. shape: the kind of the chain.
    """
    texel_type = TEXELS[width]
    put = put_in(width).native

    @wp.func(module="unique")
    def fill(
        texels: wp.array(dtype=texel_type),
        chain: shape,
        places: wp.array(dtype=wp.float64),
        count: wp.int32,
        lanes: wp.array(dtype=wp.float32),
    ):
        for lane in range(count):
            put(lanes, lane, texture_filter(texels, chain, footprint_of(places, lane)))

    return fill


@made_once
def each_resolved(resolve: wp.Function, width: int) -> wp.Function:
    """The application of `resolve(texel, chain)` lane by lane: the plain form of every one."""
    take, put = take_from(width).native, put_in(width).native

    @wp.func(module="unique")
    def resolve_lanes(lanes: wp.array(dtype=wp.float32), chain: Chain, count: wp.int32):
        for lane in range(count):
            put(lanes, lane, resolve(take(lanes, lane), chain))

    return resolve_lanes


@made_once
def resolved(fill: wp.Function, resolve_lanes: wp.Function, width: int) -> wp.Function:
    """The filling of a packet, followed by `resolve_lanes(lanes, chain, count)`."""
    texel_type = TEXELS[width]

    @wp.func(module="unique")
    def fill_and_resolve(
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        places: wp.array(dtype=wp.float64),
        count: wp.int32,
        lanes: wp.array(dtype=wp.float32),
    ):
        fill(texels, chain, places, count, lanes)
        resolve_lanes(lanes, chain, count)

    return fill_and_resolve


@made_once
def plain_packet(reflect: wp.Function, width: int) -> wp.Function:
    """The shading of a packet lane by lane: the plain form of every reflectance model.

    `reflect(texel, light, view, diffuse)` works in the road's tangent frame on texels of `width` floats.
    """
    shade, take = shade_with(reflect, width), take_from(width).native

    @wp.func(module="unique")
    def shade_packet(lanes: wp.array(dtype=wp.float32), sun: Sun):
        for lane in range(LANES):
            surface = Surface()
            surface.position = wp.vec3d(
                wp.float64(lanes[width * LANES + lane]),
                wp.float64(lanes[(width + 1) * LANES + lane]),
                wp.float64(lanes[(width + 2) * LANES + lane]),
            )
            surface.slope = lanes[(width + 3) * LANES + lane]
            colour = shade(take(lanes, lane), surface, sun)
            for row in range(3):
                lanes[row * LANES + lane] = colour[row]

    return shade_packet


@wp.func
def radiance(lanes: wp.array(dtype=wp.float32), lane: wp.int32) -> wp.vec3:
    """The radiance that shading left in a lane."""
    return wp.vec3(lanes[lane], lanes[LANES + lane], lanes[2 * LANES + lane])
