"""C++ that native forms of shading have in common."""

from swimlab.render.kernels.structs import LANES

EXP2 = """
    // 2^t = 2^r 2^g, |g| <= 1/2, by the polynomial of Cephes' exp2f.
    const auto exp2 = [](float t) {
        t = t > -126.0f ? t : -126.0f;
        const float r = __builtin_floorf(t + 0.5f), g = t - r;
        float p = 1.535336188319500e-4f;
        p = p*g + 1.339887440266574e-3f; p = p*g + 9.618437357674640e-3f; p = p*g + 5.550332471162809e-2f;
        p = p*g + 2.402264791363012e-1f; p = p*g + 6.931472028550421e-1f; p = p*g + 1.0f;
        const int scale = ((int)r + 127) << 23;
        float two; __builtin_memcpy(&two, &scale, 4);
        return p*two;
    };
"""

LOGARITHM = """
    // log(x 2^-e) of a positive float, with sqrt(1/2) < x 2^-e < sqrt(2), by the polynomial of Cephes' logf.
    const auto log_of_mantissa = [](float x, int& e) {
        int bits; __builtin_memcpy(&bits, &x, 4);
        e = (bits - 0x3f3504f3) >> 23;
        bits -= e << 23;
        float m; __builtin_memcpy(&m, &bits, 4);
        const float f = m - 1.0f;
        float p = 7.0376836292e-2f;
        p = p*f - 1.1514610310e-1f; p = p*f + 1.1676998740e-1f; p = p*f - 1.2420140846e-1f;
        p = p*f + 1.4249322787e-1f; p = p*f - 1.6668057665e-1f; p = p*f + 2.0000714765e-1f;
        p = p*f - 2.4999993993e-1f; p = p*f + 3.3333331174e-1f;
        return f + (p*f - 0.5f)*f*f;
    };
"""


def half_vector_code(width: int) -> str:
    """The light (lx, my, mz) and the half vector (hx, hy, hz), not of unit length, of lane k in its tangent frame.

    For the loop over k of a packet `a` whose texels have `width` floats; (lx, ly, lz) is the light in world axes. The
    half vector is made as `shading.half_vector` makes it.
    """
    rows = {name: f"a[{(width + row) * LANES} + k]" for row, name in enumerate(("px", "py", "pz", "slope"))}
    return "\n".join(f"        const float {name} = {value};" for name, value in rows.items()) + (
        """
        const float tilt = 1.0f/__builtin_sqrtf(1.0f + slope*slope);
        const float toward = -1.0f/__builtin_sqrtf(px*px + py*py + pz*pz);
        const float my = (ly + slope*lz)*tilt, mz = (lz - slope*ly)*tilt;
        const float vx = px*toward, vy = (py + slope*pz)*tilt*toward, vz = (pz - slope*py)*tilt*toward;
        const float sx = lx + vx, sy = my + vy, sz = mz + vz, dx = lx - vx, dy = my - vy, dz = mz - vz;
        const float along = 0.25f*(sx*dx + sy*dy + sz*dz);
        const float hx = sx - along*dx, hy = sy - along*dy, hz = sz - along*dz;"""
    )
