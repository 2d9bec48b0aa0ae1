"""Texture-space lighting: light the texels, filter the light, paste it.

As in the deck, each visible segment is drawn into a target of its own with atlas coordinates as positions; targets
are cleared to alpha 0, reduced by a box to a mip chain, and read with full anisotropy. Tile by tile a target is shaded
and reduced in the cache, and only levels that are read are kept. Settings avoid waste: they shade only texels that a
footprint touches, at the level it needs, from moments of the maps where a texel is larger than theirs, and keep light
from frame to frame.
"""

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from metrics.kernels.launch import Launcher
from swimlab.render.atlas import Held, Pool, Shelf, Tiles
from swimlab.render.charts import charts_of
from swimlab.render.inputs import BOX
from swimlab.render.kernels.choosing import ALL, LEAST_WIDTH, NEEDED, VISIBLE
from swimlab.render.kernels.tile_table import TILE_LEVEL
from swimlab.render.layout import equal_widths
from swimlab.render.reuse import Epochs
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.target import Before, Lighting, Relighting, Screen, Ways, lay_out_nothing, pasting
from swimlab.render.technique import Picture, Render, Technique, to_image
from swimlab.render.techniques import clean, lean, toksvig, vmf

INPUTS = {inputs.name: inputs for inputs in (BOX, toksvig.INPUTS, vmf.INPUTS, clean.INPUTS, lean.INPUTS)}
"""How the maps are filtered where a target's texel is larger than theirs."""

SHADING = {"all": ALL, "visible": VISIBLE, "needed": NEEDED}

MOST_TILES = 1 << 16
"""Tiles of all targets, unless more are in sight: all charts have one, or those that come and go keep theirs. Each
takes some hundred bytes."""


class TslSettings(Settings):
    """Targets, which of their texels are shaded, and how they are read."""

    size: int = Field(
        1024, ge=LEAST_WIDTH, le=8192, description="texels along each side of a segment's target, a power of two"
    )
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


class Plan:
    """Which tiles of which targets pictures take, frame after frame. screen: what sees them."""

    def __init__(self, launcher: Launcher, settings: TslSettings, most: int = 0) -> None:
        """most: targets, unless more are in sight."""
        self.screen = Screen(launcher, settings.anisotropy, SHADING[settings.texels], most)
        self._settings, self._whole, self._fitted = settings, Shelf(launcher), Shelf(launcher)

    def tiles(self, shot: Shot, before: Before = lay_out_nothing) -> Tiles:
        """The tiles of a frame, marked. before: not called where there are none; of fitted targets with these alone."""
        screen, take = self.screen, partial(self._take, self._whole)
        if self._settings.sizes == "fixed":
            return screen.see(shot, take, before)
        rest = None

        def before_whole(whole: Tiles) -> None:
            nonlocal rest
            rest = self._fitting(shot, whole, before)

        whole = screen.see(shot, take, before_whole)
        return whole if rest is None or screen.in_sight == 0 else rest()

    def _take(self, shelf: Shelf, segments: NDArray[np.int64]) -> Tiles:
        return shelf.take(segments, equal_widths(len(segments), self._settings.size))

    def _fitting(self, shot: Shot, whole: Tiles, before: Before) -> Callable[[], Tiles]:
        """What fits targets, and marks their tiles, when those of whole ones are marked."""
        tiles = self._take(self._fitted, whole.segments)
        fit = tiles.fitting(whole, self._settings.coarser)
        # Triangles of charts that may be widened are not known before all targets are.
        mark = self.screen.marking(tiles, before) if charts_of(shot).are_wide else None

        def fitted() -> Tiles:
            fit()
            (mark or self.screen.marking(tiles, before))()
            return tiles

        return fitted


def planned_alone(shot: Shot, settings: TslSettings) -> tuple[Screen, Tiles]:
    """A screen that has seen one frame, and the tiles that its picture takes."""
    plan = Plan(shot.launcher, settings)
    return plan.screen, plan.tiles(shot)


