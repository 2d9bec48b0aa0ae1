"""How much of a picture's history is believed: what lies within the range of the new pixels nearby.

Karis 2014, High Quality Temporal Supersampling; Salvi 2016, An Excursion in Temporal Supersampling.
"""

from typing import NamedTuple

import warp as wp

from metrics.kernels.forms import Form, Twins, form
from swimlab.render.kernels.history import PIXELS, pixel

wp.set_module_options({"enable_backward": False})


@wp.func
def to_ycocg(c: wp.vec4) -> wp.vec4:
    """RGBA as Y, Co, Cg, A: brightness varies most, and gets an axis of its own (Karis 2014)."""
    return wp.vec4(
        0.25 * c[0] + 0.5 * c[1] + 0.25 * c[2], 0.5 * c[0] - 0.5 * c[2], 0.5 * c[1] - 0.25 * c[0] - 0.25 * c[2], c[3]
    )


@wp.func
def from_ycocg(c: wp.vec4) -> wp.vec4:
    """The inverse of `to_ycocg`."""
    return wp.vec4(c[0] - c[2] + c[1], c[0] + c[2], c[0] - c[2] - c[1], c[3])


YCOCG = """
    auto to_ycocg = [](vec c) {
        const vec a = {0.5f, 0.5f, 0.5f, 1.0f}, b = {0.25f, -0.5f, -0.25f, 0.0f}, d = {0.25f, 0.0f, -0.25f, 0.0f};
        return c.yxyw*a + c.xzxw*b + c.zzzz*d;
    };
"""
"""C++ of RGBA as Y, Co, Cg, A."""


@wp.func
def box_range(fresh: wp.array2d(dtype=wp.vec4), j: wp.int32, row: wp.int32, ranges: wp.array2d(dtype=wp.vec4)):
    """The range of the new frame's 3 x 3 pixels about each pixel of row j. Karis 2014."""
    for i in range(fresh.shape[1]):
        least = to_ycocg(fresh[j, i])
        most = least
        for y in range(j - 1, j + 2):
            for x in range(i - 1, i + 2):
                value = to_ycocg(pixel(fresh, x, y))
                least = wp.min(least, value)
                most = wp.max(most, value)
        ranges[2 * row, i] = least
        ranges[2 * row + 1, i] = most


RANGES = """
    vec* lows = (vec*)((char*)ranges.data + (long)(2*row)*ranges.strides[0]);
    vec* highs = (vec*)((char*)ranges.data + (long)(2*row + 1)*ranges.strides[0]);
    const vec *rows[3] = {line(j - 1), line(j), line(j + 1)};
    // Four pixels side by side, and the conversion of `to_ycocg` for them.
    typedef float four __attribute__((ext_vector_type(16), aligned(4)));
    auto four_to_ycocg = [](four c) {
        const four a = {0.5f, 0.5f, 0.5f, 1.0f, 0.5f, 0.5f, 0.5f, 1.0f, 0.5f, 0.5f, 0.5f, 1.0f, 0.5f, 0.5f, 0.5f, 1.0f};
        const four b = {0.25f, -0.5f, -0.25f, 0.0f, 0.25f, -0.5f, -0.25f, 0.0f,
                        0.25f, -0.5f, -0.25f, 0.0f, 0.25f, -0.5f, -0.25f, 0.0f};
        const four d = {0.25f, 0.0f, -0.25f, 0.0f, 0.25f, 0.0f, -0.25f, 0.0f,
                        0.25f, 0.0f, -0.25f, 0.0f, 0.25f, 0.0f, -0.25f, 0.0f};
        return __builtin_shufflevector(c, c, 1, 0, 1, 3, 5, 4, 5, 7, 9, 8, 9, 11, 13, 12, 13, 15)*a
            + __builtin_shufflevector(c, c, 0, 2, 0, 3, 4, 6, 4, 7, 8, 10, 8, 11, 12, 14, 12, 15)*b
            + __builtin_shufflevector(c, c, 2, 2, 2, 2, 6, 6, 6, 6, 10, 10, 10, 10, 14, 14, 14, 14)*d;
    };
"""
"""C++ of what both ranges work with: rows of the picture and of the range."""

BOX_RANGE = """
    // Each column's range over three rows first, and then that of three columns.
    int i = 0;
    for (; i + 3 <= right; i += 4) {
        const four a = four_to_ycocg(*(const four*)(rows[0] + i)), b = four_to_ycocg(*(const four*)(rows[1] + i));
        const four c = four_to_ycocg(*(const four*)(rows[2] + i)), less = a < b ? a : b, more = a > b ? a : b;
        *(four*)(lows + i) = c < less ? c : less;
        *(four*)(highs + i) = c > more ? c : more;
    }
    for (; i <= right; ++i) {
        const vec a = to_ycocg(rows[0][i]), b = to_ycocg(rows[1][i]), c = to_ycocg(rows[2][i]);
        const vec less = a < b ? a : b, more = a > b ? a : b;
        lows[i] = c < less ? c : less;
        highs[i] = c > more ? c : more;
    }
    vec low_left = lows[0], low_here = lows[0], high_left = highs[0], high_here = highs[0];
    for (int k = 0; k <= right; ++k) {
        const vec low_right = lows[column(k + 1)], high_right = highs[column(k + 1)];
        const vec less = low_left < low_right ? low_left : low_right;
        const vec more = high_left > high_right ? high_left : high_right;
        lows[k] = less < low_here ? less : low_here;
        highs[k] = more > high_here ? more : high_here;
        low_left = low_here; low_here = low_right; high_left = high_here; high_here = high_right;
    }
"""


