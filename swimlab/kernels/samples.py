"""Shading the samples of a grid: what pixel shading, texture-space lighting and the reference have in common."""

import functools

import warp as wp

from swimlab.kernels.footprint import surface_at
from swimlab.kernels.packet import LANES, put_in, radiance, rows_of
from swimlab.kernels.raster import sample_position
from swimlab.kernels.structs import TEXELS, Chain, Grid, Planes, Sun


@functools.cache
def shade_samples(texture_filter: wp.Function, width: int, shade_packet: wp.Function, averages: bool) -> wp.Kernel:
    """The kernel that filters, shades and averages all samples of each pixel, one thread a row of pixels.

    `texture_filter(texels, chain, surface) -> texel` is what sets one technique apart from another; texels have `width`
    floats. A pixel is n x n cells of the grid; row `first_row` of pixels is written to row `picture_row`. Misses count
    as 0, so that RGB is premultiplied by alpha. If it `averages` (n > 1), `error` receives half the difference between
    the means over the two colours of the cells' checkerboard. `shaded` receives each row's number of samples shaded.
    """
    texel_type = TEXELS[width]
    put = put_in(width)
    floats = LANES * rows_of(width)

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
        columns = grid.width / n
        lanes = wp.zeros(shape=(floats,), dtype=wp.float32)
        owner = wp.zeros(shape=(LANES,), dtype=wp.int32)
        odd = wp.zeros(shape=(LANES,), dtype=wp.int32)
        count = wp.int32(0)
        hits = wp.int32(0)
        total = wp.float32(n * n)
        half = wp.float32((n * n) / 2)
        for i in range(columns):
            picture[j, i] = wp.vec4(0.0, 0.0, 0.0, 0.0)
            if averages:
                error[j, i] = wp.vec4(0.0, 0.0, 0.0, 0.0)
        for y in range(row * n, (row + 1) * n):
            pixel = wp.int32(0)
            column = wp.int32(0)
            for x in range(grid.width):
                triangle = visible[y, x]
                if triangle >= 0:
                    surface = surface_at(planes[triangle], grid, sample_position(grid, x, first_row * n + y))
                    put(lanes, count, texture_filter(texels, chain, surface), surface)
                    owner[count] = pixel
                    odd[count] = (column + y - row * n) & 1
                    count += 1
                    hits += 1
                column += 1
                if column == n:
                    column = wp.int32(0)
                    pixel += 1
                if count == LANES or (x == grid.width - 1 and y == (row + 1) * n - 1):
                    shade_packet(lanes, sun)
                    for lane in range(count):
                        colour = radiance(lanes, lane)
                        value = wp.vec4(colour[0], colour[1], colour[2], 1.0)
                        if averages:
                            picture[j, owner[lane]] += value
                            error[j, owner[lane]] += wp.where(odd[lane] == 1, value / -half, value / (total - half))
                        else:
                            picture[j, owner[lane]] = value
                    count = wp.int32(0)
        shaded[j] = hits
        if averages:
            for i in range(columns):
                picture[j, i] = picture[j, i] / total
                error[j, i] = error[j, i] * 0.5

    return kernel
