"""Targets of texture-space lighting: a segment of the road drawn with atlas coordinates as positions, and lit."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import floor, log2
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Strip
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.samples import shade_samples
from swimlab.render.kernels.structs import Grid
from swimlab.render.kernels.texture_filter import ISOTROPIC, anisotropic_to
from swimlab.render.kernels.texture_space import (
    NEVER,
    keep_needed,
    mark,
    only_segment,
    reduce_needed,
    unpremultiply,
)
from swimlab.render.shot import Shot
from swimlab.render.technique import shading
from swimlab.render.texture import MipChain
from swimlab.render.triangles import in_texture, narrowest, visibility

TILE = 32
"""Side of a tile, texels of level 0."""

Need = NDArray[np.int32]


@dataclass(frozen=True)
class Screen:
    """Which pixel sees which segment.

    visible: [H, W] on the device, the triangle seen by each pixel. rows: segment in sight -> the first row that
    sees it, and one past the last.
    """

    shot: Shot
    anisotropy: int
    visible: Any
    rows: dict[int, tuple[int, int]]
    segments: Any

    @staticmethod
    def of(shot: Shot, anisotropy: int) -> "Screen":
        """Rasterise the screen once."""
        launcher = shot.launcher
        visible = visibility(launcher, shot.triangles, shot.grid(), Strip(0, shot.view.height))
        seen = visible.numpy()
        owner = np.where(seen >= 0, shot.mesh.segments[seen], np.iinfo(np.int64).min)
        rows: dict[int, tuple[int, int]] = {}
        for segment in np.unique(owner[seen >= 0]).tolist():
            seen_in = np.flatnonzero(np.any(owner == segment, axis=1))
            rows[segment] = int(seen_in[0]), int(seen_in[-1]) + 1
        segments = launcher.array(shot.mesh.segments - int(shot.mesh.segments[0]), wp.int32)
        return Screen(shot, anisotropy, visible, rows, segments)

    def need(self, segment: int, chain: Any) -> Need:
        """The finest level that pasting a segment reads of each tile of a target, [tiles, tiles]."""
        tile_level = tile_level_of(chain.width)
        strips = self._strips(segment)
        found = [self.shot.launcher.array(everywhere(chain.width, NEVER), wp.int32) for _ in strips]

        def fill(index: int) -> None:
            arguments = [*strips[index], *self._arguments(segment), chain, tile_level, found[index]]
            self.shot.launcher.launch(mark, 1, arguments)

        self.shot.launcher.each(range(len(strips)), fill)
        need = np.minimum.reduce([each.numpy() for each in found])
        # Texels larger than a triangle may miss it, so they are shaded at a finer level and reduced.
        coarsest = max(0, floor(log2(narrowest(self.shot.mesh, segment) * chain.width)))
        return np.where(need == NEVER, NEVER, np.minimum(need, coarsest)).astype(np.int32)

    def paste(self, segment: int, target: MipChain, picture: Any) -> None:
        """Fill the pixels of `picture` [H, W] that see a segment from its target: the light is the texture."""
        launcher, shot = self.shot.launcher, self.shot
        kernel = shade_samples(anisotropic_to(self.anisotropy).fill(4, launcher.device), unpremultiply, 4)
        nothing, count = launcher.empty((0, 0), wp.vec4), launcher.empty(shot.view.height, wp.int32)

        def fill(strip: Strip) -> None:
            mine = launcher.empty((strip.rows, shot.view.width), wp.int32)
            arguments = [strip.first, self._place(segment), self.visible, self.segments, mine]
            launcher.launch(only_segment, mine.shape, arguments)
            arguments = [strip.first, strip.first, 1, shot.grid(), mine, shot.triangles.planes]
            arguments += [target.texels, target.shape, shot.sun, picture, nothing, count]
            launcher.launch(kernel, strip.rows, arguments)

        launcher.each(self._strips(segment), fill)

    def _strips(self, segment: int) -> list[Strip]:
        first, last = self.rows[segment]
        return [Strip(first + strip.first, strip.rows) for strip in self.shot.launcher.strips(last - first)]

    def _arguments(self, segment: int) -> list[Any]:
        shot, place = self.shot, self._place(segment)
        return [shot.grid(), self.anisotropy, place, self.visible, self.segments, shot.triangles.planes]

    def _place(self, segment: int) -> int:
        """A segment's number as `segments` has it, small enough for a kernel at any distance."""
        return segment - int(self.shot.mesh.segments[0])


