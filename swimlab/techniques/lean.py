"""LEAN mapping: mean and covariance of slopes filter linearly; the highlight is the Gaussian they describe.

Texels hold albedo, b (x, y; about the map's mean), Mxx, Ks, Myy, Mxy, with M = b b^T + I/power. The Gaussian stands
for the deck's Blinn-Phong; other models, and maps with twist, fall back to CLEAN's widening.
"""

import numpy as np
import warp as wp

from swimlab.inputs import Inputs, Level, Maps, slopes
from swimlab.kernels.structs import Chain, LeanTexel
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
    half = wp.normalize(light + view)
    if half[2] > 1.0e-6:
        x = half[0] / half[2] - texel[3]
        y = half[1] / half[2] - texel[4]
        least = wp.min(texel[5], texel[7]) * (texel[5] + texel[7]) * 2.4e-7
        determinant = wp.max(texel[5] * texel[7] - texel[8] * texel[8], least)
        exponent = (texel[7] * x * x - 2.0 * texel[8] * x * y + texel[5] * y * y) / determinant
        specular = texel[6] * wp.exp(-0.5 * exponent) / wp.sqrt(determinant)
        colour += wp.vec3(specular, specular, specular)
    return colour


INPUTS = Inputs("lean", pack, covariance, reflect, otherwise=clean.INPUTS)

TECHNIQUE = moment_technique(
    INPUTS,
    summary="mean and covariance of slopes, an elliptical highlight",
    source="Olano & Baker 2010, LEAN Mapping",
)
