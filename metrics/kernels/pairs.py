"""A frame against the frame before it, pixel by pixel, taken from the same surface only."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.func
def cubic(x: wp.float32) -> wp.float32:
    """Weight at x px of the cubic convolution kernel with a = -1/2 (Keys 1981, eq. 15)."""
    a = wp.abs(x)
    if a < 1.0:
        return (1.5 * a - 2.5) * a * a + 1.0
    if a < 2.0:
        return ((-0.5 * a + 2.5) * a - 4.0) * a + 2.0
    return 0.0


@wp.func
def hat(x: wp.float32) -> wp.float32:
    """Weight at x px of linear interpolation."""
    return wp.max(0.0, 1.0 - wp.abs(x))


@wp.kernel
def compare_pairs(
    first_row: wp.int32,
    frame: wp.array2d(dtype=wp.vec3),
    before: wp.array2d(dtype=wp.vec3),
    motion: wp.array2d(dtype=wp.vec2),
    surface: wp.array2d(dtype=wp.vec2),
    alike: wp.float32,
    found: wp.array2d(dtype=wp.vec4),
):
    """found: 1 where the frame before shows the pixel's surface, else 0; squared difference; squared value there,
    interpolated and not. Squares are means over channels.

    motion: of the frame's pixels, px since the frame before. surface: motion of what each pixel of the frame before
    shows, NaN where it is unknown; a pixel is of the same surface if its motion is within `alike` px.
    """
    row, column = wp.tid()
    i = first_row + row
    moved = motion[i, column]
    x = wp.float32(column) - moved[0]
    y = wp.float32(i) - moved[1]
    left = wp.int32(wp.floor(x)) - 1
    top = wp.int32(wp.floor(y)) - 1
    total = wp.float32(0.0)
    near = wp.float32(0.0)
    value = wp.vec3(0.0, 0.0, 0.0)
    square = wp.float32(0.0)
    for down in range(4):
        for right in range(4):
            r = top + down
            c = left + right
            if r >= 0 and r < before.shape[0] and c >= 0 and c < before.shape[1]:
                away = surface[r, c] - moved
                if wp.abs(away[0]) < alike and wp.abs(away[1]) < alike:
                    dx = wp.float32(c) - x
                    dy = wp.float32(r) - y
                    there = before[r, c]
                    weight = cubic(dx) * cubic(dy)
                    total += weight
                    value += weight * there
                    weight = hat(dx) * hat(dy)
                    near += weight
                    square += weight * wp.dot(there, there)
    if total > 0.5 and near > 0.0:
        value = value / total
        off = frame[i, column] - value
        found[i, column] = wp.vec4(1.0, wp.dot(off, off) / 3.0, wp.dot(value, value) / 3.0, square / near / 3.0)
    else:
        found[i, column] = wp.vec4(0.0, 0.0, 0.0, 0.0)
