"""Blinn-Phong with the deck's normalisation (Blinn 1977; Sloan & Baker): C = sat(N.H)^p p Ks + sat(N.L) diffuse Kd.

The specular term is not gated by N.L: this is the deck's radiance as written.
"""

import warp as wp

from swimlab.brdf import Brdf
from swimlab.kernels.shading import power_of_cosine
from swimlab.kernels.structs import Sun, Texel


@wp.func
def evaluate(texel: Texel, normal: wp.vec3, light: wp.vec3, view: wp.vec3, diffuse: wp.float32) -> wp.vec3:
    """Radiance in the local frame; `light` and `view` are unit vectors away from the surface."""
    power = texel[7]
    specular = power_of_cosine(normal, wp.normalize(light + view), power) * power * texel[6]
    lambert = wp.clamp(wp.dot(normal, light), 0.0, 1.0) * diffuse
    return wp.vec3(texel[0], texel[1], texel[2]) * lambert + wp.vec3(specular, specular, specular)


NATIVE = """
    float* __restrict a = lanes.data;
    const float lx = sun.direction[0], ly = sun.direction[1], lz = sun.direction[2], diffuse = sun.diffuse;
    #pragma clang loop vectorize(assume_safety) vectorize_width(16)
    for (int k = 0; k < 64; ++k) {
        const float slope = a[11*64 + k], tilt = 1.0f/__builtin_sqrtf(1.0f + slope*slope);
        const float x = a[8*64 + k], y = a[9*64 + k], z = a[10*64 + k];
        const float toward = -1.0f/__builtin_sqrtf(x*x + y*y + z*z);
        const float my = (ly + slope*lz)*tilt, mz = (lz - slope*ly)*tilt;
        float hx = lx + x*toward, hy = my + (y + slope*z)*tilt*toward, hz = mz + (z - slope*y)*tilt*toward;
        const float h = 1.0f/__builtin_sqrtf(hx*hx + hy*hy + hz*hz);
        hx *= h; hy *= h; hz *= h;
        float nx = a[3*64 + k], ny = a[4*64 + k], nz = a[5*64 + k];
        const float n = 1.0f/__builtin_sqrtf(nx*nx + ny*ny + nz*nz);
        nx *= n; ny *= n; nz *= n;
        const float cosine = nx*hx + ny*hy + nz*hz;
        const float cx = ny*hz - nz*hy, cy = nz*hx - nx*hz, cz = nx*hy - ny*hx;
        const float s = cx*cx + cy*cy + cz*cz;
        // log(1 - s): log(u) s/(1 - u) with u = 1 - s as rounded; log(u) by the polynomial of Cephes' logf.
        const float u = 1.0f - s > 1.2e-38f ? 1.0f - s : 1.2e-38f;
        int bits; __builtin_memcpy(&bits, &u, 4);
        const int e = (bits - 0x3f3504f3) >> 23;
        bits -= e << 23;
        float m; __builtin_memcpy(&m, &bits, 4);
        const float f = m - 1.0f;
        float q = 7.0376836292e-2f;
        q = q*f - 1.1514610310e-1f; q = q*f + 1.1676998740e-1f; q = q*f - 1.2420140846e-1f;
        q = q*f + 1.4249322787e-1f; q = q*f - 1.6668057665e-1f; q = q*f + 2.0000714765e-1f;
        q = q*f - 2.4999993993e-1f; q = q*f + 3.3333331174e-1f;
        const float log_u = (f + (q*f - 0.5f)*f*f) + (float)e*0.693147181f;
        const float log_1s = u < 1.0f ? log_u*(s/(1.0f - u)) : -s;
        // exp(t) = 2^r 2^g, |g| <= 1/2, by the polynomial of Cephes' exp2f.
        const float power = a[7*64 + k];
        float t = 0.72134752f*power*log_1s;
        t = t > -126.0f ? t : -126.0f;
        const float r = __builtin_floorf(t + 0.5f), g = t - r;
        float p = 1.535336188319500e-4f;
        p = p*g + 1.339887440266574e-3f; p = p*g + 9.618437357674640e-3f; p = p*g + 5.550332471162809e-2f;
        p = p*g + 2.402264791363012e-1f; p = p*g + 6.931472028550421e-1f; p = p*g + 1.0f;
        const int scale = ((int)r + 127) << 23;
        float two; __builtin_memcpy(&two, &scale, 4);
        const float specular = cosine > 0.0f ? p*two*power*a[6*64 + k] : 0.0f;
        float lambert = nx*lx + ny*my + nz*mz;
        lambert = (lambert > 0.0f ? (lambert < 1.0f ? lambert : 1.0f) : 0.0f)*diffuse;
        a[k] = a[k]*lambert + specular;
        a[64 + k] = a[64 + k]*lambert + specular;
        a[128 + k] = a[128 + k]*lambert + specular;
    }
"""


@wp.func_native(NATIVE)
def native(lanes: wp.array(dtype=wp.float32), sun: Sun):
    """`evaluate` over the 64 lanes of a packet, in a loop that clang vectorises."""


BRDF = Brdf(
    name="blinn-phong",
    summary="Blinn-Phong with the deck's normalisation by the power",
    source="Blinn 1977; Sloan & Baker, Part II: Techniques",
    evaluate=evaluate,
    native=native,
)
