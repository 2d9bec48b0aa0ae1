"""Techniques that filter moments of the normals, and shade once: non-linear mip chains."""

from pydantic import Field

from swimlab.render.inputs import Inputs
from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, render_samples


class MomentSettings(Settings):
    """How far a footprint may be stretched."""

    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


def moment_technique(inputs: Inputs, *, summary: str, source: str) -> Technique:
    """The technique of some inputs: they are read anisotropically at the pixel's centre and shaded once."""

    def render(shot: Shot, settings: MomentSettings) -> Picture:
        return render_samples(shot, anisotropic_to(settings.anisotropy), n=1, inputs=inputs)

    return Technique(name=inputs.name, summary=summary, source=source, render=render, settings=MomentSettings)
