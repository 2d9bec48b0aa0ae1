"""Pictures taken at other places: planes of quintic coefficients, looked up a row at a time."""

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.lanes import VECTORS
from metrics.kernels.making import made_once
from metrics.kernels.splines import AGREES, quintic_weights

wp.set_module_options({"enable_backward": False})

_UNWARP = """
    const int height = picture.shape[1], width = picture.shape[2], columns = seen.shape[2], channels = seen.shape[0];
    const auto within = [](int index, int most) { return index < 0 ? 0 : index > most ? most : index; };
    const auto outer = [](lanes t) { return t*t*(t*t)*t*(1.0f/120.0f); };
    const auto second = [](lanes t) {
        return (26.0f + t*(-50.0f + t*(20.0f + t*(20.0f + t*(5.0f*t - 20.0f)))))*(1.0f/120.0f);
    };
    const auto inner = [](lanes t) { return (66.0f + t*t*(-60.0f + t*t*(30.0f - 10.0f*t)))*(1.0f/120.0f); };
    for (int column = 0; column < columns; column += L) {
        const int n = columns - column < L ? columns - column : L;
        const long here = (long)line*columns + column;
        flags todo = 0;
        for (int k = 0; k < n; ++k) todo[k] = ((const unsigned char*)usable.data)[here + k] ? -1 : 0;
        lanes x, y, value[3] = {};
        split((const float*)away.data + 2*here, n, x, y);
        const lanes left = __builtin_elementwise_floor(x), up = __builtin_elementwise_floor(y);
        const lanes tx = x - left, ty = y - up, sx = 1.0f - tx, sy = 1.0f - ty;
        const lanes across[] = {outer(sx), second(tx), inner(tx), inner(sx), second(sx), outer(tx)};
        const lanes along[] = {outer(sy), second(ty), inner(ty), inner(sy), second(sy), outer(ty)};
        // Pixels whose places are between the same coefficients go together: nearly always all.
        for (int lane = 0; lane < n && any(todo); ++lane) {
            if (!todo[lane]) continue;
            const flags together = todo & (left == left[lane]) & (up == up[lane]);
            todo &= ~together;
            const int c = column + (int)left[lane] - 2, r = within(top + line + (int)up[lane] - 2, height - 6);
            const bool whole = c >= 0 && c + L + 5 <= width;
            for (int channel = 0; channel < channels; ++channel) {
                const float* from = (const float*)picture.data + ((long)channel*height + r)*width;
                lanes even = 0.0f, odd = 0.0f;
                for (int down = 0; down < 6; ++down, from += width) {
                    lanes tap[6];
                    for (int right = 0; right < 6; ++right)
                        if (whole) tap[right] = load(from + c + right);
                        else for (int k = 0; k < L; ++k) tap[right][k] = from[within(c + k, width - 6) + right];
                    even += along[down]*(across[0]*tap[0] + across[2]*tap[2] + across[4]*tap[4]);
                    odd += along[down]*(across[1]*tap[1] + across[3]*tap[3] + across[5]*tap[5]);
                }
                value[channel] = together ? even + odd : value[channel];
            }
        }
        for (int channel = 0; channel < channels; ++channel)
            __builtin_memcpy((float*)seen.data + (long)channel*seen.shape[1]*columns + here, value + channel, 4*n);
    }
"""


@form(agrees=AGREES)
def row_unwarping() -> Twins:
    """The function that takes a row of the picture with these quintic coefficients at other places.

    picture: [channels, H, W], seen: [channels, rows, W], 1 to 3 channels. Each pixel is taken `away` px (x, y) from its
    own place, 0 where it is not usable. top: the picture's row that row 0 of away, usable and seen is. What is usable
    lies 3 px and more inside a picture, which is 6 px wide and high at least.
    """

    @wp.func(module="unique")
    def unwarp(
        line: wp.int32,
        picture: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
        usable: wp.array2d(dtype=wp.uint8),
        top: wp.int32,
        seen: wp.array3d(dtype=wp.float32),
    ):
        for column in range(seen.shape[2]):
            for channel in range(seen.shape[0]):
                seen[channel, line, column] = 0.0
            if usable[line, column] != wp.uint8(0):
                place = away[line, column]
                left = wp.floor(place[0])
                up = wp.floor(place[1])
                across = quintic_weights(place[0] - left)
                along = quintic_weights(place[1] - up)
                x = wp.clamp(column + wp.int32(left) - 2, 0, picture.shape[2] - 6)
                y = wp.clamp(top + line + wp.int32(up) - 2, 0, picture.shape[1] - 6)
                for channel in range(seen.shape[0]):
                    value = wp.float32(0.0)
                    for down in range(6):
                        part = wp.float32(0.0)
                        for right in range(6):
                            part += across[right] * picture[channel, y + down, x + right]
                        value += along[down] * part
                    seen[channel, line, column] = value

    return Twins(unwarp, VECTORS + _UNWARP)


@made_once
def unwarp_rows(device: str) -> wp.Kernel:
    """The kernel that unwarps rows of a picture, one a thread."""
    unwarp = row_unwarping().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        picture: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
        usable: wp.array2d(dtype=wp.uint8),
        top: wp.int32,
        seen: wp.array3d(dtype=wp.float32),
    ):
        unwarp(first + wp.tid(), picture, away, usable, top, seen)

    return kernel
