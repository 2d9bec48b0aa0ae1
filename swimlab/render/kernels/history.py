"""The history of a picture: how it is read between pixels."""

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
