"""Where surfaces end: where they can be followed, and where their motion bends.

A thread takes a row of pixels: to find its pixel would cost one that takes a pixel more than its work.
"""

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.lanes import VECTORS
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})


@wp.func
def slope(
    away: wp.array2d(dtype=wp.vec2), line: wp.int32, column: wp.int32, down: wp.int32, right: wp.int32
) -> wp.vec2:
    """How a place changes for each px down, or right: a difference of both neighbours, of one at an edge."""
    before_line = wp.max(line - down, 0)
    before_column = wp.max(column - right, 0)
    after_line = wp.min(line + down, away.shape[0] - 1)
    after_column = wp.min(column + right, away.shape[1] - 1)
    steps = wp.float32(after_line - before_line + after_column - before_column)
    change = away[after_line, after_column] - away[before_line, before_column]
    return change / wp.max(steps, 1.0) + wp.vec2(wp.float32(right), wp.float32(down))


@wp.func
def lands(
    inner: wp.array2d(dtype=wp.uint8),
    top: wp.int32,
    away: wp.array2d(dtype=wp.vec2),
    shortest: wp.float32,
    line: wp.int32,
    column: wp.int32,
) -> wp.bool:
    """Whether the place is an inner pixel, and a step of 1 px there is nowhere shorter than `shortest` px."""
    x = column + wp.int32(wp.rint(away[line, column][0]))
    y = top + line + wp.int32(wp.rint(away[line, column][1]))
    if x < 0 or y < 0 or x >= inner.shape[1] or y >= inner.shape[0]:
        return False
    across = slope(away, line, column, 0, 1)
    along = slope(away, line, column, 1, 0)
    # The smaller singular value of the map's Jacobian.
    sum = wp.dot(across, across) + wp.dot(along, along)
    area = across[0] * along[1] - across[1] * along[0]
    least = sum / 2.0 - wp.sqrt(wp.max(sum * sum / 4.0 - area * area, 0.0))
    return inner[y, x] != wp.uint8(0) and least > shortest * shortest


_LAND = """
    const int width = away.shape[1], last = away.shape[0] - 1;
    unsigned char* const kept = (unsigned char*)usable.data + (long)line*width;
    const auto row = [&](int which) { return (const float*)away.data + 2*(long)which*width; };
    const float* const here = row(line);
    const int above = line > 0 ? line - 1 : 0, below = line < last ? line + 1 : last;
    const float down_steps = below > above ? (float)(below - above) : 1.0f;
    for (int column = 0; column < width; column += L) {
        const int n = width - column < L ? width - column : L;
        bool some = false;
        for (int k = 0; k < n; ++k) some |= kept[column + k] != 0;
        if (!some) continue;
        lanes left_x, left_y, right_x, right_y, up_x, up_y, down_x, down_y, steps = 2.0f;
        if (column > 0 && column + L < width) {
            split(here + 2*(column - 1), L, left_x, left_y);
            split(here + 2*(column + 1), L, right_x, right_y);
        } else for (int k = 0; k < L; ++k) {
            const int c = column + (k < n ? k : n - 1), before = c > 0 ? c - 1 : 0, after = c < width - 1 ? c + 1 : c;
            left_x[k] = here[2*before];
            left_y[k] = here[2*before + 1];
            right_x[k] = here[2*after];
            right_y[k] = here[2*after + 1];
            steps[k] = after > before ? (float)(after - before) : 1.0f;
        }
        split(row(above) + 2*column, n, up_x, up_y);
        split(row(below) + 2*column, n, down_x, down_y);
        const lanes across_x = (right_x - left_x)/steps + 1.0f, across_y = (right_y - left_y)/steps;
        const lanes along_x = (down_x - up_x)/down_steps, along_y = (down_y - up_y)/down_steps + 1.0f;
        const lanes sum = (across_x*across_x + across_y*across_y) + (along_x*along_x + along_y*along_y);
        const lanes area = across_x*along_y - across_y*along_x, apart = sum*sum/4.0f - area*area;
        const lanes least = sum/2.0f - __builtin_elementwise_sqrt(__builtin_elementwise_max(apart, (lanes)0.0f));
        for (int k = 0; k < n; ++k) {
            if (!kept[column + k]) continue;
            const int x = column + k + (int)__builtin_rintf(here[2*(column + k)]);
            const int y = top + line + (int)__builtin_rintf(here[2*(column + k) + 1]);
            const bool within = x >= 0 && y >= 0 && x < inner.shape[1] && y < inner.shape[0];
            if (!within || !((const unsigned char*)inner.data)[(long)y*inner.shape[1] + x]
                || !(least[k] > shortest*shortest)) kept[column + k] = 0;
        }
    }
"""


