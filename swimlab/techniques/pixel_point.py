"""Point sampling: shade the one texel under the pixel's centre. What lies between is missed: it sparkles."""

import warp as wp

from swimlab.kernels.sampling import point
from swimlab.kernels.structs import Chain, Surface, Texel
from swimlab.technique import Technique, pixel_shading


@wp.func
def nearest(texels: wp.array(dtype=Texel), chain: Chain, surface: Surface) -> Texel:
    """The texel of level 0 that holds uv."""
    return point(texels, chain, surface.uv)


TECHNIQUE = Technique(
    name="pixel-point",
    summary="one texel a pixel, no filter",
    source="Sloan & Baker, Texture Filtering Review",
    render=pixel_shading(lambda settings: nearest),
)
