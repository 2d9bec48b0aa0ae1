"""A frame against the frame before it, pixel by pixel, from the same surface only; and sums by class of pixels."""

import warp as wp

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

COLUMNS = ("measured", "edges", "new", "squared", "edges squared", "new squared", "difference", "smooth", "energy")
"""What `sum_blocks` sums: pixels of each class, squared errors of all covered ones and of two classes, and of pairs
at edges the squared difference, and the squared value in the frame before, interpolated and not."""

columns = wp.types.vector(length=len(COLUMNS), dtype=wp.float64)


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


_PAIR = """
    const auto cubic = [](float x) {
        const float a = __builtin_fabsf(x);
        return a < 1.0f ? (1.5f*a - 2.5f)*a*a + 1.0f : a < 2.0f ? ((-0.5f*a + 2.5f)*a - 4.0f)*a + 2.0f : 0.0f;
    };
    const auto hat = [](float x) {
        const float near = 1.0f - __builtin_fabsf(x);
        return near > 0.0f ? near : 0.0f;
    };
    const int height = owner.shape[0], width = owner.shape[1];
    const long plane = (long)height*width, here = (long)row*width + column;
    const float x = (float)column - moved[0], y = (float)row - moved[1];
    const int left = (int)__builtin_floorf(x) - 1, top = (int)__builtin_floorf(y) - 1;
    float across[4], near_across[4];
    for (int tap = 0; tap < 4; ++tap) {
        across[tap] = cubic((float)(left + tap) - x);
        near_across[tap] = hat((float)(left + tap) - x);
    }
    float total = 0.0f, near = 0.0f, square = 0.0f, value[3] = {};
    for (int down = 0; down < 4; ++down) {
        const int r = top + down;
        if (r < 0 || r >= height) continue;
        const float along = cubic((float)r - y), near_along = hat((float)r - y);
        for (int right = 0; right < 4; ++right) {
            const int c = left + right;
            if (c < 0 || c >= width) continue;
            const long there = (long)r*width + c;
            const float* const owned = (const float*)owner.data + 2*there;
            const float apart_x = __builtin_fabsf(owned[0] - moved[0]), apart_y = __builtin_fabsf(owned[1] - moved[1]);
            if (!(apart_x < alike && apart_y < alike)) continue;
            const float* const from = (const float*)before.data + there;
            const float red = from[0], green = from[plane], blue = from[2*plane];
            const float weight = across[right]*along, close = near_across[right]*near_along;
            total += weight;
            value[0] += weight*red;
            value[1] += weight*green;
            value[2] += weight*blue;
            near += close;
            square += close*(red*red + green*green + blue*blue);
        }
    }
    if (!(total > 0.5f && near > 0.0f)) return wp::vec4(0.0f, 0.0f, 0.0f, 0.0f);
    float off = 0.0f, smooth = 0.0f;
    for (int channel = 0; channel < 3; ++channel) {
        const float seen = value[channel]/total, away = ((const float*)frame.data)[channel*plane + here] - seen;
        off += away*away;
        smooth += seen*seen;
    }
    return wp::vec4(1.0f, off/3.0f, smooth/3.0f, square/near/3.0f);
"""


