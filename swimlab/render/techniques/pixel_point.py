"""Point sampling: shade the one texel under the pixel's centre. Texels between are missed: it sparkles."""

from typing import Any

import warp as wp

from metrics.kernels.forms import Twins, form
from swimlab.render.kernels.packet import WIDTHS, each_lane
from swimlab.render.kernels.sampling import point
from swimlab.render.kernels.structs import LANES, Chain, Surface
from swimlab.render.kernels.texture_filter import TextureFilter
from swimlab.render.technique import Technique, pixel_shading


@wp.func
def nearest(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
    """The texel of level 0 that holds uv."""
    return point(texels, chain, surface.uv)


@form(cases=WIDTHS)
def nearest_texels(width: int) -> Twins:
    """`nearest` of the lanes of a packet, of texels of `width` floats."""
    native = f"""
    const float* __restrict data = (const float*)texels.data;
    float* __restrict out = lanes.data;
    const double* __restrict q = places.data;
    const double wide = (double)chain.width, high = (double)chain.height;
    const int right = chain.width - 1, low = chain.height - 1;
    const bool clamps = chain.clamps == 1;
    int at[{LANES}];
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {{
        const int i = (int)__builtin_floor(q[k]*wide + 1.0e-9), j = (int)__builtin_floor(q[{LANES} + k]*high + 1.0e-9);
        const int a = clamps ? (i < 0 ? 0 : i > right ? right : i) : i & right;
        const int b = clamps ? (j < 0 ? 0 : j > low ? low : j) : j & low;
        at[k] = {width}*(b*(right + 1) + a);
    }}
    for (int k = 0; k < count; ++k)
        for (int row = 0; row < {width}; ++row) out[row*{LANES} + k] = data[at[k] + row];
"""
    return Twins(each_lane(nearest, width), native, width)


TECHNIQUE = Technique(
    name="pixel-point",
    summary="one texel a pixel, no filter",
    source="Sloan & Baker, Texture Filtering Review",
    render=pixel_shading(lambda settings: TextureFilter(nearest, nearest_texels)),
)
