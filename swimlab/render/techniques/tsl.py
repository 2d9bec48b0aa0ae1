"""Texture-space lighting: light the texels, filter the light, paste it.

As in the deck, each visible segment is drawn into a target of its own with atlas coordinates as positions; targets
are cleared to alpha 0, reduced by a box to a mip chain, and read with full anisotropy. Tile by tile a target is shaded
and reduced in the cache, and only levels that are read are kept. Settings avoid waste: they shade only texels that a
footprint touches, at the level it needs, from moments of the maps where a texel is larger than theirs, and keep light
from frame to frame.
"""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from swimlab.render.atlas import Ints, Layout, Pool
from swimlab.render.inputs import BOX
from swimlab.render.kernels.texture_space import NEVER
from swimlab.render.reuse import UNKNOWN, Epochs
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.target import Jobs, Lighting, Screen, Work, reduce_targets
from swimlab.render.technique import Picture, Technique, to_image
from swimlab.render.techniques import clean, lean, toksvig, vmf

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


def planned(screen: Screen, settings: TslSettings) -> Work:
    """Which tiles of which targets a picture takes."""
    layout = Layout(screen.segments, np.full(len(screen.segments), settings.size))
    read = screen.read(layout)
    if settings.sizes == "fitted":
        finest = np.array([read[layout.of(k)].min() for k in range(len(screen.segments))], np.int64)
        widths = np.maximum(16, settings.size >> np.clip(finest + settings.coarser, 0, 16))
        layout = Layout(screen.segments, widths)
        read = screen.read(layout)
    shade = read
    if settings.texels != "needed":
        shade = np.where(layout.is_tile & ((read != NEVER) | (settings.texels == "all")), 0, NEVER)
    return Work(layout, shade, read)


class Held(NamedTuple):
    """What is held of a frame's tiles, by entry.

    shade, keep: as in Work; keep of coarse levels is 0. epoch: the frame whose light it is. pose: its number in Epochs.
    start: the first texel of its block.
    """

    layout: Layout
    frame: int
    shade: Ints
    keep: Ints
    epoch: Ints
    pose: Ints
    start: Ints


NOTHING = Held(Layout((), np.zeros(0, np.int64)), 0, *[np.zeros(0, np.int64)] * 5)


class Targets:
    """A renderer that holds the light which its last frame has read, and shades what differs."""

    def __init__(self) -> None:
        self._held = NOTHING
        self._pool: Pool | None = None
        self._epochs: Epochs | None = None
        self._lightings: dict[int, Lighting] = {}

    def __call__(self, shot: Shot, settings: TslSettings) -> Picture:
        """The shot's picture; all shots of one renderer are of one sequence, under one set of settings."""
        screen = Screen.of(shot, settings.anisotropy)
        if not screen.segments:
            return Picture(np.zeros((shot.view.height, shot.view.width, 4), np.float32))
        work = planned(screen, settings)
        pool = self._pool = self._pool or Pool(shot.launcher)
        epochs = self._epochs = self._epochs or Epochs(settings.reuse, settings.tolerance)
        epochs.look(shot)
        near = range(shot.frame - settings.reuse + 1, shot.frame)
        self._lightings = {frame: old for frame, old in self._lightings.items() if frame in near}
        fresh, held = _anew(work, pool, shot.frame) if settings.reuse == 1 else self._carried(work, epochs, shot.frame)
        table = work.layout.table(shot.launcher, held.keep, held.start)
        atlas = work.layout.on(shot.launcher, table, screen.targets)
        jobs = Jobs.of(shot.launcher, Work(work.layout, np.where(fresh, work.shade, NEVER), work.keep), held.epoch)
        shaded = 0
        for epoch in np.unique(jobs.epochs).tolist():
            lighting = self._lightings.setdefault(epoch, Lighting(epochs.shot(epoch), INPUTS[settings.inputs]))
            shaded += lighting.light(jobs, atlas, pool.texels)
        reduce_targets(shot.launcher, atlas, pool.texels)
        self._held = held
        return Picture(to_image(screen.paste(atlas, pool.texels)), shaded=shaded)

    def _carried(self, work: Work, epochs: Epochs, frame: int) -> tuple[NDArray[np.bool_], Held]:
        """Which tiles are to be shaded, and what is held once they are; blocks are given back and taken for that."""
        layout, last, pool = work.layout, self._held, self._pool
        old = carried(last.layout, layout)
        before = np.full(layout.entries, UNKNOWN)
        if last.frame == frame - 1:
            known = np.flatnonzero(old >= 0)
            known = known[last.shade[old[known]] != NEVER]
            before[known] = last.epoch[old[known]]
        epoch = epochs.epochs(layout, work.shade != NEVER, before)
        pose = epochs.poses(epoch)
        keep = layout.with_coarse(work.keep)
        fits = np.flatnonzero(old >= 0)
        was = old[fits]
        same = (last.shade[was] == work.shade[fits]) & (last.pose[was] == pose[fits]) & (last.keep[was] <= keep[fits])
        same |= ~layout.is_tile[fits]
        fits, was = fits[same], was[same]
        keep[fits] = last.keep[was]
        lost = np.ones(len(last.start), bool)
        lost[was] = False
        lost &= last.keep != NEVER
        pool.give(last.start[lost], last.layout.block(last.keep)[lost])
        fresh = np.ones(layout.entries, bool)
        fresh[fits] = False
        start = pool.hold(layout, np.where(fresh, keep, NEVER))
        start[fits] = last.start[was]
        return fresh & (work.shade != NEVER), Held(layout, frame, work.shade, keep, epoch, pose, start)


def _anew(work: Work, pool: Pool, frame: int) -> tuple[NDArray[np.bool_], Held]:
    """As `_carried` where nothing is kept."""
    layout, keep = work.layout, work.layout.with_coarse(work.keep)
    pool.clear()
    epoch, pose = np.full(layout.entries, frame), np.zeros(layout.entries, np.int64)
    start = pool.hold(layout, keep)
    return work.shade != NEVER, Held(layout, frame, work.shade, keep, epoch, pose, start)


def carried(last: Layout, layout: Layout) -> Ints:
    """The entry that each entry of a layout had in another, -1 where it had none."""
    had = {key: k for k, key in enumerate(zip(last.segments, last.widths.tolist(), strict=True))}
    found = np.full(layout.entries, -1)
    for target, key in enumerate(zip(layout.segments, layout.widths.tolist(), strict=True)):
        if key in had:
            here, there = layout.of(target), last.of(had[key])
            found[here.start - 1 : here.stop] = np.arange(there.start - 1, there.stop)
    return found


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
