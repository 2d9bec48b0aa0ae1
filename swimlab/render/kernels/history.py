"""The history of a picture: how it is read between pixels, and how much of it is believed."""

import warp as wp

from metrics.kernels.forms import Form, Twins, form

wp.set_module_options({"enable_backward": False})

PIXELS = """
    typedef float vec __attribute__((ext_vector_type(4), aligned(4)));
    const int right = IMAGE.shape[1] - 1, low = IMAGE.shape[0] - 1;
    auto line = [&](int y) {
        const int kept = y < 0 ? 0 : y > low ? low : y;
        return (const vec*)((const char*)IMAGE.data + (long)kept*IMAGE.strides[0]);
    };
    auto column = [&](int x) { return x < 0 ? 0 : x > right ? right : x; };
    auto result = [](vec value) { wp::vec_t<4, float> r; *(vec*)r.c = value; return r; };
"""
"""C++ by which native forms read pixels of IMAGE, as `pixel` does."""


@wp.func
def pixel(image: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32) -> wp.vec4:
    """A pixel; beyond the border, the nearest on the border."""
    return image[wp.clamp(j, 0, image.shape[0] - 1), wp.clamp(i, 0, image.shape[1] - 1)]


@wp.func
def bilinear_read(image: wp.array2d(dtype=wp.vec4), x: wp.float32, y: wp.float32) -> wp.vec4:
    """The four pixels about a place, px, weighted by nearness."""
    i = wp.int32(wp.floor(x - 0.5))
    j = wp.int32(wp.floor(y - 0.5))
    a = x - 0.5 - wp.float32(i)
    b = y - 0.5 - wp.float32(j)
    upper = pixel(image, i, j) * (1.0 - a) + pixel(image, i + 1, j) * a
    lower = pixel(image, i, j + 1) * (1.0 - a) + pixel(image, i + 1, j + 1) * a
    return upper * (1.0 - b) + lower * b


@wp.func
def catmull_rom(a: wp.float32) -> wp.vec4:
    """Weights of four neighbours for a place `a` of the way from the second to the third (Catmull & Rom 1974)."""
    return wp.vec4(
        ((-0.5 * a + 1.0) * a - 0.5) * a,
        (1.5 * a - 2.5) * a * a + 1.0,
        ((-1.5 * a + 2.0) * a + 0.5) * a,
        (0.5 * a - 0.5) * a * a,
    )


@wp.func
def bicubic_read(image: wp.array2d(dtype=wp.vec4), x: wp.float32, y: wp.float32) -> wp.vec4:
    """The sixteen pixels about a place, px, by Catmull-Rom weights: repeated reading hardly blurs."""
    i = wp.int32(wp.floor(x - 0.5))
    j = wp.int32(wp.floor(y - 0.5))
    across = catmull_rom(x - 0.5 - wp.float32(i))
    down = catmull_rom(y - 0.5 - wp.float32(j))
    total = wp.vec4(0.0, 0.0, 0.0, 0.0)
    for n in range(4):
        line = wp.vec4(0.0, 0.0, 0.0, 0.0)
        for m in range(4):
            line += pixel(image, i - 1 + m, j - 1 + n) * across[m]
        total += line * down[n]
    return total


BICUBIC = """
    const float left = __builtin_floorf(x - 0.5f), top = __builtin_floorf(y - 0.5f);
    const int i = (int)left, j = (int)top;
    auto weights = [](float a, float* w) {
        w[0] = ((-0.5f*a + 1.0f)*a - 0.5f)*a; w[1] = (1.5f*a - 2.5f)*a*a + 1.0f;
        w[2] = ((-1.5f*a + 2.0f)*a + 0.5f)*a; w[3] = (0.5f*a - 0.5f)*a*a;
    };
    float across[4], down[4];
    weights(x - 0.5f - (float)i, across);
    weights(y - 0.5f - (float)j, down);
    int at[4];
    for (int m = 0; m < 4; ++m) at[m] = column(i - 1 + m);
    vec total = 0.0f;
    for (int n = 0; n < 4; ++n) {
        const vec* row = line(j - 1 + n);
        vec sum = 0.0f;
        for (int m = 0; m < 4; ++m) sum += row[at[m]]*across[m];
        total += sum*down[n];
    }
    return result(total);
"""


@form()
def bicubic() -> Twins:
    """`bicubic_read`."""
    return Twins(bicubic_read, PIXELS.replace("IMAGE", "image") + BICUBIC)


@form()
def bilinear() -> Twins:
    """`bilinear_read`."""
    native = """
    const int i = (int)__builtin_floorf(x - 0.5f), j = (int)__builtin_floorf(y - 0.5f);
    const float a = x - 0.5f - (float)i, b = y - 0.5f - (float)j;
    const vec *above = line(j), *below = line(j + 1);
    const vec upper = above[column(i)]*(1.0f - a) + above[column(i + 1)]*a;
    const vec lower = below[column(i)]*(1.0f - a) + below[column(i + 1)]*a;
    return result(upper*(1.0f - b) + lower*b);
"""
    return Twins(bilinear_read, PIXELS.replace("IMAGE", "image") + native)


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


@wp.func
def box_clamp(fresh: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32, history: wp.vec4) -> wp.vec4:
    """The history within the range of the new frame's 3 x 3 pixels about it, in YCoCg and alpha.

    Karis 2014, High Quality Temporal Supersampling.
    """
    least = to_ycocg(fresh[j, i])
    most = least
    for y in range(j - 1, j + 2):
        for x in range(i - 1, i + 2):
            value = to_ycocg(pixel(fresh, x, y))
            least = wp.min(least, value)
            most = wp.max(most, value)
    return from_ycocg(wp.max(least, wp.min(most, to_ycocg(history))))


