"""Targets of texture-space lighting: a segment of the road drawn with atlas coordinates as positions, and lit."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.atlas import Jobs, Tiles
from swimlab.render.charts import Charts, charts_of
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.placing import ALIGNED, BETWEEN, WAYS, part_jobs
from swimlab.render.kernels.target_filter import aligned, paged
from swimlab.render.kernels.texture_filter import ISOTROPIC
from swimlab.render.kernels.texture_space import NEVER, marking, paste_with, read_with
from swimlab.render.kernels.tiles import light_tiles, reduce_coarse
from swimlab.render.layout import placed
from swimlab.render.shot import Shot
from swimlab.render.texture import MipChain


class Screen:
    """Which pixel sees which chart, frame after frame; its arrays serve all frames with as many pixels and charts.

    shot: the frame. grid, visible: on the device; visible, [H, W], is the triangle seen by each pixel. shown: places
    among the charts of those in sight. segments: [n], numbers of the charts that have a target, rising: those in sight,
    and some that were, as far charts come and go. narrowest: [n] (see `choose_levels`).
    """

    def __init__(self, launcher: Launcher, anisotropy: int, most: int = 0) -> None:
        """anisotropy: most probes of a footprint when light is pasted. most: targets, unless more are in sight."""
        self._launcher, self.anisotropy, self._most = launcher, anisotropy, most
        self.visible: Any = launcher.empty((0, 0), wp.int32)
        self._seen, self._targets = (launcher.shared((0,), wp.int32) for _ in range(2))
        self._charts: Charts | None = None
        self.segments, self.narrowest = np.zeros(0, np.int64), launcher.shared((0,), wp.float64)

    def see(self, shot: Shot, tiles_of: Callable[[NDArray[np.int64]], Tiles]) -> Tiles:
        """Rasterise a frame's screen once, and set what pasting reads of the tiles of some segments' charts.

        tiles_of: tiles of the charts with these numbers.
        """
        charts, size = charts_of(shot), (shot.view.height, shot.view.width)
        self.shot, self.grid = shot, shot.grid()
        if self.visible.shape != size:
            self.visible = self._launcher.empty(size, wp.int32)
        if charts is not self._charts:
            self._assign(charts, self.segments)
        self._seen.fill(0)
        tiles = tiles_of(self.segments)
        self.mark(tiles, draws=True)
        self._seen.fetch()
        self.shown = np.flatnonzero(self._seen.host)
        if self._targets.host[self.shown].min(initial=0) < 0:
            seen = charts.segments[self.shown]
            wanted = np.union1d(self.segments, seen)
            self._assign(charts, wanted if len(wanted) <= self._most else seen)
            tiles = tiles_of(self.segments)
            self.mark(tiles)
        self.narrowest.host.fill(-1.0)
        self.narrowest.host[self._targets.host[self.shown]] = charts.narrowest[self.shown]
        return tiles

    def _assign(self, charts: Charts, segments: NDArray[np.int64]) -> None:
        """Give charts with these numbers a target, of which some may not be of this mesh."""
        self._charts = None  # until it is so
        self.segments = segments
        launcher, count = self._launcher, charts.segments.shape
        if self._seen.host.shape != count:
            self._seen, self._targets = launcher.shared(count, wp.int32), launcher.shared(count, wp.int32)
        if self.narrowest.host.shape != segments.shape:
            self.narrowest = launcher.shared(segments.shape, wp.float64)
        place = placed(segments, charts.segments)
        has = np.flatnonzero(place >= 0)
        self._targets.host.fill(-1)
        self._targets.host[place[has]] = has
        self._targets.send()
        self._charts = charts

    def mark(self, tiles: Tiles, *, draws: bool = False) -> None:
        """Set what pasting reads of each tile. draws: whether it is found anew which triangle each pixel sees."""
        launcher, shot, atlas = self._launcher, self.shot, tiles.atlas
        atlas.charts, atlas.targets = charts_of(shot).owners, self._targets.device
        tiles.need.fill(NEVER)
        kernel, triangles = read_with(marking(self.anisotropy).on(launcher.device)), shot.triangles
        inputs = [draws, self.grid, triangles.edges, triangles.planes, triangles.bounds]
        inputs += [self.visible, self._seen.device, atlas, tiles.need.device]
        launcher.over(shot.view.height, kernel, (), inputs)
        tiles.need.fetch()


class Lighting:
    """Lights tiles as a frame's eye sees them, under that frame's sun."""

    def __init__(self, shot: Shot, ways: "Ways") -> None:
        self.shot, self._ways, self._charts = shot, ways, charts_of(shot)

    def of(self, jobs: Jobs, tiles: Tiles, texels: Any) -> Iterator[Callable[[], None]]:
        """What lights the jobs of this frame where the pages say, but for coarse levels."""
        launcher, drawn = self.shot.launcher, self._charts.drawn(tiles.layout)
        ranges, size = np.empty(WAYS + 1, np.int32), self.shot.material.size
        inputs = [tiles.jobs, *jobs.as_in(self.shot.frame), tiles.shapes, drawn.widened]
        inputs += [max(size), size[0] == size[1], tiles.parted, ranges]
        launcher.launch_on_host(part_jobs, inputs)
        tiles.parted.send()
        ends = ranges.tolist()
        for way in range(WAYS):
            begin, end = ends[way : way + 2]
            if begin < end:
                kernel, chain = self._ways.of(way)
                inputs = [begin, tiles.parted.device, tiles.order.device, tiles.kept.device, tiles.atlas, drawn.ranges]
                inputs += [drawn.triangles.edges, drawn.triangles.planes]
                inputs += [chain.texels, chain.shape, self.shot.sun, texels, tiles.lit.device]
                yield launcher.laid_out(end - begin, kernel, (), inputs)


class Ways:
    """The kernels that light jobs from some inputs, by how their texels lie on those of the maps.

    All shots of one renderer are of one material, and have the same.
    """

    def __init__(self, shot: Shot, inputs: Inputs) -> None:
        self._shot, self._inputs = shot, shot.inputs(inputs)
        self._ways: dict[int, Way] = {}

    def of(self, way: int) -> "Way":
        """The kernel of a way."""
        if way not in self._ways:
            self._ways[way] = self._aligned() if way == ALIGNED else self._filtered(way)
        return self._ways[way]

    def _aligned(self) -> "Way":
        chain = self._shot.material.resolved(self._inputs)
        fill = aligned(chain.floats).on(self._shot.launcher.device)
        return Way(light_tiles(fill, self._shot.shade_packet(self._inputs, chain.floats), chain.floats), chain)

    def _filtered(self, way: int) -> "Way":
        inputs = BOX if way == BETWEEN else self._inputs
        chain = self._shot.material.chain(inputs)
        device = self._shot.launcher.device
        fill = inputs.after(ISOTROPIC.fill(chain.floats, device), chain.floats, device)
        return Way(light_tiles(fill, self._shot.shade_packet(inputs, chain.floats), chain.floats), chain)


class Way(NamedTuple):
    """The kernel that lights jobs, and the chain that it reads."""

    kernel: wp.Kernel
    chain: MipChain


def painted(screen: Screen, tiles: Tiles, texels: Any, lights: Iterable[Callable[[], None]]) -> Any:
    """The picture [H, W] on the device: tiles are lit and reduced, and the light is the texture."""
    shot = screen.shot
    launcher, height = shot.launcher, shot.view.height
    picture = launcher.empty((height, shot.view.width), wp.vec4)
    kernel = paste_with(paged(screen.anisotropy).on(launcher.device))
    inputs = [screen.grid, screen.visible, shot.triangles.planes, tiles.atlas, texels, shot.sun, picture]
    # All is laid out before the first kernel, as kernels empty the caches.
    lights = list(lights)
    reduce = launcher.record(reduce_coarse, len(tiles.layout.widths), [tiles.atlas, tiles.finest.device, texels])
    paste = launcher.laid_out(height, kernel, (), inputs)
    for light in lights:
        light()
    launcher.start(reduce)
    paste()
    return picture
