"""Bilinear filtering of the finest level: smooth under magnification, no better than point sampling far away."""

from typing import Any

import warp as wp

from swimlab.kernels.sampling import bilinear
from swimlab.kernels.structs import Chain, Surface
from swimlab.technique import Technique, pixel_shading


@wp.func
def finest(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
    """The four texels of level 0 about uv."""
    return bilinear(texels, chain, 0, wp.vec2(surface.uv))


TECHNIQUE = Technique(
    name="pixel-bilinear",
    summary="bilinear inputs of the finest level, shaded once a pixel",
    source="Sloan & Baker, Texture Filtering Review",
    render=pixel_shading(lambda settings: finest),
)
