"""Trilinear filtering of the inputs: mip mapping by the longer derivative, then one shading."""

from typing import Any

import warp as wp

from swimlab.kernels.sampling import isotropic
from swimlab.kernels.structs import Chain, Surface
from swimlab.technique import Technique, pixel_shading


@wp.func
def mip_mapped(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
    """Two levels about log2 of the longer derivative."""
    return isotropic(texels, chain, surface)


TECHNIQUE = Technique(
    name="pixel-trilinear",
    summary="mip-mapped inputs, shaded once a pixel",
    source="Williams 1983, Pyramidal Parametrics",
    render=pixel_shading(lambda settings: mip_mapped),
)
