"""Trilinear filtering of the inputs: mip mapping by the longer derivative, then one shading."""

from swimlab.render.kernels.texture_filter import ISOTROPIC
from swimlab.render.technique import Technique, pixel_shading

TECHNIQUE = Technique(
    name="pixel-trilinear",
    summary="mip-mapped inputs, shaded once a pixel",
    source="Williams 1983, Pyramidal Parametrics",
    render=pixel_shading(lambda settings: ISOTROPIC),
)
