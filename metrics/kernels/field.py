"""Motion fields looked up between pixels, from planes of cubic coefficients."""

import warp as wp

from metrics.kernels.lanes import VECTORS
from metrics.kernels.splines import cubic_weights, mirrored

wp.set_module_options({"enable_backward": False})

FAR = 1e6
"""A place farther away, px, or one that is not a number, is looked up as if no farther: at an edge, and as an int."""

_FAR = wp.constant(FAR)

_LOOK = """
    const auto mirror = [](int index, int length) {
        int inside = index < 0 ? -index : index;
        inside = inside >= length ? 2*length - 2 - inside : inside;
        return inside < 0 ? 0 : inside > length - 1 ? length - 1 : inside;
    };
    const auto whole_px = [](float place) {
        return (int)(place > -%(far)gf ? place < %(far)gf ? place : %(far)gf : -%(far)gf);
    };
    struct Place { lanes x, y; };
    // A field's values away from L pixels of a row, from `column` on; 0 of those that are not asked for.
    const auto look = [&](const auto& field, int row, int column, flags asked, Place away) {
        const int height = field.shape[1], width = field.shape[2];
        const lanes left = __builtin_elementwise_floor(away.x), up = __builtin_elementwise_floor(away.y);
        const lanes tx = away.x - left, ty = away.y - up, sx = 1.0f - tx, sy = 1.0f - ty;
        const float part = 1.0f/6.0f;
        const auto outer = [&](lanes t) { return t*t*t*part; };
        const auto inner = [&](lanes t) { return (4.0f + t*t*(3.0f*t - 6.0f))*part; };
        const lanes across[] = {outer(sx), inner(tx), inner(sx), outer(tx)};
        const lanes along[] = {outer(sy), inner(ty), inner(sy), outer(ty)};
        Place found = {};
        // Pixels whose places are between the same coefficients go together: nearly always all.
        for (int lane = 0; lane < L && any(asked); ++lane) {
            if (!asked[lane]) continue;
            const flags together = asked & (left == left[lane]) & (up == up[lane]);
            asked &= ~together;
            asked[lane] = 0;
            const int c = column + whole_px(left[lane]) - 1, r = row + whole_px(up[lane]) - 1;
            const bool whole = c >= 0 && c + L + 3 <= width;
            lanes sum[2] = {};
            for (int right = 0; right < 4; ++right)
                for (int axis = 0; axis < 2; ++axis) {
                    lanes line = 0.0f;
                    for (int down = 0; down < 4; ++down) {
                        const float* const from =
                            (const float*)field.data + ((long)axis*height + mirror(r + down, height))*width;
                        lanes tap;
                        if (whole) tap = load(from + c + right);
                        else for (int k = 0; k < L; ++k) tap[k] = from[mirror(c + k + right, width)];
                        line += along[down]*tap;
                    }
                    sum[axis] = right ? sum[axis] + across[right]*line : across[right]*line;
                }
            found.x = together ? sum[0] : found.x;
            found.y = together ? sum[1] : found.y;
        }
        return found;
    };
"""
LOOK = VECTORS + _LOOK % {"far": FAR}
"""C++ for LANES pixels at a time: `look` is what `field_value` is."""


@wp.func
def field_value(field: wp.array3d(dtype=wp.float32), row: wp.int32, column: wp.int32, away: wp.vec2) -> wp.vec2:
    """The motion, px (x, y), `away` px (x, y) from a pixel, of the field with these coefficients [2, H, W]."""
    left = wp.floor(away[0])
    top = wp.floor(away[1])
    across = cubic_weights(away[0] - left)
    along = cubic_weights(away[1] - top)
    x = column + wp.int32(wp.clamp(left, -_FAR, _FAR)) - 1
    y = row + wp.int32(wp.clamp(top, -_FAR, _FAR)) - 1
    found = wp.vec2(0.0, 0.0)
    for right in range(4):
        line = wp.vec2(0.0, 0.0)
        c = mirrored(x + right, field.shape[2])
        for down in range(4):
            r = mirrored(y + down, field.shape[1])
            line += along[down] * wp.vec2(field[0, r, c], field[1, r, c])
        found += across[right] * line
    return found
