"""Von Mises-Fisher mip chain: the averaged normal's length gives the concentration of the normals about it."""

from typing import Any

import warp as wp

from metrics.kernels.forms import Twins, form
from swimlab.render.inputs import Inputs, variances
from swimlab.render.kernels.packet import each_resolved
from swimlab.render.kernels.structs import Chain
from swimlab.render.technique import moment_technique


@wp.func
def widened(texel: Any, chain: Chain):
    """power' = power k/(power + k) with k = (3r - r^3)/(1 - r^2), r = |N|; in variances 1/power' = 1/power + 1/k."""
    r = wp.clamp(wp.length(wp.vec3(texel[3], texel[4], texel[5])), 1.0e-6, 1.0)
    texel[7] = 1.0 / (texel[7] + (1.0 - r) * (1.0 + r) / (3.0 * r - r * r * r))
    return texel


NATIVE_RESOLVE = """
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const float x = lanes.data[3*64 + k], y = lanes.data[4*64 + k], z = lanes.data[5*64 + k];
        float r = __builtin_sqrtf(x*x + y*y + z*z);
        r = r < 1.0f ? (r > 1.0e-6f ? r : 1.0e-6f) : 1.0f;
        const float spread = (1.0f - r)*(1.0f + r)/(3.0f*r - r*r*r);
        lanes.data[7*64 + k] = 1.0f/(lanes.data[7*64 + k] + spread);
    }
"""


@form()
def widened_lanes() -> Twins:
    """`widened` over the first lanes of a packet."""
    return Twins(each_resolved(widened, 8), NATIVE_RESOLVE, 8)


INPUTS = Inputs("vmf", variances, widened, resolve_lanes=widened_lanes().native)

TECHNIQUE = moment_technique(
    INPUTS,
    summary="aniso inputs, highlight widened by a von Mises-Fisher lobe of the normals",
    source="Han et al. 2007, Frequency Domain Normal Map Filtering; Banerjee et al. 2005",
)