class Targets:
    """What holds the light that the last frame has read, and lights what differs.

    All shots are of one sequence, under one set of settings.
    """

    def __init__(self, shot: Shot, settings: TslSettings) -> None:
        """Any of the shots."""
        launcher = shot.launcher
        self._settings, self._plan = settings, Plan(launcher, settings, most_targets(settings))
        self._pool, self._ways = Pool(launcher), Ways(shot, INPUTS[settings.inputs])
        self._epochs = Epochs(settings.reuse, settings.tolerance)
        self._held = self._nothing = Held.nothing(launcher)
        self._done: int | None = None  # the frame whose light is held
        self._usual: list[int] = []  # ways in which the last frame's light was made

    def frame(self, shot: Shot) -> Picture:
        """The shot's picture."""
        last, self._done = self._done, None  # of which nothing is known if a frame fails
        self._epochs.look(shot)
        if self._epochs.differ:
            if last is None or not self._epochs.oldest <= last < shot.frame:
                self._held, last = self._nothing, self._epochs.oldest - 1
            for frame in range(last + 1, shot.frame):
                self._epochs.look(shot.at(frame))
                self._light(shot.at(frame), paints=False)
            self._epochs.look(shot)
        picture = self._light(shot, paints=True)
        self._done = shot.frame
        return picture or Picture(np.zeros((shot.view.height, shot.view.width, 4), np.float32))

    def _light(self, shot: Shot, *, paints: bool) -> Picture | None:
        """Light what a shot reads; the picture, if it `paints` one and anything is in sight."""
        # What can be is done before the first kernel, as kernels empty the caches.
        light: Callable[[], Picture | None] | None = None

        def before(tiles: Tiles) -> None:
            nonlocal light
            light = self._laid_out(shot, tiles, paints=paints)

        self._plan.tiles(shot, before)
        if light is None or self._plan.screen.in_sight == 0:
            self._held = self._nothing
            return None
        return light()

    def _laid_out(self, shot: Shot, tiles: Tiles, *, paints: bool) -> Callable[[], Picture | None]:
        """What lights tiles once they are marked, and makes the picture if any. It may be that it is not run."""
        screen, epochs, pool, held = self._plan.screen, self._epochs, self._pool, self._held
        find, lighting = epochs.finding(tiles, held), Lighting(shot, self._ways)
        place = pool.placing(tiles, lighting.light(tiles, epochs.numbers), held)
        relight = Relighting(tiles, pool.texels, lighting, self._usual)
        paste = pasting(screen, tiles, pool.texels) if paints else None

        def light() -> Picture | None:
            nonlocal relight, paste
            # Until this is done nothing is known of what is held.
            self._held = self._nothing
            find()
            jobs = place()
            if pool.texels is not relight.texels:
                relight = Relighting(tiles, pool.texels, lighting)
                paste = pasting(screen, tiles, pool.texels) if paints else None
            relight(jobs)
            self._usual = [*jobs.by_way]
            if self._settings.reuse > 1:
                self._held = tiles.hold()
            return paste and Picture(to_image(paste()), shaded=tiles.shaded(jobs))

        return light


def most_targets(settings: TslSettings) -> int:
    """How many targets there are, unless more are in sight: MOST_TILES in all."""
    return MOST_TILES >> max(0, 2 * (settings.size.bit_length() - 1 - TILE_LEVEL))


def remembering() -> Render:
    """A renderer that keeps what the next frame needs (see Targets)."""
    kept: list[Targets] = []

    def frame(shot: Shot, settings: TslSettings) -> Picture:
        if not kept:
            kept.append(Targets(shot, settings))
        return kept[0].frame(shot)

    return frame


def render(shot: Shot, settings: TslSettings) -> Picture:
    """One frame by itself, after those whose light it may keep."""
    return Targets(shot, settings).frame(shot)


TECHNIQUE = Technique(
    name="tsl",
    summary="texture-space lighting: texels are shaded, and the light is filtered",
    source="Sloan & Baker, TSL: A case study",
    render=render,
    settings=TslSettings,
    memory=remembering,
)
