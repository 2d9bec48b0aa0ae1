"""Von Mises-Fisher mip chain: the averaged normal's length gives the concentration of the normals about it."""

from typing import Any

import warp as wp

from swimlab.render.inputs import Inputs, variances
from swimlab.render.kernels.structs import Chain
from swimlab.render.technique import moment_technique


@wp.func
def widened(texel: Any, chain: Chain):
    """power' = power k/(power + k) with k = (3r - r^3)/(1 - r^2), r = |N|; in variances 1/power' = 1/power + 1/k."""
    r = wp.clamp(wp.length(wp.vec3(texel[3], texel[4], texel[5])), 1.0e-6, 1.0)
    texel[7] = 1.0 / (texel[7] + (1.0 - r) * (1.0 + r) / (3.0 * r - r * r * r))
    return texel


INPUTS = Inputs("vmf", variances, widened)

TECHNIQUE = moment_technique(
    INPUTS,
    summary="aniso inputs, highlight widened by a von Mises-Fisher lobe of the normals",
    source="Han et al. 2007, Frequency Domain Normal Map Filtering; Banerjee et al. 2005",
)
