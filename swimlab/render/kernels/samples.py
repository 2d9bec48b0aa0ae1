"""Shading the samples of a grid: the core of pixel shading, texture-space lighting and the reference."""

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.packet import PLACES, locate_before, packet_end, rows_of
from swimlab.render.kernels.raster import see_row
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Edges, Grid, Planes, Sun

GATHER = """
    char* at = (char*)picture.data + (long)j*picture.strides[0];
    char* other = (char*)error.data + (long)j*error.strides[0];
    int pixel = first/n, column = first - pixel*n;
    const float odd_share = -1.0f/(float)(n*n/2), even_share = 1.0f/(float)(n*n - n*n/2);
    if (n == 1) {
        for (int k = 0; k < count; ++k) {
            float* p = (float*)(at + (long)(pixel + k)*picture.strides[1]);
            p[0] = lanes.data[k]; p[1] = lanes.data[LANES + k]; p[2] = lanes.data[2*LANES + k]; p[3] = 1.0f;
        }
        return;
    }
    for (int k = 0; k < count; ++pixel, column = 0) {
        float* p = (float*)(at + (long)pixel*picture.strides[1]);
        float* e = (float*)(other + (long)pixel*error.strides[1]);
        float sum[4] = {p[0], p[1], p[2], p[3]}, difference[4] = {e[0], e[1], e[2], e[3]};
        for (; column < n && k < count; ++column, ++k) {
            const float r = lanes.data[k], g = lanes.data[LANES + k], b = lanes.data[2*LANES + k];
            const float share = (column + y) & 1 ? odd_share : even_share;
            sum[0] += r; sum[1] += g; sum[2] += b; sum[3] += 1.0f;
            difference[0] += r*share; difference[1] += g*share; difference[2] += b*share; difference[3] += share;
        }
        for (int c = 0; c < 4; ++c) { p[c] = sum[c]; e[c] = difference[c]; }
    }
""".replace("LANES", str(LANES))


@form()
def gathering() -> Twins:
    """The function that adds a packet's radiance to its pixels, row j of `picture`.

    With n > 1 it is added to `error` too, with the signs of the two halves of a checkerboard.
    """

    @wp.func(module="unique")
    def gather(
        lanes: wp.array(dtype=wp.float32),
        first: wp.int32,
        count: wp.int32,
        n: wp.int32,
        y: wp.int32,
        j: wp.int32,
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
    ):
        for k in range(count):
            i = (first + k) / n
            colour = wp.vec4(lanes[k], lanes[LANES + k], lanes[2 * LANES + k], 1.0)
            if n == 1:
                picture[j, i] = colour
            else:
                share = 1.0 / wp.float32(n * n - n * n / 2)
                if (first + k - i * n + y) & 1 == 1:
                    share = -1.0 / wp.float32(n * n / 2)
                picture[j, i] += colour
                error[j, i] += colour * share

    return Twins(gather, GATHER)


BLANK = """
    float* at = (float*)((char*)picture.data + (long)j*picture.strides[0]);
    for (int i = 0; i < 4*picture.shape[1]; ++i) at[i] = 0.0f;
"""


@form()
def blanking() -> Twins:
    """The function that clears row j of a picture."""

    @wp.func(module="unique")
    def blank(picture: wp.array2d(dtype=wp.vec4), j: wp.int32):
        for i in range(picture.shape[1]):
            picture[j, i] = wp.vec4(0.0, 0.0, 0.0, 0.0)

    return Twins(blank, BLANK)


