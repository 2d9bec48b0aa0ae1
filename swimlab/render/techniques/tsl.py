"""Texture-space lighting: light the texels, filter the light, paste it.

As in the deck, each visible segment is drawn into a target of its own with atlas coordinates as positions; targets
are cleared to alpha 0, reduced by a box to a mip chain, and read with full anisotropy. Settings avoid waste: they shade
only texels that a footprint touches, at the level it needs, from moments of the maps where a texel is larger than
theirs.
"""

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
import warp as wp
from pydantic import Field, field_validator

from swimlab.render.inputs import BOX
from swimlab.render.kernels.texture_space import NEVER
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.target import Lighting, Need, Screen, everywhere, tile_level_of
from swimlab.render.technique import Picture, Technique, to_image
from swimlab.render.techniques import clean, lean, toksvig, vmf
from swimlab.render.texture import MipChain

INPUTS = {inputs.name: inputs for inputs in (BOX, toksvig.INPUTS, vmf.INPUTS, clean.INPUTS, lean.INPUTS)}
"""How the maps are filtered where a target's texel is larger than theirs."""


class TslSettings(Settings):
    """Targets, which of their texels are shaded, and how they are read."""

    size: int = Field(1024, ge=16, le=8192, description="texels along each side of a segment's target, a power of two")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis when pasting")
    inputs: Literal["box", "toksvig", "vmf", "clean", "lean"] = Field(
        "box", description="how the maps are filtered where a target's texel is larger than theirs"
    )
    texels: Literal["all", "visible", "needed"] = Field(
        "all", description="shade all texels, those under footprints, or those at the level that footprints need"
    )
    sizes: Literal["fixed", "fitted"] = Field(
        "fixed", description="all targets of `size`, or each the smallest that its segment's footprints do not magnify"
    )
    coarser: int = Field(0, ge=-4, le=4, description="levels by which fitted targets are smaller still")

    @field_validator("size")
    @classmethod
    def _power_of_two(cls, size: int) -> int:
        if size & (size - 1):
            raise ValueError(f"must be a power of two, as {1 << (size.bit_length() - 1)} or {1 << size.bit_length()}")
        return size


class Lit(NamedTuple):
    """A segment's lit target, the level each of its tiles was shaded at, and how many texels were shaded."""

    segment: int
    target: MipChain
    need: Need
    shaded: int


def lit_targets(shot: Shot, settings: TslSettings, screen: Screen) -> Iterator[Lit]:
    """Light the targets of the visible segments in turn; each is valid until the next is requested."""
    lighting = Lighting(shot, INPUTS[settings.inputs])
    for segment in screen.rows:
        size = settings.size
        need = everywhere(size, 0)
        if settings.sizes == "fitted" or settings.texels != "all":
            need = screen.need(segment, lighting.target(size).shape)
        if settings.sizes == "fitted":
            finest = int(need.min()) + settings.coarser
            size = max(16, size >> max(finest, 0))
            need = screen.need(segment, lighting.target(size).shape)
        if settings.texels == "all":
            need = everywhere(size, 0)
        elif settings.texels == "visible":
            need = np.where(need <= tile_level_of(size), 0, NEVER).astype(np.int32)
        target, shaded = lighting.light(segment, size, need)
        yield Lit(segment, target, need, shaded)


def render(shot: Shot, settings: TslSettings) -> Picture:
    """Light, reduce and paste one visible segment after another."""
    screen = Screen.of(shot, settings.anisotropy)
    picture = shot.launcher.zeros((shot.view.height, shot.view.width), wp.vec4)
    shaded = 0
    for lit in lit_targets(shot, settings, screen):
        screen.paste(lit.segment, lit.target, picture)
        shaded += lit.shaded
    return Picture(to_image(picture), shaded=shaded)


TECHNIQUE = Technique(
    name="tsl",
    summary="texture-space lighting: texels are shaded, and the light is filtered",
    source="Sloan & Baker, TSL: A case study",
    render=render,
    settings=TslSettings,
)
