"""CLEAN mapping: the mean slope and one second moment of slopes; an isotropic highlight of their variance.

Texels hold albedo, b (x, y; about the map's mean), M = |b|^2 + 2/power, Ks and nothing.
"""

from typing import Any

import numpy as np
import warp as wp

from metrics.kernels.forms import Twins, form
from swimlab.render.inputs import Inputs, Level, Maps, slopes
from swimlab.render.kernels.packet import each_resolved
from swimlab.render.kernels.structs import Chain
from swimlab.render.technique import moment_technique


def pack(maps: Maps) -> Level:
    """Moments of level 0."""
    b, centre, variance = slopes(maps)
    second = np.sum(b * b, axis=2, keepdims=True) + 2 * variance
    nothing = np.zeros_like(second)
    texels = np.concatenate([maps.albedo, b, second, maps.gloss[..., :1], nothing], axis=2, dtype=np.float32)
    return Level(texels, centre)


@wp.func
def widened(texel: Any, chain: Chain):
    """Normal (b, 1); power = 2/(M - |b|^2), the difference no less than M's own rounding."""
    b = wp.vec2(texel[3], texel[4])
    variance = 0.5 * wp.max(texel[5] - wp.length_sq(b), texel[5] * 2.4e-7)
    texel[3] = b[0] + chain.centre[0]
    texel[4] = b[1] + chain.centre[1]
    texel[5] = 1.0
    texel[7] = 1.0 / variance
    return texel


NATIVE_RESOLVE = """
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        float* a = lanes.data + k;
        const float x = a[3*64], y = a[4*64], rounding = a[5*64]*2.4e-7f, exact = a[5*64] - (x*x + y*y);
        a[3*64] = x + chain.centre.c[0]; a[4*64] = y + chain.centre.c[1]; a[5*64] = 1.0f;
        a[7*64] = 1.0f/(0.5f*(exact > rounding ? exact : rounding));
    }
"""


@form()
def widened_lanes() -> Twins:
    """`widened` over the first lanes of a packet."""
    return Twins(each_resolved(widened, 8), NATIVE_RESOLVE, 8)


INPUTS = Inputs("clean", pack, widened, resolve_lanes=widened_lanes().native)

TECHNIQUE = moment_technique(
    INPUTS,
    summary="mean and variance of slopes, an isotropic highlight",
    source="Hill & Baker 2012, Rock-Solid Shading; after Olano & Baker 2010",
)