@made_once
def shade_row(fill: wp.Function, shade_packet: wp.Function, width: int) -> wp.Function:
    """The function that filters, shades and averages all samples of a row of pixels; it returns their number.

    A packet is a run of cells in a row that see one triangle: they are located on it, filled with filtered texels of
    `width` floats, shaded, and gathered into pixels. Techniques differ in `fill`.
    A pixel is n x n cells of the grid; rows `row` n and on of `visible` are row `grid_row` of pixels, which is added to
    row j of the picture, 0 before. Misses count as 0, so that RGB is premultiplied by alpha. With n > 1, `error`
    receives half the difference between the means over the two colours of the cells' checkerboard.
    """
    texel_type = TEXELS[width]
    locate, gather = locate_before(width).native, gathering().native
    floats = LANES * rows_of(width)

    @wp.func(module="unique")
    def shade(
        row: wp.int32,
        grid_row: wp.int32,
        j: wp.int32,
        n: wp.int32,
        grid: Grid,
        visible: wp.array2d(dtype=wp.int32),
        planes: wp.array(dtype=Planes),
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
    ) -> wp.int32:
        lanes = wp.zeros(shape=(floats,), dtype=wp.float32)
        places = wp.zeros(shape=(PLACES,), dtype=wp.float64)
        hits = wp.int32(0)
        for y in range(n):
            x = wp.int32(0)
            while x < grid.width:
                triangle = visible[row * n + y, x]
                stop = packet_end(visible, row * n + y, x, grid.width)
                if triangle >= 0:
                    locate(planes[triangle], grid, x, grid_row * n + y, stop - x, places, lanes)
                    fill(texels, chain, places, stop - x, lanes)
                    shade_packet(lanes, sun)
                    gather(lanes, x, stop - x, n, y, j, picture, error)
                    hits += stop - x
                x = stop
        if n > 1:
            share = 1.0 / wp.float32(n * n)
            for i in range(grid.width / n):
                picture[j, i] = picture[j, i] * share
                error[j, i] = error[j, i] * 0.5
        return hits

    return shade


@made_once
def shade_samples(fill: wp.Function, shade_packet: wp.Function, width: int) -> wp.Kernel:
    """The kernel that shades rows of pixels of which it is known what they see, one thread a row (see `shade_row`).

    Row `first_row` of pixels is added to row `picture_row`. `shaded` receives each row's number of samples.
    """
    texel_type = TEXELS[width]
    shade = shade_row(fill, shade_packet, width)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first_row: wp.int32,
        picture_row: wp.int32,
        n: wp.int32,
        grid: Grid,
        visible: wp.array2d(dtype=wp.int32),
        planes: wp.array(dtype=Planes),
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
        shaded: wp.array(dtype=wp.int32),
    ):
        row = wp.tid()
        j = picture_row + row
        shaded[j] = shade(row, first_row + row, j, n, grid, visible, planes, texels, chain, sun, picture, error)

    return kernel


@made_once
def draw_row(fill: wp.Function, shade_packet: wp.Function, width: int) -> wp.Function:
    """The function that draws triangles into row j of a picture; it returns the number of samples (see `shade_row`).

    It clears the row, finds what it sees and shades that. Rows `row` n and on of `visible` are scratch.
    """
    texel_type = TEXELS[width]
    shade, blank = shade_row(fill, shade_packet, width), blanking().native

    @wp.func(module="unique")
    def draw(
        row: wp.int32,
        j: wp.int32,
        n: wp.int32,
        grid: Grid,
        edges: wp.array(dtype=Edges),
        planes: wp.array(dtype=Planes),
        bounds: wp.array(dtype=wp.vec2d),
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
        visible: wp.array2d(dtype=wp.int32),
    ) -> wp.int32:
        blank(picture, j)
        if n > 1:
            blank(error, j)
        for y in range(n):
            see_row(row * n + y, j * n + y, grid, edges, planes, bounds, visible)
        return shade(row, j, j, n, grid, visible, planes, texels, chain, sun, picture, error)

    return draw


@made_once
def draw_samples(fill: wp.Function, shade_packet: wp.Function, width: int) -> wp.Kernel:
    """The kernel that draws triangles into rows of pixels, one thread a row (see `draw_row`).

    `visible` [rows * n, grid.width] is scratch for as many rows of pixels as are worked on at once. `shaded` receives
    each row's number of samples.
    """
    texel_type = TEXELS[width]
    draw = draw_row(fill, shade_packet, width)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first_row: wp.int32,
        n: wp.int32,
        grid: Grid,
        edges: wp.array(dtype=Edges),
        planes: wp.array(dtype=Planes),
        bounds: wp.array(dtype=wp.vec2d),
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
        shaded: wp.array(dtype=wp.int32),
        visible: wp.array2d(dtype=wp.int32),
    ):
        j = first_row + wp.tid()
        row = wp.tid() % (visible.shape[0] / n)
        shaded[j] = draw(row, j, n, grid, edges, planes, bounds, texels, chain, sun, picture, error, visible)

    return kernel
