"""Blocks of pictures under windows: cut out, and laid over one another."""

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})


@wp.kernel
def cut_blocks(
    planes: wp.array3d(dtype=wp.float32),
    corners: wp.array2d(dtype=wp.int32),
    window: wp.array2d(dtype=wp.float32),
    blocks: wp.array4d(dtype=wp.float32),
):
    """Fill blocks [n, channels, L, L] from planes [channels, H, W], times the window; one thread a row of a block.

    corners: (y, x) of each block's first pixel.
    """
    size = window.shape[0]
    row = wp.tid() % size
    channel = (wp.tid() / size) % planes.shape[0]
    n = wp.tid() / (size * planes.shape[0])
    y = corners[n, 0] + row
    x = corners[n, 1]
    for column in range(size):
        blocks[n, channel, row, column] = planes[channel, y, x + column] * window[row, column]


ADD = """
    const int size = square.shape[1];
    for (int n = begin; n < end; ++n) {
        const double* __restrict profile = square.data + (y - corners.data[2*n])*size;
        double* __restrict line = total.data + (size_t)y*total.shape[1] + corners.data[2*n + 1];
        for (int column = 0; column < size; ++column) line[column] += profile[column];
    }
"""


@form()
def adding() -> Twins:
    """The function that adds rows of a square to row y, at corners begin ... end. All lie in one piece."""

    @wp.func(module="unique")
    def add(
        y: wp.int32,
        begin: wp.int32,
        end: wp.int32,
        corners: wp.array2d(dtype=wp.int32),
        square: wp.array2d(dtype=wp.float64),
        total: wp.array2d(dtype=wp.float64),
    ):
        for n in range(begin, end):
            row = y - corners[n, 0]
            for column in range(square.shape[1]):
                x = corners[n, 1] + column
                total[y, x] = total[y, x] + square[row, column]  # += would be atomic

    return Twins(add, ADD)


@made_once
def add_squares() -> wp.Kernel:
    """The kernel that adds a square [L, L] to a picture [H, W] at each of some corners (y, x), in their order.

    One thread a row. ranges: of each row the first corner whose square it crosses, and one past the last.
    """
    add = adding().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        corners: wp.array2d(dtype=wp.int32),
        ranges: wp.array2d(dtype=wp.int32),
        square: wp.array2d(dtype=wp.float64),
        total: wp.array2d(dtype=wp.float64),
    ):
        y = wp.tid()
        add(y, ranges[y, 0], ranges[y, 1], corners, square, total)

    return kernel
