"""B-spline interpolation of pictures (quintic) and of motion fields (cubic), with mirrored edges (Unser 1999).

What they are interpolated from are planes of coefficients, which a filter makes of values.
"""

import warp as wp

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.lanes import LANES, VECTORS, transposition
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

POLES = {3: (-0.267949192431123,), 5: (-0.430575347099973, -0.0430962882032647)}
"""Degree of a spline -> poles of the filter that turns values into its coefficients (Unser 1999, table 1)."""

LINES = 2 * LANES
"""Lines that are filtered at a time: a recursion waits for its last step, several need not."""

AGREES = Within("native spline against plain")

_HORIZON = 32
"""A pole's powers are summed up to here: .43^32 is beyond single precision."""

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


_FILTER = """
    constexpr int N = %(lines)d, V = N/L;
    const float poles[] = {%(poles)s};
    const int length = values.shape[1], rest = values.shape[0] - first;
    const auto transpose = [](lanes* block) {
        lanes a, b;
%(transposition)s
    };
    // Line by line side by side, [length][N]; a block of lines that are rows is transposed.
    float* const held = (float*)scratch.data;
    const auto move = [&](auto& array, auto in) {
        const long along = array.strides[1]/sizeof(float), across = array.strides[0]/sizeof(float);
        float* const at = (float*)array.data + first*across;
        int place = 0;
        if (rest >= N && across == 1)
            for (; place < length; ++place)
                __builtin_memcpy(in ? held + place*N : at + place*along, in ? at + place*along : held + place*N, 4*N);
        if (rest >= N && along == 1)
            for (; place + L <= length; place += L)
                for (int top = 0; top < N; top += L) {
                    lanes block[L];
                    for (int k = 0; k < L; ++k)
                        block[k] = load(in ? at + (top + k)*across + place : held + (place + k)*N + top);
                    transpose(block);
                    for (int k = 0; k < L; ++k)
                        __builtin_memcpy(in ? held + (place + k)*N + top : at + (top + k)*across + place, block + k,
                                         sizeof(lanes));
                }
        for (; place < length; ++place)
            for (int k = 0; k < N && k < rest; ++k) {
                float& value = at[k*across + place*along];
                (in ? held[place*N + k] : value) = in ? value : held[place*N + k];
            }
    };
    struct In { constexpr operator bool() const { return true; } };
    struct Out { constexpr operator bool() const { return false; } };
    move(source, In{});
    typedef float loose __attribute__((ext_vector_type(L), aligned(4)));
    loose* const at = (loose*)held;
    for (const float pole : poles) {
        const float gain = (1.0f - pole)*(1.0f - 1.0f/pole);
        lanes sum[V];
        for (int k = 0; k < V; ++k) sum[k] = at[k];
        float power = 1.0f;
        for (int ahead = 1; ahead < %(horizon)d; ++ahead) {
            power *= pole;
            int place = ahead < length ? ahead : 2*length - 2 - ahead;
            place = place < 0 ? 0 : place;
            for (int k = 0; k < V; ++k) sum[k] += power*at[place*V + k];
        }
        for (int k = 0; k < V; ++k) at[k] = sum[k] = gain*sum[k];
        for (int place = 1; place < length; ++place)
            for (int k = 0; k < V; ++k) at[place*V + k] = sum[k] = gain*at[place*V + k] + pole*sum[k];
        const int last = length - 1, before = length > 1 ? length - 2 : 0;
        const float turn = pole/(pole*pole - 1.0f);
        for (int k = 0; k < V; ++k) at[last*V + k] = sum[k] = turn*(sum[k] + pole*at[before*V + k]);
        for (int place = last - 1; place >= 0; --place)
            for (int k = 0; k < V; ++k) at[place*V + k] = sum[k] = pole*(sum[k] - at[place*V + k]);
    }
    move(values, Out{});
"""


@form(cases=[(3,), (5,)], agrees=AGREES)
def line_filter(degree: int) -> Twins:
    """The function that turns LINES lines of values from `first` on into coefficients.

    A pole after the other, recursions to the right and to the left (Unser 1999, box 2). source, values: [lines,
    length]; the same array, if need be. scratch: [LINES length].
    """
    poles = wp.types.vector(length=len(POLES[degree]), dtype=wp.float32)(*POLES[degree])

    @wp.func(module="unique")
    def filter(
        first: wp.int32,
        source: wp.array2d(dtype=wp.float32),
        values: wp.array2d(dtype=wp.float32),
        scratch: wp.array(dtype=wp.float32),
    ):
        length = values.shape[1]
        for line in range(first, wp.min(first + wp.static(LINES), values.shape[0])):
            for place in range(length):
                values[line, place] = source[line, place]
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
        "poles": ", ".join(f"{pole}f" for pole in POLES[degree]),
        "horizon": _HORIZON,
        "lines": LINES,
        "transposition": transposition(LANES),
    }
    return Twins(filter, VECTORS + code)


@made_once
def filter_lines(degree: int, device: str) -> wp.Kernel:
    """The kernel that turns lines of values into coefficients of a spline, LINES of them a thread."""
    filter = line_filter(degree).on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        source: wp.array2d(dtype=wp.float32),
        values: wp.array2d(dtype=wp.float32),
        scratch: wp.array(dtype=wp.float32),
    ):
        filter(first + wp.static(LINES) * wp.tid(), source, values, scratch)

    return kernel
