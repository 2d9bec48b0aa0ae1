"""Pixel filters wider than a box: each pixel a weighted mean of the samples around it.

Gaussian of sigma 1/2 px, less its value at the radius of 3/2 px, and Mitchell & Netravali 1988 (Reconstruction Filters
in Computer Graphics, B = C = 1/3) of radius 2 px, both separable. Beside edges Mitchell's negative lobes may give small
negative radiance, and alpha up to 2% above 1.
"""

import warp as wp

from metrics.kernels.making import made_once
from swimlab.render.kernels.raster import sample_position
from swimlab.render.kernels.structs import Grid

wp.set_module_options({"enable_backward": False})


@wp.func
def gaussian(x: wp.float32) -> wp.float32:
    """Weight at x px from the pixel's centre: exp(-2 x^2) less its value at 3/2."""
    return wp.max(wp.exp(-2.0 * x * x) - 0.011108997, 0.0)


@wp.func
def mitchell(x: wp.float32) -> wp.float32:
    """Weight at x px from the pixel's centre; negative from 1 to 2 px."""
    a = wp.abs(x)
    if a < 1.0:
        return (7.0 * a * a * a - 12.0 * a * a + 16.0 / 3.0) / 6.0
    if a < 2.0:
        return ((-7.0 / 3.0) * a * a * a + 12.0 * a * a - 20.0 * a + 32.0 / 3.0) / 6.0
    return 0.0


FILTERS = {"gaussian": (gaussian, 2), "mitchell": (mitchell, 2)}
"""Name -> the weight along one axis, and how many pixels around a pixel it reaches."""


@made_once
def gather_with(weight: wp.Function, reach: int) -> wp.Kernel:
    """The kernel that filters shaded samples [rows + 2 reach, width + 2 reach] pixels of n x n into rows of pixels."""

    @wp.kernel(module="unique", enable_backward=False)
    def gather(
        first_row: wp.int32,
        n: wp.int32,
        grid: Grid,
        cells: wp.array2d(dtype=wp.vec4),
        picture: wp.array2d(dtype=wp.vec4),
        error: wp.array2d(dtype=wp.vec4),
    ):
        row, i = wp.tid()
        half = wp.float64(n) * wp.float64(0.5)
        sums = wp.vec4(0.0, 0.0, 0.0, 0.0)
        odd_sums = wp.vec4(0.0, 0.0, 0.0, 0.0)
        total = wp.float32(0.0)
        odd_total = wp.float32(0.0)
        centre_x = wp.float64((i + reach) * n) + half
        centre_y = wp.float64((first_row + row + reach) * n) + half
        for y in range(row * n, (row + 2 * reach + 1) * n):
            for x in range(i * n, (i + 2 * reach + 1) * n):
                p = sample_position(grid, x, first_row * n + y)
                away_x = ((p[0] - grid.origin[0]) / grid.pitch[0] - centre_x) / wp.float64(n)
                away_y = ((p[1] - grid.origin[1]) / grid.pitch[1] - centre_y) / wp.float64(n)
                w = weight(wp.float32(away_x)) * weight(wp.float32(away_y))
                value = cells[y, x]
                sums += value * w
                total += w
                if (x + y) & 1 == 1:
                    odd_sums += value * w
                    odd_total += w
        picture[first_row + row, i] = sums / total
        error[first_row + row, i] = ((sums - odd_sums) / (total - odd_total) - odd_sums / odd_total) * 0.5

    return gather
