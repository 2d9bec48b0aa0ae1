"""Targets of texture-space lighting: a segment of the road drawn with atlas coordinates as positions, and lit."""

from dataclasses import dataclass
from math import floor, log2
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.atlas import Ints, Layout
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.target_filter import aligned, paged
from swimlab.render.kernels.texture_filter import ISOTROPIC
from swimlab.render.kernels.texture_space import NEVER, mark_with, marking, paste_with, see_scene
from swimlab.render.kernels.tiles import TILE_LEVEL, light_tiles, reduce_coarse
from swimlab.render.shot import Shot
from swimlab.render.texture import MipChain
from swimlab.render.triangles import Charts, in_texture, narrowest


@dataclass(frozen=True)
class Screen:
    """Which pixel sees which segment.

    visible: [H, W] on the device, the triangle seen by each pixel. segments: those in sight, in order. targets: on the
    device, of each triangle the place of its segment among these, or -1.
    """

    shot: Shot
    anisotropy: int
    visible: Any
    segments: tuple[int, ...]
    targets: Any

    @staticmethod
    def of(shot: Shot, anisotropy: int) -> "Screen":
        """Rasterise the screen once."""
        launcher, height, width = shot.launcher, shot.view.height, shot.view.width
        visible, owner, triangles = launcher.empty((height, width), wp.int32), shot.mesh.segments, shot.triangles
        seen = launcher.zeros(len(owner), wp.int32)
        inputs = [shot.grid(), triangles.edges, triangles.planes, triangles.bounds, visible, seen]
        launcher.over(height, see_scene, (), inputs)
        segments = np.unique(owner[seen.numpy() > 0])
        place = np.searchsorted(segments, owner)
        found = place < len(segments)
        found[found] = segments[place[found]] == owner[found]
        targets = launcher.view(np.where(found, place, -1).astype(np.int32), wp.int32)
        return Screen(shot, anisotropy, visible, tuple(segments.tolist()), targets)

    def read(self, layout: Layout) -> Ints:
        """The finest level that pasting reads of each tile, [entries]; NEVER where it reads nothing."""
        launcher, shot = self.shot.launcher, self.shot
        atlas = layout.on(launcher, launcher.empty(0, wp.int32), self.targets)
        kernel = mark_with(marking(self.anisotropy).on(launcher.device))
        needs: list[Any] = []

        def another(_: int) -> list[Any]:
            needs.append(launcher.filled(layout.entries, wp.int32, NEVER))
            return needs[-1:]

        inputs = [shot.grid(), self.visible, shot.triangles.planes, atlas]
        launcher.over(shot.view.height, kernel, (), inputs, own=another)
        found = np.min([need.numpy() for need in needs], axis=0).astype(np.int64)
        # Texels larger than a triangle may miss it, so they are shaded at a finer level and reduced.
        texels = narrowest(shot.mesh, layout.segments) * layout.widths
        coarsest = np.array([max(0, floor(log2(extent))) for extent in texels.tolist()], np.int64)
        return np.where(found == NEVER, NEVER, np.minimum(found, coarsest[layout.owners]))

    def paste(self, atlas: Any, texels: Any) -> Any:
        """The picture [H, W] on the device: the light is the texture."""
        launcher, shot = self.shot.launcher, self.shot
        picture = launcher.empty((shot.view.height, shot.view.width), wp.vec4)
        kernel = paste_with(paged(self.anisotropy).on(launcher.device))
        inputs = [shot.grid(), self.visible, shot.triangles.planes, atlas, texels, shot.sun, picture]
        launcher.over(shot.view.height, kernel, (), inputs)
        return picture


@dataclass(frozen=True)
class Work:
    """Tiles to be lit, by entry: `shade` and `keep`, the levels to shade at and the finest to keep, NEVER for none."""

    layout: Layout
    shade: Ints
    keep: Ints