YCOCG = """
    auto to_ycocg = [](vec c) {
        const vec a = {0.5f, 0.5f, 0.5f, 1.0f}, b = {0.25f, -0.5f, -0.25f, 0.0f}, d = {0.25f, 0.0f, -0.25f, 0.0f};
        return c.yxyw*a + c.xzxw*b + c.zzzz*d;
    };
"""
"""C++ of RGBA as Y, Co, Cg, A."""

RANGE = """
    vec least, most;
    if (i > 0 && i < right) {
        // Two pixels at a time: on the left with the middle, and the middle with on the right.
        typedef float two __attribute__((ext_vector_type(8), aligned(4)));
        const two a = {0.5f, 0.5f, 0.5f, 1.0f, 0.5f, 0.5f, 0.5f, 1.0f};
        const two b = {0.25f, -0.5f, -0.25f, 0.0f, 0.25f, -0.5f, -0.25f, 0.0f};
        const two d = {0.25f, 0.0f, -0.25f, 0.0f, 0.25f, 0.0f, -0.25f, 0.0f};
        two low2 = __builtin_inff(), high2 = -__builtin_inff();
        for (int y = j - 1; y <= j + 1; ++y)
            for (int x = i - 1; x <= i; ++x) {
                const two c = *(const two*)(line(y) + x);
                const two value = __builtin_shufflevector(c, c, 1, 0, 1, 3, 5, 4, 5, 7)*a
                    + __builtin_shufflevector(c, c, 0, 2, 0, 3, 4, 6, 4, 7)*b
                    + __builtin_shufflevector(c, c, 2, 2, 2, 2, 6, 6, 6, 6)*d;
                low2 = value < low2 ? value : low2;
                high2 = value > high2 ? value : high2;
            }
        least = low2.lo < low2.hi ? low2.lo : low2.hi;
        most = high2.lo > high2.hi ? high2.lo : high2.hi;
    } else {
        least = most = to_ycocg(line(j)[i]);
        for (int y = j - 1; y <= j + 1; ++y)
            for (int x = i - 1; x <= i + 1; ++x) {
                const vec value = to_ycocg(line(y)[column(x)]);
                least = value < least ? value : least;
                most = value > most ? value : most;
            }
    }
"""

HELD = """
    vec held = to_ycocg(*(const vec*)history.c);
    held = held < most ? held : most;
    held = held > least ? held : least;
    const vec back = {held.x - held.z + held.y, held.x + held.z, held.x - held.z - held.y, held.w};
    return result(back);
"""
"""C++ of the history between `least` and `most`."""


@form()
def box() -> Twins:
    """`box_clamp`."""
    return Twins(box_clamp, PIXELS.replace("IMAGE", "fresh") + YCOCG + RANGE + HELD)


@wp.func
def variance_clamp(fresh: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32, history: wp.vec4) -> wp.vec4:
    """The history within one standard deviation of the mean of the new frame's 3 x 3 pixels, in YCoCg and alpha.

    Salvi 2016, An Excursion in Temporal Supersampling.
    """
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
    return from_ycocg(wp.max(mean - spread, wp.min(mean + spread, to_ycocg(history))))


@form()
def variance() -> Twins:
    """`variance_clamp`."""
    native = """
    vec around[9], mean = 0.0f, square = 0.0f;
    for (int k = 0; k < 9; ++k) around[k] = to_ycocg(line(j - 1 + k/3)[column(i - 1 + k%3)]);
    for (int k = 0; k < 9; ++k) mean += around[k]/9.0f;
    for (int k = 0; k < 9; ++k) square += (around[k] - mean)*(around[k] - mean)/9.0f;
    const vec spread = {__builtin_sqrtf(square.x), __builtin_sqrtf(square.y), __builtin_sqrtf(square.z),
                        __builtin_sqrtf(square.w)};
    const vec least = mean - spread, most = mean + spread;
"""
    return Twins(variance_clamp, PIXELS.replace("IMAGE", "fresh") + YCOCG + native + HELD)


@wp.func
def no_clamp(fresh: wp.array2d(dtype=wp.vec4), i: wp.int32, j: wp.int32, history: wp.vec4) -> wp.vec4:
    """The history unchanged."""
    return history


@form()
def none() -> Twins:
    """`no_clamp`."""
    return Twins(no_clamp, "return history;")


@wp.func
def premultiplied(c: wp.vec4) -> wp.vec4:
    """The colour without a cubic's overshoot: no negative light, and alpha within 0..1."""
    if c[3] <= 0.0:
        return wp.vec4(0.0, 0.0, 0.0, 0.0)
    return wp.max(c, wp.vec4(0.0, 0.0, 0.0, 0.0)) / wp.max(c[3], 1.0)


@form()
def premultiplying() -> Twins:
    """`premultiplied`."""
    native = """
    typedef float vec __attribute__((ext_vector_type(4), aligned(4)));
    wp::vec_t<4, float> r;
    vec value = *(const vec*)c.c;
    value = value > 0.0f ? value : 0.0f;
    if (c.c[3] <= 0.0f) value = 0.0f;
    *(vec*)r.c = value/(c.c[3] > 1.0f ? c.c[3] : 1.0f);
    return r;
"""
    return Twins(premultiplied, native)


READS: dict[str, Form] = {"bicubic": bicubic(), "bilinear": bilinear()}
CLAMPS: dict[str, Form] = {"box": box(), "variance": variance(), "none": none()}