@form()
def row_landing() -> Twins:
    """The function that leaves usable of a row only what `lands`."""

    @wp.func(module="unique")
    def land(
        line: wp.int32,
        inner: wp.array2d(dtype=wp.uint8),
        top: wp.int32,
        away: wp.array2d(dtype=wp.vec2),
        shortest: wp.float32,
        usable: wp.array2d(dtype=wp.uint8),
    ):
        for column in range(away.shape[1]):
            if usable[line, column] != wp.uint8(0) and not lands(inner, top, away, shortest, line, column):
                usable[line, column] = wp.uint8(0)

    return Twins(land, VECTORS + _LAND)


@made_once
def land_rows(device: str) -> wp.Kernel:
    """The kernel that runs `row_landing`, a row a thread."""
    land = row_landing().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        inner: wp.array2d(dtype=wp.uint8),
        top: wp.int32,
        away: wp.array2d(dtype=wp.vec2),
        shortest: wp.float32,
        usable: wp.array2d(dtype=wp.uint8),
    ):
        land(first + wp.tid(), inner, top, away, shortest, usable)

    return kernel


@wp.func
def bends(
    motion: wp.array2d(dtype=wp.vec2),
    bend: wp.float32,
    whole: wp.array2d(dtype=wp.uint8),
    row: wp.int32,
    column: wp.int32,
    down: wp.int32,
    right: wp.int32,
) -> wp.bool:
    """Whether the second difference down, or to the right, over wholly covered pixels is above `bend` px."""
    if row < down or column < right or row + down >= motion.shape[0] or column + right >= motion.shape[1]:
        return False
    if whole[row - down, column - right] == wp.uint8(0) or whole[row + down, column + right] == wp.uint8(0):
        return False
    bent = motion[row - down, column - right] - 2.0 * motion[row, column] + motion[row + down, column + right]
    return wp.abs(bent[0]) > bend or wp.abs(bent[1]) > bend


_SMOOTH = """
    const int height = motion.shape[0], width = motion.shape[1];
    const long here = (long)row*width;
    const float* const moved = (const float*)motion.data + 2*here;
    const unsigned char* const covered = (const unsigned char*)whole.data + here;
    unsigned char* const to = (unsigned char*)smooth.data + here;
    const auto bent = [&](int column, int step) {
        const float* const at = moved + 2*column;
        const float x = at[-2*step] - 2.0f*at[0] + at[2*step], y = at[1 - 2*step] - 2.0f*at[1] + at[1 + 2*step];
        const bool both = covered[column - step] != 0 && covered[column + step] != 0;
        return both & (__builtin_fabsf(x) > bend || __builtin_fabsf(y) > bend);
    };
    const bool inside = row > 0 && row < height - 1;
    for (int column = 0; column < width; ++column) {
        bool edge = inside && bent(column, width);
        edge |= column > 0 && column < width - 1 && bent(column, 1);
        to[column] = edge ? 0 : covered[column];
    }
"""


@form()
def row_smoothness() -> Twins:
    """The function that finds the wholly covered pixels of a row at which the motion has no edge."""

    @wp.func(module="unique")
    def mark(
        row: wp.int32,
        motion: wp.array2d(dtype=wp.vec2),
        bend: wp.float32,
        whole: wp.array2d(dtype=wp.uint8),
        smooth: wp.array2d(dtype=wp.uint8),
    ):
        for column in range(motion.shape[1]):
            smooth[row, column] = whole[row, column]
            if bends(motion, bend, whole, row, column, 1, 0) or bends(motion, bend, whole, row, column, 0, 1):
                smooth[row, column] = wp.uint8(0)

    return Twins(mark, _SMOOTH)


@made_once
def find_smooth(device: str) -> wp.Kernel:
    """The kernel that runs `row_smoothness`, a row a thread."""
    mark = row_smoothness().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        motion: wp.array2d(dtype=wp.vec2),
        bend: wp.float32,
        whole: wp.array2d(dtype=wp.uint8),
        smooth: wp.array2d(dtype=wp.uint8),
    ):
        mark(first + wp.tid(), motion, bend, whole, smooth)

    return kernel
