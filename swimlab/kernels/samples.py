"""Shading the samples of pixels: what pixel shading, supersampling and the reference have in common."""

import functools

import warp as wp

from swimlab.kernels.footprint import surface_at
from swimlab.kernels.raster import sample_position
from swimlab.kernels.shading import shade_with
from swimlab.kernels.structs import Chain, Grid, Planes, Sun, Texel


@functools.cache
def shade_samples(texture_filter: wp.Function, brdf: wp.Function) -> wp.Kernel:
    """The kernel that filters and shades every sample of each pixel and averages them.

    `texture_filter(texels, chain, surface) -> Texel` is what sets one technique apart from another. A pixel is n x n
    cells of the grid; misses count as 0, so that RGB is premultiplied by alpha. `error`, where it is not empty,
    receives half the difference between the means over the two colours of the cells' checkerboard.
    """
    shade = shade_with(brdf)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first_row: wp.int32,
        n: wp.int32,
        grid: Grid,
        visible: wp.array2d(dtype=wp.int32),
        planes: wp.array(dtype=Planes),
        texels: wp.array(dtype=Texel),
        chain: Chain,
        sun: Sun,
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
    ):
        row, i = wp.tid()
        even = wp.vec4(0.0, 0.0, 0.0, 0.0)
        odd = wp.vec4(0.0, 0.0, 0.0, 0.0)
        for y in range(n):
            for x in range(n):
                triangle = visible[row * n + y, i * n + x]
                if triangle >= 0:
                    p = sample_position(grid, i * n + x, (first_row + row) * n + y)
                    surface = surface_at(planes[triangle], grid, p)
                    colour = shade(texture_filter(texels, chain, surface), surface, sun)
                    value = wp.vec4(colour[0], colour[1], colour[2], 1.0)
                    if (x + y) % 2 == 0:
                        even += value
                    else:
                        odd += value
        total = wp.float32(n * n)
        picture[first_row + row, i] = (even + odd) / total
        if error.shape[0] > 0:
            half = wp.float32((n * n) // 2)
            error[first_row + row, i] = (even / (total - half) - odd / half) * 0.5

    return kernel
