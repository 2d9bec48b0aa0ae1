"""Blinn-Phong (Blinn 1977; Sloan & Baker): C = sat(N.H)^p n(p) Ks + sat(N.L) diffuse Kd, p the power.

The specular term is not gated by N.L: this is the deck's radiance as written. Its normalisation n(p) is
deck: p;
ndf: (p + 2) / (2 pi), for which the lobe is a distribution of normals, its integral over N.H d(omega) 1;
energy: (p + 2)(p + 4) / (8 pi (2^(-p/2) + p)), for which at normal incidence the light reflected is Ks of what comes;
the usual (p + 8) / (8 pi) is above that by 7.5% at p = 10 and .2% at p = 1000.
"""

from functools import cache
from typing import Literal

import warp as wp
from pydantic import Field

from swimlab.brdf import Brdf, Model
from swimlab.kernels.shading import power_of_cosine
from swimlab.kernels.structs import Sun
from swimlab.settings import Settings


class BlinnPhongSettings(Settings):
    """How bright the highlight is."""

    normalisation: Literal["deck", "ndf", "energy"] = Field(
        "deck",
        description="the lobe's factor: deck (p), ndf ((p+2) / (2 pi)), energy ((p+2)(p+4) / (8 pi (2^(-p/2) + p)))",
    )


@wp.func
def deck(power: wp.float32) -> wp.float32:
    """The power itself."""
    return power


@wp.func
def ndf(power: wp.float32) -> wp.float32:
    """(p + 2) / (2 pi)."""
    return (power + 2.0) / (2.0 * wp.PI)


@wp.func
def energy(power: wp.float32) -> wp.float32:
    """(p + 2)(p + 4) / (8 pi (2^(-p/2) + p))."""
    return (power + 2.0) * (power + 4.0) / (8.0 * wp.PI * (wp.exp(-0.5 * wp.log(2.0) * power) + power))


FACTORS = {"deck": deck, "ndf": ndf, "energy": energy}
"""Normalisations by name."""

NATIVE_FACTORS = {
    "deck": "power",
    "ndf": "(power + 2.0f)*0.159154943f",
    "energy": "(power + 2.0f)*(power + 4.0f)/(25.1327412f*(exp2(-0.5f*power) + power))",
}
"""The same in the native form."""

NATIVE = """
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
    float* __restrict a = lanes.data;
    const float lx = sun.direction[0], ly = sun.direction[1], lz = sun.direction[2], diffuse = sun.diffuse;
    #pragma clang loop vectorize(assume_safety) vectorize_width(16)
    for (int k = 0; k < 64; ++k) {
        const float slope = a[11*64 + k], tilt = 1.0f/__builtin_sqrtf(1.0f + slope*slope);
        const float x = a[8*64 + k], y = a[9*64 + k], z = a[10*64 + k];
        const float toward = -1.0f/__builtin_sqrtf(x*x + y*y + z*z);
        const float my = (ly + slope*lz)*tilt, mz = (lz - slope*ly)*tilt;
        // As `half_vector`.
        const float vx = x*toward, vy = (y + slope*z)*tilt*toward, vz = (z - slope*y)*tilt*toward;
        const float sx = lx + vx, sy = my + vy, sz = mz + vz, dx = lx - vx, dy = my - vy, dz = mz - vz;
        const float along = 0.25f*(sx*dx + sy*dy + sz*dz);
        float hx = sx - along*dx, hy = sy - along*dy, hz = sz - along*dz;
        const float h = 1.0f/__builtin_sqrtf(hx*hx + hy*hy + hz*hz);
        hx *= h; hy *= h; hz *= h;
        float nx = a[3*64 + k], ny = a[4*64 + k], nz = a[5*64 + k];
        const float n = 1.0f/__builtin_sqrtf(nx*nx + ny*ny + nz*nz);
        nx *= n; ny *= n; nz *= n;
        const float cosine = nx*hx + ny*hy + nz*hz;
        const float cx = ny*hz - nz*hy, cy = nz*hx - nx*hz, cz = nx*hy - ny*hx;
        const float s = cx*cx + cy*cy + cz*cz;
        // log(1 - s): log(u) s/(1 - u) with u = 1 - s as rounded, beyond 45 degrees log(u) with u = (N.H)^2; log(u) by
        // the polynomial of Cephes' logf.
        const float squared = s > 0.5f ? cosine*cosine : 1.0f - s;
        const float u = squared > 1.2e-38f ? squared : 1.2e-38f;
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
        const float log_1s = s > 0.5f ? log_u : u < 1.0f ? log_u*(s/(1.0f - u)) : -s;
        const float power = a[7*64 + k];
        const float lobe = power > 0.0f ? (cosine > 0.0f ? exp2(0.72134752f*power*log_1s) : 0.0f) : 1.0f;
        const float specular = lobe*(FACTOR)*a[6*64 + k];
        float lambert = nx*lx + ny*my + nz*mz;
        lambert = (lambert > 0.0f ? (lambert < 1.0f ? lambert : 1.0f) : 0.0f)*diffuse;
        a[k] = a[k]*lambert + specular;
        a[64 + k] = a[64 + k]*lambert + specular;
        a[128 + k] = a[128 + k]*lambert + specular;
    }
"""


@cache
def with_normalisation(settings: BlinnPhongSettings) -> Model:
    """The model, plain and native."""
    factor = FACTORS[settings.normalisation]

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        specular = power_of_cosine(wp.normalize(light + view), power) * factor(power) * ks
        lambert = wp.clamp(light[2], 0.0, 1.0) * diffuse
        return albedo * lambert + wp.vec3(specular, specular, specular)

    @wp.func_native(NATIVE.replace("FACTOR", NATIVE_FACTORS[settings.normalisation]))
    def native(lanes: wp.array(dtype=wp.float32), sun: Sun): ...

    return Model(evaluate, native, slopes_are_gaussian=settings.normalisation == "deck")


BRDF = Brdf(
    name="blinn-phong",
    summary="Blinn-Phong, normalised by the deck's power, as a distribution or by energy",
    source="Blinn 1977; Sloan & Baker, Part II: Techniques",
    model=with_normalisation,
    settings=BlinnPhongSettings,
)