class Jobs(NamedTuple):
    """What `light_tiles` is given of some tiles, each lit as in some frame (see `swimlab.render.kernels.tiles`).

    rows: [n, 4]. epochs: [n], the frame of each job. tiles, keep: on the device.
    """

    layout: Layout
    rows: NDArray[np.int32]
    epochs: Ints
    tiles: Any
    keep: Any

    @staticmethod
    def of(launcher: Launcher, work: Work, epochs: Ints) -> "Jobs":
        """The jobs of all tiles that are to be shaded. epochs: by entry."""
        layout = work.layout
        tiles = np.flatnonzero(work.shade != NEVER)
        group = ((epochs[tiles] - epochs.min()) * len(layout.segments) + layout.owners[tiles]) * (NEVER + 1)
        group += work.shade[tiles]
        order = np.argsort(group, kind="stable")
        tiles, group = tiles[order], group[order]
        begins = np.flatnonzero(np.diff(group, prepend=-1))
        place = np.arange(len(tiles)) - np.repeat(begins, np.diff(begins, append=len(tiles)))
        target, level = layout.owners[tiles], work.shade[tiles]
        together = 4 ** (TILE_LEVEL - layout.tile_levels[target] + level)
        first = np.flatnonzero(place % together == 0)
        rows = np.stack([target[first], level[first], first, np.diff(first, append=len(tiles))], axis=1)
        on_device = (launcher.view(each.astype(np.int32), wp.int32) for each in (tiles, work.keep[tiles]))
        return Jobs(layout, rows.astype(np.int32), epochs[tiles[first]], *on_device)


class Lighting:
    """Lights tiles as a frame's eye sees them, under that frame's sun."""

    def __init__(self, shot: Shot, inputs: Inputs) -> None:
        self.shot, self.inputs = shot, shot.inputs(inputs)
        self._charts: tuple[Layout, Charts] | None = None

    def light(self, jobs: Jobs, atlas: Any, texels: Any) -> int:
        """Light the jobs of this frame where the atlas says, but coarse levels; how many texels were shaded."""
        launcher, charts = self.shot.launcher, self._charts_of(jobs.layout)
        rows = jobs.rows[jobs.epochs == self.shot.frame]
        ranges = launcher.view(charts.ranges, wp.vec2i)
        shaded = 0
        for way in self._ways(jobs.layout, rows, charts):
            mine = launcher.view(rows[way.jobs], wp.int32)
            lit = launcher.empty(len(mine), wp.int32)
            inputs = [mine, jobs.tiles, jobs.keep, atlas, ranges, charts.triangles.edges, charts.triangles.planes]
            inputs += [way.chain.texels, way.chain.shape, self.shot.sun, texels, lit]
            launcher.over(len(mine), way.kernel, (), inputs)
            shaded += int(lit.numpy().sum(dtype=np.int64))
        return shaded

    def _charts_of(self, layout: Layout) -> Charts:
        """All segments of a layout in texture space."""
        if self._charts is None or not self._charts[0].is_same(layout):
            charts = in_texture(self.shot.launcher, self.shot.mesh, layout.segments, 1 / layout.widths)
            self._charts = layout, charts
        return self._charts[1]

    def _ways(self, layout: Layout, rows: NDArray[np.int32], charts: Charts) -> "list[Way]":
        """The ways that jobs are lit in, by how their texels lie on those of the maps."""
        size = self.shot.material.size
        # Between texels of the maps two normals that are blended by magnification are no roughness.
        between = layout.widths[rows[:, 0]] >> rows[:, 1] > max(size)
        same = ~between & (size[0] == size[1]) & ~charts.widened[rows[:, 0]]
        ways = [(same, self._aligned), (between, lambda: self._filtered(BOX)), (~between & ~same, self._filtered)]
        return [Way(chosen, *make()) for chosen, make in ways if chosen.any()]

    def _aligned(self) -> tuple[wp.Kernel, MipChain]:
        chain = self.shot.material.resolved(self.inputs)
        fill = aligned(chain.floats).on(self.shot.launcher.device)
        return light_tiles(fill, self.shot.shade_packet(self.inputs, chain.floats), chain.floats), chain

    def _filtered(self, inputs: Inputs | None = None) -> tuple[wp.Kernel, MipChain]:
        inputs = inputs or self.inputs
        chain = self.shot.material.chain(inputs)
        device = self.shot.launcher.device
        fill = inputs.after(ISOTROPIC.fill(chain.floats, device), chain.floats, device)
        return light_tiles(fill, self.shot.shade_packet(inputs, chain.floats), chain.floats), chain


class Way(NamedTuple):
    """Jobs that are lit by one kernel from one chain."""

    jobs: NDArray[np.bool_]
    kernel: wp.Kernel
    chain: MipChain


def reduce_targets(launcher: Launcher, atlas: Any, texels: Any) -> None:
    """Fill the coarse levels of all targets from their tiles."""
    launcher.over(len(atlas.shapes), reduce_coarse, (), [atlas, texels])