@dataclass
class Lighting:
    """Lights the targets of one frame. Targets of one size share one piece of memory, one after another."""

    shot: Shot
    inputs: Inputs
    _targets: dict[int, MipChain] = field(default_factory=dict)

    @cached_property
    def _shade(self) -> Callable[..., None]:
        return shading(self.shot, ISOTROPIC, 1, self.inputs)

    @cached_property
    def _shade_between(self) -> Callable[..., None]:
        """For texels finer than the maps': two normals blended by magnification are no roughness."""
        return shading(self.shot, ISOTROPIC, 1, BOX)

    def target(self, size: int) -> MipChain:
        """A target of size x size texels, RGBA."""
        if size not in self._targets:
            chain = MipChain.allocate(self.shot.launcher, width=size, height=size, dtype=wp.vec4, clamps=True)
            self._targets[size] = chain
        return self._targets[size]

    def light(self, segment: int, size: int, need: Need) -> tuple[MipChain, int]:
        """Clear, shade and reduce the needed tiles of a segment's target; how many texels were shaded."""
        target = self.target(size)
        target.texels.zero_()
        on_device = self.shot.launcher.array(need, wp.int32)
        shaded = sum(self._light_level(level, segment, target, need, on_device) for level in np.unique(need).tolist())
        for level in range(1, target.shape.levels):
            self._reduce(level, target, on_device)
        return target, shaded

    def _light_level(self, level: int, segment: int, target: MipChain, need: Need, on_device: Any) -> int:
        """Shade the tiles that are needed at one level."""
        if level == NEVER:
            return 0
        launcher, side = self.shot.launcher, target.shape.width >> level
        triangles = in_texture(launcher, self.shot.mesh, segment, 1 / side)
        first = int(target.shape.offsets.numpy()[level])
        texels = target.texels[first : first + side * side].reshape((side, side))
        shaded = launcher.zeros(side, wp.int32)
        nothing = launcher.empty((0, 0), wp.vec4)
        tile = min(target.shape.width, TILE) >> level
        shade = self._shade_between if side > max(self.shot.material.size) else self._shade

        def fill(strip: Strip) -> None:
            rows = slice(strip.first // tile, (strip.first + strip.rows - 1) // tile + 1)
            columns = np.flatnonzero(np.any(need[rows] == level, axis=0))
            if not columns.size:
                return
            left, right = int(columns[0]) * tile, (int(columns[-1]) + 1) * tile
            grid: Any = Grid()
            grid.origin, grid.pitch = wp.vec2d(left / side, 0.0), wp.vec2d(1 / side, 1 / side)
            grid.width, grid.height = right - left, side
            visible = visibility(launcher, triangles, grid, strip)
            if np.any(need[rows, columns[0] : columns[-1] + 1] != level):
                arguments = [strip.first, left, level, tile_level_of(target.shape.width), on_device, visible]
                launcher.launch(keep_needed, (strip.rows, right - left), arguments)
            shade(grid, triangles, visible, strip, texels[:, left:right], nothing, shaded)

        launcher.each(launcher.strips(side), fill)
        return int(shaded.numpy().sum(dtype=np.int64))

    def _reduce(self, level: int, target: MipChain, need: Any) -> None:
        launcher, side = self.shot.launcher, target.shape.width >> level
        tile_level = tile_level_of(target.shape.width)

        def fill(strip: Strip) -> None:
            arguments = [strip.first, level, tile_level, need, target.shape, target.texels]
            launcher.launch(reduce_needed, strip.rows, arguments)

        launcher.each(launcher.strips(side), fill)


def tile_level_of(size: int) -> int:
    """The level of a target at which one texel covers one tile."""
    return min(size, TILE).bit_length() - 1


def everywhere(size: int, level: int) -> Need:
    """Every tile of a target at one level."""
    tiles = max(1, size // TILE)
    return np.full((tiles, tiles), level, np.int32)
