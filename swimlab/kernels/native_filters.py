"""Texture filters over packets in native form: what `sampling` says, for a CPU.

First come the probes of all lanes, in loops that a compiler vectorises; then the taps, lane by lane, a whole texel at a
time. The taps give the bits of the plain form; levels of detail, by a float logarithm, agree to 1e-6.
"""

import functools

import warp as wp

from swimlab.kernels.structs import LANES, TEXELS, Chain

wp.set_module_options({"enable_backward": False})

LOG2 = """
    // log2 of a positive float: Cephes' logf polynomial over sqrt(1/2)..sqrt(2).
    auto log2_of = [](float x) -> float {
        int bits; __builtin_memcpy(&bits, &x, 4);
        const int e = (bits - 0x3f3504f3) >> 23;
        bits -= e << 23;
        float m; __builtin_memcpy(&m, &bits, 4);
        const float f = m - 1.0f;
        float p = 7.0376836292e-2f;
        p = p*f - 1.1514610310e-1f; p = p*f + 1.1676998740e-1f; p = p*f - 1.2420140846e-1f;
        p = p*f + 1.4249322787e-1f; p = p*f - 1.6668057665e-1f; p = p*f + 2.0000714765e-1f;
        p = p*f - 2.4999993993e-1f; p = p*f + 3.3333331174e-1f;
        return (f + (p*f - 0.5f)*f*f)*1.44269504f + (float)e;
    };
"""

FINEST = """
    for (int k = 0; k < count; ++k) {
        number[k] = 1; lod[k] = 0.0f; fu[k] = (float)q[k]; fv[k] = (float)q[LANES + k]; su[k] = sv[k] = 0.0f;
    }
"""

ISOTROPIC = """
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const double xx = q[2*LANES + k]*W, xy = q[3*LANES + k]*H, yx = q[4*LANES + k]*W, yy = q[5*LANES + k]*H;
        const double a = __builtin_sqrt(xx*xx + xy*xy), b = __builtin_sqrt(yx*yx + yy*yy);
        number[k] = 1; lod[k] = log2_of((float)(a > b ? a : b));
        fu[k] = (float)q[k]; fv[k] = (float)q[LANES + k]; su[k] = sv[k] = 0.0f;
    }
"""

ANISOTROPIC = """
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const double xx = q[2*LANES + k]*W, xy = q[3*LANES + k]*H, yx = q[4*LANES + k]*W, yy = q[5*LANES + k]*H;
        const double a = xx*xx + yx*yx, b = xx*xy + yx*yy, c = xy*xy + yy*yy, half = 0.5*(a - c);
        const double square = 0.5*(a + c) + __builtin_sqrt(half*half + b*b), major = __builtin_sqrt(square);
        const double minor = major > 0.0 ? __builtin_fabs(xx*yy - xy*yx)/major : 0.0;
        double ax = a >= c ? square - c : b, ay = a >= c ? b : square - a;
        const double length = __builtin_sqrt(ax*ax + ay*ay);
        ax = length > 0.0 ? ax/length : 1.0; ay = length > 0.0 ? ay/length : 0.0;
        const double ratio = minor*MOST > major ? __builtin_ceil(major/minor - 1.0e-6) : MOST;
        double n = ratio < MOST ? ratio : MOST;
        n = major > 1.0 && n > 1.0 ? n : 1.0;
        number[k] = (int)n; lod[k] = log2_of((float)(major/n));
        const float lu = (float)(ax*major/W), lv = (float)(ay*major/H), share = (float)n;
        su[k] = lu/share; sv[k] = lv/share;
        fu[k] = (float)q[k] - (lu - su[k])*0.5f; fv[k] = (float)q[LANES + k] - (lv - sv[k])*0.5f;
    }
"""


