"""C++ of the probes that a filter takes: of each lane their number, level of detail, first place and step.

`q` has the footprints of a packet, W and H are the texels of level 0.
"""

from swimlab.render.kernels.cpp import LOGARITHM

LOG2 = f"""{LOGARITHM}
    const auto log2_of = [&](float x) {{
        int e; const float rest = log_of_mantissa(x, e);
        return rest*1.44269504f + (float)e;
    }};
"""

FINEST_PROBE = """
    for (int k = 0; k < count; ++k) number[k] = 1;
"""

ISOTROPIC_PROBE = """
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const double xx = q[2*LANES + k]*W, xy = q[3*LANES + k]*H, yx = q[4*LANES + k]*W, yy = q[5*LANES + k]*H;
        const double a = __builtin_sqrt(xx*xx + xy*xy), b = __builtin_sqrt(yx*yx + yy*yy);
        number[k] = 1; lod[k] = log2_of((float)(a > b ? a : b));
        fu[k] = (float)q[k]; fv[k] = (float)q[LANES + k]; su[k] = sv[k] = 0.0f;
    }
"""

ANISOTROPIC_PROBES = """
    float au[LANES], av[LANES];
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
        au[k] = (lu - su[k])*0.5f; av[k] = (lv - sv[k])*0.5f;
        fu[k] = (float)q[k] - au[k]; fv[k] = (float)q[LANES + k] - av[k];
    }
"""
