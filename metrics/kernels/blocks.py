"""Blocks of pictures under windows: cut out, and laid over one another."""

import warp as wp

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


@wp.func_native(ADD)
def add_row(
    y: wp.int32,
    begin: wp.int32,
    end: wp.int32,
    corners: wp.array2d(dtype=wp.int32),
    square: wp.array2d(dtype=wp.float64),
    total: wp.array2d(dtype=wp.float64),
):
    """Add rows of a square to row y, at corners begin ... end. All lie in one piece."""


@wp.kernel
def add_squares(
    corners: wp.array2d(dtype=wp.int32),
    ranges: wp.array2d(dtype=wp.int32),
    square: wp.array2d(dtype=wp.float64),
    total: wp.array2d(dtype=wp.float64),
):
    """Add a square [L, L] to a picture [H, W] at each of some corners (y, x), in their order; one thread a row.

    ranges: of each row the first corner whose square it crosses, and one past the last.
    """
    y = wp.tid()
    add_row(y, ranges[y, 0], ranges[y, 1], corners, square, total)