def _taps(part: str, kind: str, first: int, width: int) -> str:
    """Code that reads one bilinear sample of `kind` (a vector type), floats `first`... of texels of `width`."""
    return f"""
    auto tap_{part} = [&](int level, float u, float v) -> {kind} {{
        const int w = chain.width >> level > 1 ? chain.width >> level : 1;
        const int h = chain.height >> level > 1 ? chain.height >> level : 1;
        const float x = u*(float)w - 0.5f, y = v*(float)h - 0.5f;
        const float left = __builtin_floorf(x), top = __builtin_floorf(y), a = x - left, b = y - top;
        int i0 = (int)left, j0 = (int)top, i1 = i0 + 1, j1 = j0 + 1;
        if (clamps) {{
            i0 = i0 < 0 ? 0 : i0 > w - 1 ? w - 1 : i0; i1 = i1 < 0 ? 0 : i1 > w - 1 ? w - 1 : i1;
            j0 = j0 < 0 ? 0 : j0 > h - 1 ? h - 1 : j0; j1 = j1 < 0 ? 0 : j1 > h - 1 ? h - 1 : j1;
        }} else {{
            i0 &= w - 1; i1 &= w - 1; j0 &= h - 1; j1 &= h - 1;
        }}
        const float* at = data + (long)chain.offsets.data[level]*{width} + {first};
        const float* upper = at + (long)j0*w*{width}; const float* lower = at + (long)j1*w*{width};
        const {kind} m = *(const {kind}*)(upper + i0*{width})*(1.0f - a) + *(const {kind}*)(upper + i1*{width})*a;
        const {kind} n = *(const {kind}*)(lower + i0*{width})*(1.0f - a) + *(const {kind}*)(lower + i1*{width})*a;
        return m*(1.0f - b) + n*b;
    }};
"""


def _sum(part: str, kind: str, first: int, floats: int) -> str:
    """Code that leaves the mean of a lane's probes in rows `first`... of the packet."""
    store = "".join(
        f" lanes.data[{(first + i) * LANES} + k] = sum{f'.s{i:x}' if floats > 1 else ''};" for i in range(floats)
    )
    return f"""
        {{
            {kind} sum = ({kind})(0.0f);
            for (int i = 0; i < number[k]; ++i) {{
                const float u = fu[k] + su[k]*(float)i, v = fv[k] + sv[k]*(float)i;
                {kind} value = tap_{part}(level, u, v);
                if (two) value = value*(1.0f - blend) + tap_{part}(level + 1, u, v)*blend;
                sum = i == 0 ? value : sum + value;
            }}
            if (number[k] > 1) sum = sum*(1.0f/(float)number[k]);
            {store}
        }}
"""


def _filter(probes: str, width: int) -> wp.Function:
    texel_type = wp.vec4 if width == 4 else TEXELS[width]
    parts = [("whole", "vec_a", 0, min(width, 8))]
    if width > 8:
        parts.append(("rest", "vec_b", 8, width - 8))
    types = "".join(
        f"    typedef float {kind} __attribute__((ext_vector_type({floats}), aligned(4)));\n"
        if floats > 1
        else f"    typedef float {kind};\n"
        for _, kind, _, floats in parts
    )
    snippet = f"""
{types}
    const float* data = (const float*)texels.data;
    const double* __restrict q = places.data;
    const double W = (double)chain.width, H = (double)chain.height;
    const bool clamps = chain.clamps == 1;
    float lod[{LANES}], fu[{LANES}], fv[{LANES}], su[{LANES}], sv[{LANES}];
    int number[{LANES}];
{LOG2}
{probes.replace("LANES", str(LANES))}
{"".join(_taps(part, kind, first, width) for part, kind, first, _ in parts)}
    const float coarsest = (float)(chain.levels - 1);
    for (int k = 0; k < count; ++k) {{
        const float l = lod[k] > 0.0f ? (lod[k] < coarsest ? lod[k] : coarsest) : 0.0f;
        const int level = (int)l;
        const float blend = l - (float)level;
        const bool two = blend > 1.0e-6f;
{"".join(_sum(part, kind, first, floats) for part, kind, first, floats in parts)}
    }}
"""

    @wp.func_native(snippet)
    def fill(
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        places: wp.array(dtype=wp.float64),
        count: wp.int32,
        lanes: wp.array(dtype=wp.float32),
    ): ...

    return fill


@functools.cache
def finest(width: int) -> wp.Function:
    """Bilinear samples of level 0 into a packet of texels of `width` floats."""
    return _filter(FINEST, width)


@functools.cache
def isotropic(width: int) -> wp.Function:
    """Trilinear samples at the level of the longer derivative."""
    return _filter(ISOTROPIC, width)


@functools.cache
def anisotropic(width: int, most: int) -> wp.Function:
    """Means of up to `most` probes along each footprint's major axis."""
    return _filter(ANISOTROPIC.replace("MOST", f"{most}.0"), width)
