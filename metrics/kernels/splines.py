"""B-spline interpolation of pictures (quintic) and of motion fields (cubic), with mirrored edges (Unser 1999).

Pictures are vectors of 4, of which 3 are colours: a vector is then one register.
"""

import warp as wp

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

POLES = {3: (-0.267949192431123,), 5: (-0.430575347099973, -0.0430962882032647)}
"""Degree of a spline -> poles of the filter that turns values into its coefficients (Unser 1999, table 1)."""

VECTORS = {2: wp.vec2, 4: wp.vec4}

LINES = 8
"""Lines that are filtered at a time: a recursion waits for its last step, several need not."""

_HORIZON = 32
"""A pole's powers are summed up to here: .43^32 is beyond single precision."""

_AGREES = Within("native spline against plain")

six = wp.types.vector(length=6, dtype=wp.float32)


@wp.func
def cubic_weights(t: wp.float32) -> wp.vec4:
    """Weights of the coefficients -1..2 at a place t in 0..1."""
    s = 1.0 - t
    return wp.vec4(s * s * s, 4.0 + t * t * (3.0 * t - 6.0), 4.0 + s * s * (3.0 * s - 6.0), t * t * t) / 6.0


@wp.func
def quintic_weights(t: wp.float32) -> six:
    """Weights of the coefficients -2..3 at a place t in 0..1."""
    s = 1.0 - t
    weights = six(
        s * s * s * s * s,
        26.0 + t * (-50.0 + t * (20.0 + t * (20.0 + t * (5.0 * t - 20.0)))),
        66.0 + t * t * (-60.0 + t * t * (30.0 - 10.0 * t)),
        66.0 + s * s * (-60.0 + s * s * (30.0 - 10.0 * s)),
        26.0 + s * (-50.0 + s * (20.0 + s * (20.0 + s * (5.0 * s - 20.0)))),
        t * t * t * t * t,
    )
    return weights / 120.0


@wp.func
def mirrored(index: wp.int32, length: wp.int32) -> wp.int32:
    """The index within 0..length-1 that an index beyond an edge stands for; far beyond it, an edge."""
    inside = wp.abs(index)
    if inside >= length:
        inside = 2 * length - 2 - inside
    return wp.clamp(inside, 0, length - 1)


_TAKE = """
    typedef float eight __attribute__((ext_vector_type(8)));
    const float left = __builtin_floorf(away[0]), up = __builtin_floorf(away[1]);
    const float tx = away[0] - left, ty = away[1] - up, sx = 1.0f - tx, sy = 1.0f - ty, part = 1.0f/6.0f;
    const float a = sx*sx*sx*part, b = (4.0f + tx*tx*(3.0f*tx - 6.0f))*part;
    const float c = (4.0f + sx*sx*(3.0f*sx - 6.0f))*part, d = tx*tx*tx*part;
    const eight across = {a, a, b, b, c, c, d, d};
    const float along[] = {sy*sy*sy*part, (4.0f + ty*ty*(3.0f*ty - 6.0f))*part,
                           (4.0f + sy*sy*(3.0f*sy - 6.0f))*part, ty*ty*ty*part};
    const int height = field.shape[0], width = field.shape[1], x = column + (int)left - 1, y = row + (int)up - 1;
    const float* const from = (const float*)field.data;
    eight sum = 0.0f;
    if (x >= 0 && y >= 0 && x + 3 < width && y + 3 < height) {
        for (int down = 0; down < 4; ++down) {
            eight line;
            __builtin_memcpy(&line, from + 2*((long)(y + down)*width + x), sizeof(line));
            sum += along[down]*line;
        }
    } else {
        const auto mirror = [](int index, int length) {
            int inside = index < 0 ? -index : index;
            inside = inside >= length ? 2*length - 2 - inside : inside;
            return inside < 0 ? 0 : inside > length - 1 ? length - 1 : inside;
        };
        for (int down = 0; down < 4; ++down) {
            const float* const line = from + 2*(long)mirror(y + down, height)*width;
            for (int right = 0; right < 4; ++right) {
                const float* const value = line + 2*mirror(x + right, width);
                sum[2*right] += along[down]*value[0];
                sum[2*right + 1] += along[down]*value[1];
            }
        }
    }
    sum *= across;
    return wp::vec2(sum[0] + sum[2] + sum[4] + sum[6], sum[1] + sum[3] + sum[5] + sum[7]);
"""


