"""LEAN mapping: mean and covariance of slopes filter linearly; the highlight is the Gaussian they describe.

Texels hold albedo, b (x, y; about the map's mean), Mxx, Ks, Myy, Mxy, with M = b b^T + I/power. The Gaussian stands
for the deck's Blinn-Phong; other models, and maps with twist, fall back to CLEAN's widening.
"""

import numpy as np
import warp as wp

from swimlab.inputs import Inputs, Level, Maps, slopes
from swimlab.kernels.shading import half_vector
from swimlab.kernels.structs import Chain, LeanTexel, Sun
from swimlab.moments import moment_technique
from swimlab.techniques import clean


def pack(maps: Maps) -> Level:
    """Moments of level 0."""
    b, centre, variance = slopes(maps)
    x, y = b[..., :1], b[..., 1:]
    parts = [maps.albedo, b, x * x + variance, maps.gloss[..., :1], y * y + variance, x * y]
    return Level(np.concatenate(parts, axis=2, dtype=np.float32), centre)


@wp.func
def covariance(texel: LeanTexel, chain: Chain) -> LeanTexel:
    """M - b b^T in place of M, no less than M's own rounding, and b about 0."""
    x = texel[3]
    y = texel[4]
    rounding = (texel[5] + texel[7]) * 2.4e-7
    texel[5] = wp.max(texel[5] - x * x, rounding)
    texel[7] = wp.max(texel[7] - y * y, rounding)
    texel[8] = texel[8] - x * y
    texel[3] = x + chain.centre[0]
    texel[4] = y + chain.centre[1]
    return texel


@wp.func
def reflect(texel: LeanTexel, light: wp.vec3, view: wp.vec3, diffuse: wp.float32) -> wp.vec3:
    """Ks exp(-(h - b)^T S^-1 (h - b) / 2) / sqrt(det S) with h = H.xy/H.z, and the deck's diffuse term by (b, 1)."""
    normal = wp.normalize(wp.vec3(texel[3], texel[4], 1.0))
    lambert = wp.clamp(wp.dot(normal, light), 0.0, 1.0) * diffuse
    colour = wp.vec3(texel[0], texel[1], texel[2]) * lambert
    half = half_vector(light, view)
    if half[2] > 1.0e-6:
        x = half[0] / half[2] - texel[3]
        y = half[1] / half[2] - texel[4]
        least = wp.min(texel[5], texel[7]) * (texel[5] + texel[7]) * 2.4e-7
        determinant = wp.max(texel[5] * texel[7] - texel[8] * texel[8], least)
        exponent = (texel[7] * x * x - 2.0 * texel[8] * x * y + texel[5] * y * y) / determinant
        specular = texel[6] * wp.exp(-0.5 * exponent) / wp.sqrt(determinant)
        colour += wp.vec3(specular, specular, specular)
    return colour


NATIVE = """
    float* __restrict a = lanes.data;
    const float lx = sun.direction[0], ly = sun.direction[1], lz = sun.direction[2], diffuse = sun.diffuse;
    #pragma clang loop vectorize(assume_safety) vectorize_width(16)
    for (int k = 0; k < 64; ++k) {
        const float slope = a[12*64 + k], tilt = 1.0f/__builtin_sqrtf(1.0f + slope*slope);
        const float px = a[9*64 + k], py = a[10*64 + k], pz = a[11*64 + k];
        const float toward = -1.0f/__builtin_sqrtf(px*px + py*py + pz*pz);
        const float my = (ly + slope*lz)*tilt, mz = (lz - slope*ly)*tilt;
        // As `half_vector`.
        const float vx = px*toward, vy = (py + slope*pz)*tilt*toward, vz = (pz - slope*py)*tilt*toward;
        const float sx = lx + vx, sy = my + vy, sz = mz + vz, dx = lx - vx, dy = my - vy, dz = mz - vz;
        const float along = 0.25f*(sx*dx + sy*dy + sz*dz);
        const float hx = sx - along*dx, hy = sy - along*dy, hz = sz - along*dz;
        const float long_h = __builtin_sqrtf(hx*hx + hy*hy + hz*hz);
        const float bx = a[3*64 + k], by = a[4*64 + k], xx = a[5*64 + k], yy = a[7*64 + k], xy = a[8*64 + k];
        const float up = hz > 1.0e-6f*long_h ? hz : 1.0f, x = hx/up - bx, y = hy/up - by;
        const float least = (xx < yy ? xx : yy)*(xx + yy)*2.4e-7f, exact = xx*yy - xy*xy;
        const float determinant = exact > least ? exact : least;
        // exp(t) = 2^r 2^g, |g| <= 1/2, by the polynomial of Cephes' exp2f.
        float t = -0.72134752f*(yy*x*x - 2.0f*xy*x*y + xx*y*y)/determinant;
        t = t > -126.0f ? t : -126.0f;
        const float r = __builtin_floorf(t + 0.5f), g = t - r;
        float p = 1.535336188319500e-4f;
        p = p*g + 1.339887440266574e-3f; p = p*g + 9.618437357674640e-3f; p = p*g + 5.550332471162809e-2f;
        p = p*g + 2.402264791363012e-1f; p = p*g + 6.931472028550421e-1f; p = p*g + 1.0f;
        const int scale = ((int)r + 127) << 23;
        float two; __builtin_memcpy(&two, &scale, 4);
        const float specular = hz > 1.0e-6f*long_h ? p*two*a[6*64 + k]/__builtin_sqrtf(determinant) : 0.0f;
        float lambert = (bx*lx + by*my + mz)/__builtin_sqrtf(bx*bx + by*by + 1.0f);
        lambert = (lambert > 0.0f ? (lambert < 1.0f ? lambert : 1.0f) : 0.0f)*diffuse;
        a[k] = a[k]*lambert + specular;
        a[64 + k] = a[64 + k]*lambert + specular;
        a[128 + k] = a[128 + k]*lambert + specular;
    }
"""


@wp.func_native(NATIVE)
def native(lanes: wp.array(dtype=wp.float32), sun: Sun):
    """`reflect` over the 64 lanes of a packet, in a loop that clang vectorises."""


INPUTS = Inputs("lean", pack, covariance, reflect, native, otherwise=clean.INPUTS)

TECHNIQUE = moment_technique(
    INPUTS,
    summary="mean and covariance of slopes, an elliptical highlight",
    source="Olano & Baker 2010, LEAN Mapping",
)
