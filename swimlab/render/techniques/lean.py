"""LEAN mapping: mean and covariance of slopes filter linearly; the highlight is the Gaussian they describe.

Texels hold albedo, b (x, y; about the map's mean), Mxx, Ks, Myy, Mxy, with M = b b^T + I/power. The Gaussian stands
for the deck's Blinn-Phong; other models, and maps with twist, use CLEAN's widening.
"""

import numpy as np
import warp as wp

from metrics.kernels.forms import Twins, Within, form
from swimlab.render.inputs import Inputs, Level, Maps, slopes
from swimlab.render.kernels.cpp import EXP2, half_vector_code
from swimlab.render.kernels.packet import each_resolved, plain_packet
from swimlab.render.kernels.shading import half_vector
from swimlab.render.kernels.structs import Chain, LeanTexel
from swimlab.render.technique import moment_technique
from swimlab.render.techniques import clean


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


NATIVE = f"""{EXP2}
    float* __restrict a = lanes.data;
    const float lx = sun.direction[0], ly = sun.direction[1], lz = sun.direction[2], diffuse = sun.diffuse;
    #pragma clang loop vectorize(assume_safety) vectorize_width(16)
    for (int k = 0; k < 64; ++k) {{
{half_vector_code(9)}
        const float long_h = __builtin_sqrtf(hx*hx + hy*hy + hz*hz);
        const float bx = a[3*64 + k], by = a[4*64 + k], xx = a[5*64 + k], yy = a[7*64 + k], xy = a[8*64 + k];
        const float up = hz > 1.0e-6f*long_h ? hz : 1.0f, x = hx/up - bx, y = hy/up - by;
        const float least = (xx < yy ? xx : yy)*(xx + yy)*2.4e-7f, exact = xx*yy - xy*xy;
        const float determinant = exact > least ? exact : least;
        const float gaussian = exp2(-0.72134752f*(yy*x*x - 2.0f*xy*x*y + xx*y*y)/determinant);
        const float specular = hz > 1.0e-6f*long_h ? gaussian*a[6*64 + k]/__builtin_sqrtf(determinant) : 0.0f;
        float lambert = (bx*lx + by*my + mz)/__builtin_sqrtf(bx*bx + by*by + 1.0f);
        lambert = (lambert > 0.0f ? (lambert < 1.0f ? lambert : 1.0f) : 0.0f)*diffuse;
        a[k] = a[k]*lambert + specular;
        a[64 + k] = a[64 + k]*lambert + specular;
        a[128 + k] = a[128 + k]*lambert + specular;
    }}
"""


@form(agrees=Within("native lean, relative", floor=0.1))
def lean_packet() -> Twins:
    """`reflect` over the 64 lanes of a packet."""
    return Twins(plain_packet(reflect, 9), NATIVE, 9)


NATIVE_RESOLVE = """
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        float* a = lanes.data + k;
        const float x = a[3*64], y = a[4*64], rounding = (a[5*64] + a[7*64])*2.4e-7f;
        const float xx = a[5*64] - x*x, yy = a[7*64] - y*y;
        a[5*64] = xx > rounding ? xx : rounding; a[7*64] = yy > rounding ? yy : rounding;
        a[8*64] -= x*y;
        a[3*64] = x + chain.centre.c[0]; a[4*64] = y + chain.centre.c[1];
    }
"""


@form()
def covariance_lanes() -> Twins:
    """`covariance` over the first lanes of a packet."""
    return Twins(each_resolved(covariance, 9), NATIVE_RESOLVE, 9)


INPUTS = Inputs(
    "lean",
    pack,
    covariance,
    reflect,
    lean_packet().native,
    otherwise=clean.INPUTS,
    resolve_lanes=covariance_lanes().native,
)

TECHNIQUE = moment_technique(
    INPUTS,
    summary="mean and covariance of slopes, an elliptical highlight",
    source="Olano & Baker 2010, LEAN Mapping",
)