@form(agrees=_AGREES)
def field_value() -> Twins:
    """The function that gives the motion field with these cubic coefficients `away` px (x, y) from a pixel."""

    @wp.func(module="unique")
    def take(field: wp.array2d(dtype=wp.vec2), row: wp.int32, column: wp.int32, away: wp.vec2) -> wp.vec2:
        left = wp.floor(away[0])
        top = wp.floor(away[1])
        across = cubic_weights(away[0] - left)
        along = cubic_weights(away[1] - top)
        x = column + wp.int32(left) - 1
        y = row + wp.int32(top) - 1
        found = wp.vec2(0.0, 0.0)
        for right in range(4):
            line = wp.vec2(0.0, 0.0)
            c = mirrored(x + right, field.shape[1])
            for down in range(4):
                line += along[down] * field[mirrored(y + down, field.shape[0]), c]
            found += across[right] * line
        return found

    return Twins(take, _TAKE)


_FILTER = """
    typedef float vector __attribute__((ext_vector_type(%(width)d)));
    const float poles[] = {%(poles)s};
    const long along = values.strides[1]/sizeof(vector), across = values.strides[0]/sizeof(vector);
    const int length = values.shape[1], rest = values.shape[0] - first;
    const auto filter = [&](auto some, vector* at) {
        constexpr int count = decltype(some)::count;
        for (const float pole : poles) {
            const float gain = (1.0f - pole)*(1.0f - 1.0f/pole);
            vector sum[count];
            for (int k = 0; k < count; ++k) sum[k] = at[k*across];
            float power = 1.0f;
            for (int ahead = 1; ahead < %(horizon)d; ++ahead) {
                power *= pole;
                int place = ahead < length ? ahead : 2*length - 2 - ahead;
                place = place < 0 ? 0 : place;
                for (int k = 0; k < count; ++k) sum[k] += power*at[k*across + place*along];
            }
            for (int k = 0; k < count; ++k) at[k*across] = sum[k] = gain*sum[k];
            for (int place = 1; place < length; ++place)
                for (int k = 0; k < count; ++k) {
                    vector& value = at[k*across + place*along];
                    value = sum[k] = gain*value + pole*sum[k];
                }
            const int last = length - 1, before = length > 1 ? length - 2 : 0;
            const float turn = pole/(pole*pole - 1.0f);
            for (int k = 0; k < count; ++k) {
                sum[k] = turn*(sum[k] + pole*at[k*across + before*along]);
                at[k*across + last*along] = sum[k];
            }
            for (int place = last - 1; place >= 0; --place)
                for (int k = 0; k < count; ++k) {
                    vector& value = at[k*across + place*along];
                    value = sum[k] = pole*(sum[k] - value);
                }
        }
    };
    struct All { enum { count = %(lines)d }; };
    struct One { enum { count = 1 }; };
    vector* const at = (vector*)values.data + first*across;
    if (rest >= %(lines)d) filter(All{}, at);
    else for (int k = 0; k < rest; ++k) filter(One{}, at + k*across);
"""


