"""The level-of-detail hack: as pixel-aniso, with normals pulled to flat as the footprint grows.

The deck: "This will prevent aliasing, but isn't accurate".
"""

from typing import Any, Self

import warp as wp
from pydantic import Field, model_validator

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.footprint import isotropic_level
from swimlab.render.kernels.sampling import anisotropic
from swimlab.render.kernels.structs import Chain, Surface
from swimlab.render.kernels.texture_filter import AGREES, Beside, TextureFilter, stretched
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


@made_once
def flattened(start: float, end: float, most: int) -> wp.Function:
    """The filter: n.xy of the filtered normal times clamp((end - lod) / (end - start), 0, 1)."""

    @wp.func(module="unique")
    def faded(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
        texel = anisotropic(texels, chain, surface, most)
        keep = wp.clamp((end - wp.float32(isotropic_level(surface, chain))) / (end - start), 0.0, 1.0)
        texel[3] = texel[3] * keep
        texel[4] = texel[4] * keep
        return texel

    return faded


@form(cases=[(8, 0.0, 4.0, 16), (10, 1.0, 2.5, 3)], agrees=AGREES)
def flattened_texels(width: int, start: float, end: float, most: int) -> Twins:
    """`flattened` over the lanes of a packet, of texels of `width` floats."""
    fade = f"""
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {{
        const double xx = q[2*LANES + k]*W, xy = q[3*LANES + k]*H, yx = q[4*LANES + k]*W, yy = q[5*LANES + k]*H;
        const double a = __builtin_sqrt(xx*xx + xy*xy), b = __builtin_sqrt(yx*yx + yy*yy);
        const float left = ({end!r}f - log2_of((float)(a > b ? a : b)))/({end!r}f - {start!r}f);
        const float keep = left > 0.0f ? (left < 1.0f ? left : 1.0f) : 0.0f;
        out[3*LANES + k] *= keep; out[4*LANES + k] *= keep;
    }}
"""
    return stretched(flattened(start, end, most), width, most, Beside(after=fade))


def texture_filter(settings: LodHackSettings) -> TextureFilter:
    """The filter of some settings."""
    chosen = settings.start, settings.end, settings.anisotropy
    return TextureFilter(flattened(*chosen), lambda width: flattened_texels(width, *chosen))


TECHNIQUE = Technique(
    name="lod-hack",
    summary="pixel-aniso with normals faded to flat as the footprint grows",
    source="Sloan & Baker, A common hack: Level of Detail",
    render=pixel_shading(texture_filter),
    settings=LodHackSettings,
)
