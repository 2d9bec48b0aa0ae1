"""Point sampling: shade the one texel under the pixel's centre. Texels between are missed: it sparkles."""

from typing import Any

import warp as wp

from swimlab.render.kernels.sampling import point
from swimlab.render.kernels.structs import Chain, Surface
from swimlab.render.kernels.texture_filter import TextureFilter
from swimlab.render.technique import Technique, pixel_shading


@wp.func
def nearest(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
    """The texel of level 0 that holds uv."""
    return point(texels, chain, surface.uv)


TECHNIQUE = Technique(
    name="pixel-point",
    summary="one texel a pixel, no filter",
    source="Sloan & Baker, Texture Filtering Review",
    render=pixel_shading(lambda settings: TextureFilter(nearest)),
)
