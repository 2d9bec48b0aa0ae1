"""Anisotropic filtering of the inputs, as engines do. Averaged normals lie flat, and a false mirror appears."""

from dataclasses import replace

from pydantic import Field

from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, pixel_shading


class PixelAnisoSettings(Settings):
    """How far a footprint may be stretched, and which triangles are too thin to be drawn."""

    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")
    thinnest: float = Field(0.0, ge=0, le=64, description="px: wires' triangles of a lesser altitude are not drawn")


shade = pixel_shading(lambda settings: anisotropic_to(settings.anisotropy))


def render(shot: Shot, settings: PixelAnisoSettings) -> Picture:
    """Filter and shade once a pixel; slivers under `thinnest` are left out, which keeps them from aliasing."""
    return shade(replace(shot, thinnest=settings.thinnest) if settings.thinnest > 0 else shot, settings)


TECHNIQUE = Technique(
    name="pixel-aniso",
    summary="anisotropically filtered inputs, shaded once a pixel",
    source="EXT_texture_filter_anisotropic; Heckbert 1989, Fundamentals of Texture Mapping",
    render=render,
    settings=PixelAnisoSettings,
)
