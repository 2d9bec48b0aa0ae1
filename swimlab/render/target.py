"""Targets of texture-space lighting: a segment of the road drawn with atlas coordinates as positions, and lit."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.atlas import Ints, Jobs, Layout, Tiles
from swimlab.render.charts import Charts, Drawn, charts_of
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.placing import ALIGNED, BETWEEN, WAYS, part_jobs
from swimlab.render.kernels.target_filter import aligned, paged
from swimlab.render.kernels.texture_filter import ISOTROPIC
from swimlab.render.kernels.texture_space import NEVER, mark_with, marking, paste_with, see_charts
from swimlab.render.kernels.tiles import light_tiles, reduce_coarse
from swimlab.render.shot import Shot
from swimlab.render.technique import on_host
from swimlab.render.texture import MipChain


@dataclass(frozen=True)
class Screen:
    """Which pixel sees which chart.

    visible: [H, W] on the device, the triangle seen by each pixel. shown: [n], places among the charts of those in
    sight. targets: on the device, the place among `shown` of each chart, or -1.
    """

    shot: Shot
    charts: Charts
    anisotropy: int
    grid: Any
    visible: Any
    shown: NDArray[np.int64]
    targets: Any

    @staticmethod
    def of(shot: Shot, anisotropy: int) -> "Screen":
        """Rasterise the screen once."""
        launcher, height, width = shot.launcher, shot.view.height, shot.view.width
        charts, triangles, grid = charts_of(shot), shot.triangles, shot.grid()
        visible, seen = launcher.empty((height, width), wp.int32), launcher.zeros(len(charts.segments), wp.int32)
        inputs = [grid, triangles.edges, triangles.planes, triangles.bounds, charts.owners, visible, seen]
        launcher.over(height, see_charts, (), inputs)
        shown = np.flatnonzero(on_host(seen))
        targets = np.full(len(charts.segments), -1, np.int32)
        targets[shown] = np.arange(len(shown))
        return Screen(shot, charts, anisotropy, grid, visible, shown, launcher.view(targets, wp.int32))

    @property
    def segments(self) -> NDArray[np.int64]:
        """Numbers of the charts in sight, rising."""
        return self.charts.segments[self.shown]

    def read(self, widths: Ints, shading: int) -> Tiles:
        """What pasting reads of each tile, and which are shaded (see `choose_levels`). widths: of targets, texels."""
        launcher, shot, layout = self.shot.launcher, self.shot, Layout(self.segments, widths)
        need = launcher.filled(layout.entries, wp.int32, NEVER)
        atlas = layout.on(launcher, self.charts.owners, self.targets)
        kernel = mark_with(marking(self.anisotropy).on(launcher.device))
        inputs = [self.grid, self.visible, shot.triangles.planes, atlas, need]
        launcher.over(shot.view.height, kernel, (), inputs)
        # Texels larger than a triangle may miss it, so they are shaded at a finer level and reduced.
        texels = self.charts.narrowest[self.shown] * widths
        coarsest = np.maximum(np.frexp(texels)[1] - 1, 0).astype(np.int32)
        return Tiles.read(launcher, layout, atlas, on_host(need), coarsest, shading)

    def paste(self, atlas: Any, texels: Any) -> Any:
        """The picture [H, W] on the device: the light is the texture."""
        launcher, shot = self.shot.launcher, self.shot
        picture = launcher.empty((shot.view.height, shot.view.width), wp.vec4)
        kernel = paste_with(paged(self.anisotropy).on(launcher.device))
        inputs = [self.grid, self.visible, shot.triangles.planes, atlas, texels, shot.sun, picture]
        launcher.over(shot.view.height, kernel, (), inputs)
        return picture


class Lighting:
    """Lights tiles as a frame's eye sees them, under that frame's sun."""

    def __init__(self, shot: Shot, inputs: Inputs) -> None:
        self.shot, self.inputs, self._charts = shot, shot.inputs(inputs), charts_of(shot)

    def light(self, jobs: Jobs, atlas: Any, texels: Any) -> list[Any]:
        """Light the jobs of this frame where the atlas says, but coarse levels; texels shaded by each, on device."""
        launcher, drawn = self.shot.launcher, self._charts.drawn(jobs.layout)
        shaded = []
        for mine, (kernel, chain) in self._ways(jobs.layout, jobs.as_in(self.shot.frame), drawn):
            shaded.append(launcher.empty(len(mine), wp.int32))
            inputs = [launcher.view(mine, wp.int32), jobs.tiles, jobs.kept, atlas, drawn.ranges]
            inputs += [drawn.triangles.edges, drawn.triangles.planes]
            inputs += [chain.texels, chain.shape, self.shot.sun, texels, shaded[-1]]
            launcher.over(len(mine), kernel, (), inputs)
        return shaded

    def _ways(self, layout: Layout, jobs: Ints, drawn: Drawn) -> "list[tuple[Ints, Way]]":
        """Jobs by the way in which they are lit, that is how their texels lie on those of the maps."""
        size = self.shot.material.size
        parted, ranges = np.empty_like(jobs), np.empty(WAYS + 1, np.int32)
        inputs = [jobs, layout.shapes, drawn.widened, max(size), size[0] == size[1], parted, ranges]
        self.shot.launcher.launch_on_host(part_jobs, inputs)
        parts = {way: parted[slice(*ranges[way : way + 2])] for way in range(WAYS)}
        return [(part, self._way(way)) for way, part in parts.items() if len(part)]

    def _way(self, way: int) -> "Way":
        if way == ALIGNED:
            return self._aligned()
        return self._filtered(BOX if way == BETWEEN else self.inputs)

    def _aligned(self) -> "Way":
        chain = self.shot.material.resolved(self.inputs)
        fill = aligned(chain.floats).on(self.shot.launcher.device)
        return Way(light_tiles(fill, self.shot.shade_packet(self.inputs, chain.floats), chain.floats), chain)

    def _filtered(self, inputs: Inputs) -> "Way":
        chain = self.shot.material.chain(inputs)
        device = self.shot.launcher.device
        fill = inputs.after(ISOTROPIC.fill(chain.floats, device), chain.floats, device)
        return Way(light_tiles(fill, self.shot.shade_packet(inputs, chain.floats), chain.floats), chain)


class Way(NamedTuple):
    """The kernel that lights jobs, and the chain that it reads."""

    kernel: wp.Kernel
    chain: MipChain


def reduce_targets(launcher: Launcher, atlas: Any, texels: Any) -> None:
    """Fill the coarse levels of all targets from their tiles."""
    launcher.launch(reduce_coarse, len(atlas.shapes), [0, atlas, texels])
