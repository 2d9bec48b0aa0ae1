"""Squared errors counted and summed by their size."""

import warp as wp

wp.set_module_options({"enable_backward": False})

SIZES = 1024
"""Squared errors are sorted by the upper bits of their float32: the exponent, and quarters of it."""

ROWS = 32
"""Rows of pixels that a thread takes."""

_SHIFT = wp.constant(wp.uint32(21))


@wp.kernel
def sort_by_size(
    first: wp.int32,
    error: wp.array3d(dtype=wp.float32),
    covered: wp.array2d(dtype=wp.uint8),
    reached: wp.array2d(dtype=wp.uint8),
    pixels: wp.array3d(dtype=wp.float64),
    sums: wp.array3d(dtype=wp.float64),
):
    """pixels, sums: of each ROWS rows, [groups, 3, SIZES], pixels that tiles reach, other covered ones, and the rest.

    error: [3, H, W], whose square is the mean over channels.
    """
    start = first + wp.static(ROWS) * wp.tid()
    group = start / wp.static(ROWS)
    for row in range(start, wp.min(start + wp.static(ROWS), covered.shape[0])):
        for column in range(covered.shape[1]):
            off = wp.vec3(error[0, row, column], error[1, row, column], error[2, row, column])
            squared = wp.dot(off, off) / 3.0
            kind = wp.int32(2)
            if reached[row, column] != wp.uint8(0):
                kind = 0
            elif covered[row, column] != wp.uint8(0):
                kind = 1
            size = wp.int32(wp.cast(squared, wp.uint32) >> _SHIFT)
            pixels[group, kind, size] += wp.float64(1.0)
            sums[group, kind, size] += wp.float64(squared)