@form(cases=[(2, 3), (4, 5)], agrees=_AGREES)
def line_filter(width: int, degree: int) -> Twins:
    """The function that turns LINES lines of values from `first` on into coefficients, in place.

    A pole after the other, recursions to the right and to the left (Unser 1999, box 2).
    """
    vector = VECTORS[width]
    poles = wp.types.vector(length=len(POLES[degree]), dtype=wp.float32)(*POLES[degree])

    @wp.func(module="unique")
    def filter(first: wp.int32, values: wp.array2d(dtype=vector)):
        length = values.shape[1]
        for line in range(first, wp.min(first + wp.static(LINES), values.shape[0])):
            for which in range(wp.static(len(POLES[degree]))):
                pole = wp.static(poles)[which]
                gain = (1.0 - pole) * (1.0 - 1.0 / pole)
                power = wp.float32(1.0)
                sum = values[line, 0]
                for ahead in range(1, wp.static(_HORIZON)):
                    power *= pole
                    sum += power * values[line, mirrored(ahead, length)]
                sum = gain * sum
                values[line, 0] = sum
                for place in range(1, length):
                    sum = gain * values[line, place] + pole * sum
                    values[line, place] = sum
                sum = (pole / (pole * pole - 1.0)) * (sum + pole * values[line, wp.max(length - 2, 0)])
                values[line, length - 1] = sum
                for back in range(2, length + 1):
                    sum = pole * (sum - values[line, length - back])
                    values[line, length - back] = sum

    code = _FILTER % {
        "width": width,
        "poles": ", ".join(f"{pole}f" for pole in POLES[degree]),
        "horizon": _HORIZON,
        "lines": LINES,
    }
    return Twins(filter, code, width)


_UNWARP = """
    typedef float four __attribute__((ext_vector_type(4)));
    typedef float eight __attribute__((ext_vector_type(8)));
    const int width = picture.shape[1], height = picture.shape[0], columns = seen.shape[2], channels = seen.shape[0];
    const long plane = (long)seen.shape[1]*columns;
    for (int column = 0; column < columns; ++column) {
        float* const to = (float*)seen.data + (long)line*columns + column;
        four value = {0.0f, 0.0f, 0.0f, 0.0f};
        if (((const unsigned char*)usable.data)[(long)line*columns + column]) {
            const float* const place = (const float*)away.data + 2*((long)line*columns + column);
            const float left = __builtin_floorf(place[0]), up = __builtin_floorf(place[1]);
            const float tx = place[0] - left, ty = place[1] - up;
            // Of tx, ty, 1 - tx and 1 - ty: the outer, the second and the inner weight of that side.
            const four t = {tx, ty, 1.0f - tx, 1.0f - ty}, t2 = t*t, part = 1.0f/120.0f;
            const four outer = t2*t2*t*part;
            const four second = (26.0f + t*(-50.0f + t*(20.0f + t*(20.0f + t*(5.0f*t - 20.0f)))))*part;
            const four inner = (66.0f + t2*(-60.0f + t2*(30.0f - 10.0f*t)))*part;
            const eight across[] = {
                __builtin_shufflevector(outer, second, 2, 2, 2, 2, 4, 4, 4, 4),
                __builtin_shufflevector(inner, inner, 0, 0, 0, 0, 2, 2, 2, 2),
                __builtin_shufflevector(second, outer, 2, 2, 2, 2, 4, 4, 4, 4)};
            const float along[] = {outer[3], second[1], inner[1], inner[3], second[3], outer[1]};
            int x = column + (int)left - 2, y = top + line + (int)up - 2;
            x = x < 0 ? 0 : x > width - 6 ? width - 6 : x;
            y = y < 0 ? 0 : y > height - 6 ? height - 6 : y;
            const float* from = (const float*)picture.data + 4*((long)y*width + x);
            eight sum = 0.0f;
            for (int down = 0; down < 6; ++down, from += 4*width) {
                eight pair[3];
                __builtin_memcpy(pair, from, sizeof(pair));
                sum += along[down]*(across[0]*pair[0] + across[1]*pair[1] + across[2]*pair[2]);
            }
            value = sum.lo + sum.hi;
        }
        for (int channel = 0; channel < channels; ++channel) to[channel*plane] = value[channel];
    }
"""


