"""Texture-space lighting: light the texels, filter the light, paste it.

As in the deck, each visible segment is drawn into a target of its own with atlas coordinates as positions; targets
are cleared to alpha 0, reduced by a box to a mip chain, and read with full anisotropy. Tile by tile a target is shaded
and reduced in the cache, and only levels that are read are kept. Settings avoid waste: they shade only texels that a
footprint touches, at the level it needs, from moments of the maps where a texel is larger than theirs, and keep light
from frame to frame.
"""

from typing import Literal

import numpy as np
from pydantic import Field, field_validator

from swimlab.render.atlas import NO_TILES, NOTHING, Held, Pool, Tiles
from swimlab.render.inputs import BOX
from swimlab.render.kernels.placing import ALL, NEEDED, VISIBLE
from swimlab.render.reuse import Epochs
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.target import Lighting, Screen, reduce_targets
from swimlab.render.technique import Picture, Technique, to_image, total
from swimlab.render.techniques import clean, lean, toksvig, vmf

INPUTS = {inputs.name: inputs for inputs in (BOX, toksvig.INPUTS, vmf.INPUTS, clean.INPUTS, lean.INPUTS)}
"""How the maps are filtered where a target's texel is larger than theirs."""

SHADING = {"all": ALL, "visible": VISIBLE, "needed": NEEDED}


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
    reuse: int = Field(1, ge=1, le=64, description="frames after which the road's light is made anew; 1: each frame")
    tolerance: float = Field(
        0.1, ge=0, description="change of light, of its highlight's peak, up to which it is kept from frame to frame"
    )

    @field_validator("size")
    @classmethod
    def _power_of_two(cls, size: int) -> int:
        if size & (size - 1):
            raise ValueError(f"must be a power of two, as {1 << (size.bit_length() - 1)} or {1 << size.bit_length()}")
        return size


def planned(screen: Screen, settings: TslSettings) -> Tiles:
    """Which tiles of which targets a picture takes."""
    shading, sizes = SHADING[settings.texels], np.full(len(screen.shown), settings.size, np.int32)
    tiles = screen.read(sizes, shading)
    if settings.sizes == "fixed":
        return tiles
    return screen.read(np.maximum(16, sizes >> np.clip(tiles.finest + settings.coarser, 0, 16)), shading)


class Targets:
    """A renderer that holds the light which its last frame has read, and shades what differs."""

    def __init__(self) -> None:
        self._held = NOTHING
        self._pool: Pool | None = None
        self._epochs: Epochs | None = None
        self._lightings: dict[int, Lighting] = {}

    def __call__(self, shot: Shot, settings: TslSettings) -> Picture:
        """The shot's picture; all shots of one renderer are of one sequence, under one set of settings."""
        screen, inputs, launcher = Screen.of(shot, settings.anisotropy), INPUTS[settings.inputs], shot.launcher
        if len(screen.shown) == 0:
            return Picture(np.zeros((shot.view.height, shot.view.width, 4), np.float32))
        tiles = planned(screen, settings)
        pool = self._pool = self._pool or Pool(launcher)
        epochs = self._epochs = self._epochs or Epochs(settings.reuse, settings.tolerance)
        epochs.look(shot)
        near = range(epochs.oldest, shot.frame)
        self._lightings = {frame: old for frame, old in self._lightings.items() if frame in near}
        self._lightings[shot.frame] = Lighting(shot, inputs)
        # Until this frame is done nothing is known of what is held.
        held, self._held = self._held if settings.reuse > 1 else NOTHING, NOTHING
        epochs.find(tiles, held.tiles if held.frame == shot.frame - 1 else NO_TILES)
        jobs = pool.place(tiles, epochs.poses, epochs.oldest, held.tiles)
        shaded = []
        for frame in jobs.frames:
            if frame not in self._lightings:
                self._lightings[frame] = Lighting(epochs.shot(frame), inputs)
            shaded += self._lightings[frame].light(jobs, tiles.atlas, pool.texels)
        reduce_targets(launcher, tiles.atlas, pool.texels)
        self._held = Held(shot.frame, tiles)
        picture = to_image(screen.paste(tiles.atlas, pool.texels))
        return Picture(picture, shaded=sum(map(total, shaded)))


def render(shot: Shot, settings: TslSettings) -> Picture:
    """One frame by itself."""
    return Targets()(shot, settings)


TECHNIQUE = Technique(
    name="tsl",
    summary="texture-space lighting: texels are shaded, and the light is filtered",
    source="Sloan & Baker, TSL: A case study",
    render=render,
    settings=TslSettings,
    memory=Targets,
)
