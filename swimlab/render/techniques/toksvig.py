"""Toksvig's mip chain: averaged normals are short where they differ, and a short normal widens the highlight."""

from typing import Any

import warp as wp

from swimlab.render.inputs import Inputs, variances
from swimlab.render.kernels.structs import Chain
from swimlab.render.technique import moment_technique


@wp.func
def widened(texel: Any, chain: Chain):
    """power' = f power with f = r/(r + power (1 - r)), r = |N|; in variances 1/power' = 1/power + (1 - r)/r."""
    r = wp.clamp(wp.length(wp.vec3(texel[3], texel[4], texel[5])), 1.0e-6, 1.0)
    texel[7] = 1.0 / (texel[7] + (1.0 - r) / r)
    return texel


INPUTS = Inputs("toksvig", variances, widened)

TECHNIQUE = moment_technique(
    INPUTS,
    summary="aniso inputs, highlight widened by the averaged normal's length",
    source="Toksvig 2005, Mipmapping Normal Maps",
)