@form(agrees=_AGREES)
def row_unwarping() -> Twins:
    """The function that takes a row of the picture with these quintic coefficients at other places.

    Each pixel is taken `away` px (x, y) from its own place, 0 where it is not usable. top: the picture's row that row 0
    of away, usable and seen [channels, rows, W] is. What is usable lies 3 px and more inside a picture, which is 6 px
    wide and high at least.
    """

    @wp.func(module="unique")
    def unwarp(
        line: wp.int32,
        picture: wp.array2d(dtype=wp.vec4),
        away: wp.array2d(dtype=wp.vec2),
        usable: wp.array2d(dtype=wp.uint8),
        top: wp.int32,
        seen: wp.array3d(dtype=wp.float32),
    ):
        for column in range(seen.shape[2]):
            value = wp.vec4(0.0, 0.0, 0.0, 0.0)
            if usable[line, column] != wp.uint8(0):
                place = away[line, column]
                left = wp.floor(place[0])
                up = wp.floor(place[1])
                across = quintic_weights(place[0] - left)
                along = quintic_weights(place[1] - up)
                x = wp.clamp(column + wp.int32(left) - 2, 0, picture.shape[1] - 6)
                y = wp.clamp(top + line + wp.int32(up) - 2, 0, picture.shape[0] - 6)
                for down in range(6):
                    part = wp.vec4(0.0, 0.0, 0.0, 0.0)
                    for right in range(6):
                        part += across[right] * picture[y + down, x + right]
                    value += along[down] * part
            for channel in range(seen.shape[0]):
                seen[channel, line, column] = value[channel]

    return Twins(unwarp, _UNWARP)


_INTERLEAVE = """
    const int width = picture.shape[1], channels = planes.shape[0];
    float* const to = (float*)picture.data + 4*(long)row*width;
    for (int column = 0; column < 4*width; ++column) to[column] = 0.0f;
    for (int channel = 0; channel < channels; ++channel) {
        const float* const from = (const float*)planes.data + ((long)channel*planes.shape[1] + row)*width;
        for (int column = 0; column < width; ++column) to[4*column + channel] = from[column];
    }
"""


@form()
def row_interleaving() -> Twins:
    """The function that makes vectors of 4 of a row of a picture's planes [1 to 3, H, W]."""

    @wp.func(module="unique")
    def interleave(row: wp.int32, planes: wp.array3d(dtype=wp.float32), picture: wp.array2d(dtype=wp.vec4)):
        for column in range(picture.shape[1]):
            value = wp.vec4(0.0, 0.0, 0.0, 0.0)
            for channel in range(planes.shape[0]):
                value[channel] = planes[channel, row, column]
            picture[row, column] = value

    return Twins(interleave, _INTERLEAVE)


@made_once
def filter_lines(width: int, degree: int, device: str) -> wp.Kernel:
    """The kernel that turns lines of values into coefficients of a spline in place, LINES of them a thread."""
    filter = line_filter(width, degree).on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(first: wp.int32, values: wp.array2d(dtype=VECTORS[width])):
        filter(first + wp.static(LINES) * wp.tid(), values)

    return kernel


@made_once
def unwarp_rows(device: str) -> wp.Kernel:
    """The kernel that unwarps rows of a picture, one a thread."""
    unwarp = row_unwarping().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        picture: wp.array2d(dtype=wp.vec4),
        away: wp.array2d(dtype=wp.vec2),
        usable: wp.array2d(dtype=wp.uint8),
        top: wp.int32,
        seen: wp.array3d(dtype=wp.float32),
    ):
        unwarp(first + wp.tid(), picture, away, usable, top, seen)

    return kernel


@made_once
def interleave_rows(device: str) -> wp.Kernel:
    """The kernel that makes vectors of 4 of the rows of a picture's planes, one row a thread."""
    interleave = row_interleaving().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(first: wp.int32, planes: wp.array3d(dtype=wp.float32), picture: wp.array2d(dtype=wp.vec4)):
        interleave(first + wp.tid(), planes, picture)

    return kernel
