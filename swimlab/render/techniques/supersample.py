"""Brute force: pixel-aniso on a finer grid, averaged. It converges to the reference, slowly."""

from math import isqrt

from pydantic import Field, field_validator

from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, render_samples


class SupersampleSettings(Settings):
    """How many samples make a pixel, and how each is filtered."""

    samples: int = Field(4, ge=1, le=1024, description="samples a pixel, a square number; footprints shrink with them")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along a sample's footprint")

    @field_validator("samples")
    @classmethod
    def _square(cls, samples: int) -> int:
        root = isqrt(samples)
        if root * root != samples:
            raise ValueError(f"must be a square number, as {root**2} or {(root + 1) ** 2}")
        return samples


def render(shot: Shot, settings: SupersampleSettings) -> Picture:
    """A regular grid of samples; a footprint is a cell of it."""
    inputs = anisotropic_to(settings.anisotropy)
    picture = render_samples(shot, inputs, n=isqrt(settings.samples))
    return picture._replace(error=None)


TECHNIQUE = Technique(
    name="supersample",
    summary="pixel-aniso, several samples a pixel",
    source="Whitted 1980, An Improved Illumination Model for Shaded Display",
    render=render,
    settings=SupersampleSettings,
)