@form()
def box() -> Twins:
    """`box_range`."""
    return Twins(box_range, PIXELS.replace("IMAGE", "fresh") + YCOCG + RANGES + BOX_RANGE)


@wp.func
def variance_range(fresh: wp.array2d(dtype=wp.vec4), j: wp.int32, row: wp.int32, ranges: wp.array2d(dtype=wp.vec4)):
    """One standard deviation about the mean of the new frame's 3 x 3 pixels about each pixel of row j. Salvi 2016."""
    for i in range(fresh.shape[1]):
        mean = wp.vec4(0.0, 0.0, 0.0, 0.0)
        for y in range(j - 1, j + 2):
            for x in range(i - 1, i + 2):
                mean += to_ycocg(pixel(fresh, x, y)) / 9.0
        variance = wp.vec4(0.0, 0.0, 0.0, 0.0)
        for y in range(j - 1, j + 2):
            for x in range(i - 1, i + 2):
                away = to_ycocg(pixel(fresh, x, y)) - mean
                variance += wp.cw_mul(away, away) / 9.0
        spread = wp.vec4(wp.sqrt(variance[0]), wp.sqrt(variance[1]), wp.sqrt(variance[2]), wp.sqrt(variance[3]))
        ranges[2 * row, i] = mean - spread
        ranges[2 * row + 1, i] = mean + spread


VARIANCE_RANGE = """
    // Of one pixel or of four; the values lie as their type wants them, unlike those in the picture.
    typedef float one_aligned __attribute__((ext_vector_type(4)));
    typedef float four_aligned __attribute__((ext_vector_type(16)));
    auto mean_of = [](const auto* around) {
        auto mean = around[0]/9.0f;
        for (int k = 1; k < 9; ++k) mean += around[k]/9.0f;
        return mean;
    };
    auto spread_of = [](const auto* around, auto mean) {
        auto square = (around[0] - mean)*(around[0] - mean)/9.0f;
        for (int k = 1; k < 9; ++k) square += (around[k] - mean)*(around[k] - mean)/9.0f;
        for (unsigned k = 0; k < sizeof(square)/sizeof(float); ++k) square[k] = __builtin_sqrtf(square[k]);
        return square;
    };
    for (int i = 0; i <= right;) {
        if (i > 0 && i + 4 <= right) {
            four_aligned around[9];
            for (int k = 0; k < 9; ++k) around[k] = four_to_ycocg(*(const four*)(rows[k/3] + i - 1 + k%3));
            const four_aligned mean = mean_of(around), spread = spread_of(around, mean);
            *(four*)(lows + i) = mean - spread;
            *(four*)(highs + i) = mean + spread;
            i += 4;
        } else {
            one_aligned around[9];
            for (int k = 0; k < 9; ++k) around[k] = to_ycocg(rows[k/3][column(i - 1 + k%3)]);
            const one_aligned mean = mean_of(around), spread = spread_of(around, mean);
            lows[i] = mean - spread;
            highs[i] = mean + spread;
            ++i;
        }
    }
"""


@form()
def variance() -> Twins:
    """`variance_range`."""
    return Twins(variance_range, PIXELS.replace("IMAGE", "fresh") + YCOCG + RANGES + VARIANCE_RANGE)


@wp.func
def no_range(fresh: wp.array2d(dtype=wp.vec4), j: wp.int32, row: wp.int32, ranges: wp.array2d(dtype=wp.vec4)):
    """Nothing: the history is believed as it is."""


@form()
def none() -> Twins:
    """`no_range`."""
    return Twins(no_range, "")


@wp.func
def clamped(history: wp.vec4, least: wp.vec4, most: wp.vec4) -> wp.vec4:
    """The history within a range in YCoCg and alpha."""
    return from_ycocg(wp.max(least, wp.min(most, to_ycocg(history))))


@form()
def clamping() -> Twins:
    """`clamped`."""
    native = """
    typedef float vec __attribute__((ext_vector_type(4), aligned(4)));
    const vec low = *(const vec*)least.c, high = *(const vec*)most.c;
    vec held = to_ycocg(*(const vec*)history.c);
    held = held < high ? held : high;
    held = held > low ? held : low;
    wp::vec_t<4, float> r;
    *(vec*)r.c = vec{held.x - held.z + held.y, held.x + held.z, held.x - held.z - held.y, held.w};
    return r;
"""
    return Twins(clamped, native.replace("    const vec low", YCOCG + "    const vec low", 1))


@wp.func
def unclamped(history: wp.vec4, least: wp.vec4, most: wp.vec4) -> wp.vec4:
    """The history unchanged."""
    return history


@form()
def believing() -> Twins:
    """`unclamped`."""
    return Twins(unclamped, "return history;")


class Clamp(NamedTuple):
    """What of the history is believed: its range at each pixel of a row, in YCoCg and alpha, and what keeps it there.

    `ranges` holds the least values of row r in row 2 r, and the greatest in the row below.
    """

    find: Form
    hold: Form


CLAMPS: dict[str, Clamp] = {
    "box": Clamp(box(), clamping()),
    "variance": Clamp(variance(), clamping()),
    "none": Clamp(none(), believing()),
}
