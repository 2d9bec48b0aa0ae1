"""Bilinear filtering of the finest level: smooth under magnification, no better than point sampling far away."""

from swimlab.render.kernels.texture_filter import FINEST
from swimlab.render.technique import Technique, pixel_shading

TECHNIQUE = Technique(
    name="pixel-bilinear",
    summary="bilinear inputs of the finest level, shaded once a pixel",
    source="Sloan & Baker, Texture Filtering Review",
    render=pixel_shading(lambda settings: FINEST),
)
