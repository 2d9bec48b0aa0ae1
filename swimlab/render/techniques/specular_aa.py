"""Specular anti-aliasing: the highlight is widened by how fast the filtered normal turns from pixel to pixel.

It is by the mapped normal: the geometric one of a flat road does not turn at all.
"""

import functools
from typing import Any

import warp as wp
from pydantic import Field

from swimlab.render.kernels.sampling import anisotropic
from swimlab.render.kernels.structs import Chain, Surface
from swimlab.render.kernels.texture_filter import TextureFilter
from swimlab.render.settings import Settings
from swimlab.render.technique import Technique, pixel_shading


class SpecularAaSettings(Settings):
    """By how much the highlight is widened."""

    variance: float = Field(0.15, ge=0, le=1, description="variance of the pixel's filter, px^2")
    threshold: float = Field(0.2, ge=0, le=1, description="most that is added to the squared roughness")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


@wp.func
def shifted(surface: Surface, by: wp.vec2d) -> Surface:
    """The same surface at another uv."""
    moved = surface
    moved.uv = surface.uv + by
    return moved


@wp.func
def normal_of(texel: Any) -> wp.vec3:
    """The unit normal."""
    return wp.normalize(wp.vec3(texel[3], texel[4], texel[5]))


@functools.cache
def widened(variance: float, threshold: float, most: int) -> wp.Function:
    """a^2' = min(1, a^2 + min(2 variance (|dN/dx|^2 + |dN/dy|^2), threshold)) with a^2 = 2/(power + 2)."""

    @wp.func(module="unique")
    def antialiased(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
        texel = anisotropic(texels, chain, surface, most)
        here = normal_of(texel)
        across = normal_of(anisotropic(texels, chain, shifted(surface, surface.dx), most)) - here
        down = normal_of(anisotropic(texels, chain, shifted(surface, surface.dy), most)) - here
        turn = wp.length_sq(across) + wp.length_sq(down)
        squared = 2.0 / (texel[7] + 2.0) + wp.min(2.0 * variance * turn, threshold)
        texel[7] = 2.0 / wp.min(squared, 1.0) - 2.0
        return texel

    return antialiased


TECHNIQUE = Technique(
    name="specular-aa",
    summary="aniso inputs, highlight widened by the normal's screen derivatives",
    source="Tokuyoshi & Kaplanyan 2019, Improved Geometric Specular Antialiasing; constants of Filament",
    render=pixel_shading(
        lambda settings: TextureFilter(widened(settings.variance, settings.threshold, settings.anisotropy))
    ),
    settings=SpecularAaSettings,
)
