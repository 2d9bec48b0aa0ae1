"""The level-of-detail hack: as pixel-aniso, with normals pulled to flat as the footprint grows.

The deck: "This will prevent aliasing, but isn't accurate".
"""

from typing import Any, Self

import warp as wp
from pydantic import Field, model_validator

from swimlab.render.kernels.footprint import isotropic_level
from swimlab.render.kernels.sampling import anisotropic
from swimlab.render.kernels.structs import Chain, Surface
from swimlab.render.kernels.texture_filter import TextureFilter
from swimlab.render.settings import Settings
from swimlab.render.technique import Technique, pixel_shading


class LodHackSettings(Settings):
    """Where the fade begins and ends, as trilinear levels of detail."""

    start: float = Field(0.0, ge=-16, le=16, description="level up to which normals are untouched")
    end: float = Field(4.0, ge=-16, le=16, description="level from which normals are flat")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.end <= self.start:
            raise ValueError(f"the fade must end after it starts: end {self.end} is not above start {self.start}")
        return self


def texture_filter(settings: LodHackSettings) -> wp.Function:
    """The filter: n.xy of the filtered normal times clamp((end - lod) / (end - start), 0, 1)."""
    most = settings.anisotropy
    start = settings.start
    end = settings.end

    @wp.func(module="unique")
    def flattened(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
        texel = anisotropic(texels, chain, surface, most)
        keep = wp.clamp((end - wp.float32(isotropic_level(surface, chain))) / (end - start), 0.0, 1.0)
        texel[3] = texel[3] * keep
        texel[4] = texel[4] * keep
        return texel

    return flattened


TECHNIQUE = Technique(
    name="lod-hack",
    summary="pixel-aniso with normals faded to flat as the footprint grows",
    source="Sloan & Baker, A common hack: Level of Detail",
    render=pixel_shading(lambda settings: TextureFilter(texture_filter(settings))),
    settings=LodHackSettings,
)