@form(agrees=Within("native pairs against plain"))
def pair_of() -> Twins:
    """The function that compares a pixel, which moved so far since, with its surface in the frame before.

    It gives 1 if that frame shows the surface, else 0; their squared difference; the squared value there, interpolated
    and not. Squares are means over channels. The rest as for `sum_blocks`.
    """

    @wp.func(module="unique")
    def pair(
        frame: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        moved: wp.vec2,
        owner: wp.array2d(dtype=wp.vec2),
        alike: wp.float32,
        row: wp.int32,
        column: wp.int32,
    ) -> wp.vec4:
        x = wp.float32(column) - moved[0]
        y = wp.float32(row) - moved[1]
        left = wp.int32(wp.floor(x)) - 1
        top = wp.int32(wp.floor(y)) - 1
        across = wp.vec4()
        along = wp.vec4()
        near_across = wp.vec4()
        near_along = wp.vec4()
        for tap in range(4):
            across[tap] = cubic(wp.float32(left + tap) - x)
            along[tap] = cubic(wp.float32(top + tap) - y)
            near_across[tap] = hat(wp.float32(left + tap) - x)
            near_along[tap] = hat(wp.float32(top + tap) - y)
        total = wp.float32(0.0)
        near = wp.float32(0.0)
        value = wp.vec3(0.0, 0.0, 0.0)
        square = wp.float32(0.0)
        for down in range(4):
            for right in range(4):
                r = top + down
                c = left + right
                if r >= 0 and r < owner.shape[0] and c >= 0 and c < owner.shape[1]:
                    away = owner[r, c] - moved
                    if wp.abs(away[0]) < alike and wp.abs(away[1]) < alike:
                        there = wp.vec3(before[0, r, c], before[1, r, c], before[2, r, c])
                        weight = across[right] * along[down]
                        total += weight
                        value += weight * there
                        weight = near_across[right] * near_along[down]
                        near += weight
                        square += weight * wp.dot(there, there)
        if total <= 0.5 or near <= 0.0:
            return wp.vec4(0.0, 0.0, 0.0, 0.0)
        value = value / total
        off = wp.vec3(frame[0, row, column], frame[1, row, column], frame[2, row, column]) - value
        return wp.vec4(1.0, wp.dot(off, off) / 3.0, wp.dot(value, value) / 3.0, square / near / 3.0)

    return Twins(pair, _PAIR)


@made_once
def sum_blocks(device: str) -> wp.Kernel:
    """The kernel that sums the COLUMNS over each block of size x size pixels, one a thread.

    frame, before: errors [3, H, W]. paired: whether there is a frame before; the rest is looked at only then. motion:
    of the frame's pixels, px since the frame before. owner: motion of what each pixel of the frame before shows, NaN
    where it is unknown; a pixel is of the same surface if its motion is within `alike` px.
    """
    compare = pair_of().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        size: wp.int32,
        covered: wp.array2d(dtype=wp.uint8),
        reached: wp.array2d(dtype=wp.uint8),
        frame: wp.array3d(dtype=wp.float32),
        paired: wp.bool,
        before: wp.array3d(dtype=wp.float32),
        motion: wp.array2d(dtype=wp.vec2),
        owner: wp.array2d(dtype=wp.vec2),
        alike: wp.float32,
        sums: wp.array2d(dtype=columns),
    ):
        row, column = wp.tid()
        row += first
        one = wp.float64(1.0)
        found = columns()
        for y in range(row * size, wp.min((row + 1) * size, covered.shape[0])):
            for x in range(column * size, wp.min((column + 1) * size, covered.shape[1])):
                if covered[y, x] != wp.uint8(0):
                    off = wp.vec3(frame[0, y, x], frame[1, y, x], frame[2, y, x])
                    squared = wp.float64(wp.dot(off, off)) / wp.float64(3.0)
                    found[3] += squared
                    if reached[y, x] != wp.uint8(0):
                        found[0] += one
                    else:
                        pair = wp.vec4()
                        if paired:
                            pair = compare(frame, before, motion[y, x], owner, alike, y, x)
                        if pair[0] > 0.0:
                            found[1] += one
                            found[4] += squared
                            found[6] += wp.float64(pair[1])
                            found[7] += wp.float64(pair[2])
                            found[8] += wp.float64(pair[3])
                        else:
                            found[2] += one
                            found[5] += squared
        sums[row, column] = found

    return kernel


@wp.kernel
def mark_landed(
    first: wp.int32,
    reached: wp.array2d(dtype=wp.uint8),
    away: wp.array2d(dtype=wp.vec2),
    landed: wp.array2d(dtype=wp.uint8),
):
    """Mark the pixels that reached ones land on; several may write, but all the same."""
    row = first + wp.tid()
    for column in range(away.shape[1]):
        if reached[row, column] != wp.uint8(0):
            x = column + wp.int32(wp.rint(away[row, column][0]))
            y = row + wp.int32(wp.rint(away[row, column][1]))
            if x >= 0 and y >= 0 and x < landed.shape[1] and y < landed.shape[0]:
                landed[y, x] = wp.uint8(1)
