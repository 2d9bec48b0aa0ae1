"""Anisotropic filtering of the inputs: what an engine does. Averaged normals lie flat, and a false mirror appears."""

import warp as wp
from pydantic import Field

from swimlab.kernels.sampling import anisotropic
from swimlab.kernels.structs import Chain, Surface, Texel
from swimlab.technique import Settings, Technique, pixel_shading


class PixelAnisoSettings(Settings):
    """How far a footprint may be stretched."""

    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


def texture_filter(settings: PixelAnisoSettings) -> wp.Function:
    """The filter with up to `anisotropy` trilinear probes."""
    most = settings.anisotropy

    @wp.func(module="unique")
    def stretched(texels: wp.array(dtype=Texel), chain: Chain, surface: Surface) -> Texel:
        return anisotropic(texels, chain, surface, most)

    return stretched


TECHNIQUE = Technique(
    name="pixel-aniso",
    summary="anisotropically filtered inputs, shaded once a pixel",
    source="EXT_texture_filter_anisotropic; Heckbert 1989, Fundamentals of Texture Mapping",
    render=pixel_shading(texture_filter),
    settings=PixelAnisoSettings,
)
