"""Targets of texture-space lighting: a segment of the road drawn with atlas coordinates as positions, and lit."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.atlas import Jobs, LightFrames, Tiles
from swimlab.render.charts import Charts, Drawn, charts_of
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.placing import ALIGNED, BETWEEN, choose_levels
from swimlab.render.kernels.target_filter import aligned, paged
from swimlab.render.kernels.texture_filter import ISOTROPIC
from swimlab.render.kernels.texture_space import NEVER, marking, paste_with, read_with
from swimlab.render.kernels.tiles import light_tiles, reduce_coarse
from swimlab.render.layout import placed
from swimlab.render.shot import Shot
from swimlab.render.texture import MipChain


class Screen:
    """Which pixel sees which chart, frame after frame; its arrays serve all frames with as many pixels and charts.

    shot: the frame. grid, visible: on the device; visible, [H, W], is the triangle seen by each pixel. in_sight: how
    many charts are. segments: [n], numbers of the charts that have a target, rising: those in sight, and some that
    were, as far charts come and go.
    """

    def __init__(self, launcher: Launcher, anisotropy: int, shading: int, most: int = 0) -> None:
        """anisotropy: most probes of a footprint when light is pasted. shading: what is shaded (see `placing`).

        most: targets, unless more are in sight.
        """
        self._launcher, self.anisotropy, self._shading, self._most = launcher, anisotropy, shading, most
        self.visible: Any = launcher.empty((0, 0), wp.int32)
        self._seen, self._targets, self._places = (launcher.shared((0,), wp.int32) for _ in range(3))
        self._counts = launcher.shared((2,), wp.int32)
        self._charts: Charts | None = None
        self.segments = np.zeros(0, np.int64)

    def see(self, shot: Shot, tiles_of: Callable[[NDArray[np.int64]], Tiles]) -> Tiles:
        """Rasterise a frame's screen once, and mark the tiles of some segments' charts, with all in sight.

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
        self.in_sight, have_targets = self._counts.host.tolist()
        if have_targets < self.in_sight:
            seen = charts.segments[self._seen.host != 0]
            wanted = np.union1d(self.segments, seen)
            self._assign(charts, wanted if len(wanted) <= self._most else seen)
            tiles = tiles_of(self.segments)
            self.mark(tiles)
        return tiles

    def _assign(self, charts: Charts, segments: NDArray[np.int64]) -> None:
        """Give charts with these numbers a target, of which some may not be of this mesh."""
        self._charts = None  # until it is so
        self.segments = segments
        launcher, count = self._launcher, charts.segments.shape
        if self._seen.host.shape != count:
            self._seen, self._targets = launcher.shared(count, wp.int32), launcher.shared(count, wp.int32)
        if self._places.host.shape != segments.shape:
            self._places = launcher.shared(segments.shape, wp.int32)
        self._places.host[...] = place = placed(segments, charts.segments)
        has = np.flatnonzero(place >= 0)
        self._targets.host.fill(-1)
        self._targets.host[place[has]] = has
        self._targets.send()
        self._charts = charts

    def mark(self, tiles: Tiles, *, draws: bool = False) -> None:
        """Set what pasting reads of each tile, and which are shaded and kept.

        draws: whether it is found anew which triangle each pixel sees.
        """
        launcher, shot, atlas, charts = self._launcher, self.shot, tiles.atlas, charts_of(self.shot)
        atlas.charts, atlas.targets = charts.owners, self._targets.device
        tiles.need.fill(NEVER)
        kernel, triangles = read_with(marking(self.anisotropy).on(launcher.device)), shot.triangles
        inputs = [draws, self.grid, triangles.edges, triangles.planes, triangles.bounds]
        inputs += [self.visible, self._seen.device, atlas, tiles.need.device]
        read = launcher.laid_out(shot.view.height, kernel, (), inputs)
        known = [self._seen, charts.narrowest, self._places, tiles.shapes, tiles.need, self._shading]
        choose = launcher.record_on_host(choose_levels, [*known, tiles.table, tiles.finest, self._counts])
        read()
        for array in (tiles.need, self._seen):
            array.fetch()
        launcher.start(choose)


class Lighting:
    """Lights tiles as a frame's eye sees them, under that frame's sun."""

    def __init__(self, shot: Shot, ways: "Ways") -> None:
        self.shot, self._ways, self._charts = shot, ways, charts_of(shot)

    def drawn(self, tiles: Tiles) -> Drawn:
        """The charts that this frame draws in targets."""
        return self._charts.drawn(tiles.layout)

    def of(self, jobs: Jobs, tiles: Tiles, texels: Any) -> Iterator[Callable[[], None]]:
        """What lights the jobs of this frame where the pages say, but for coarse levels."""
        drawn = self.drawn(tiles)
        for way, (begin, end) in enumerate(jobs.of(self.shot.frame)):
            if begin < end:
                kernel, chain = self._ways.of(way)
                inputs = [begin, tiles.jobs.device, tiles.order.device, tiles.kept.device, tiles.atlas, drawn.ranges]
                inputs += [drawn.triangles.edges, drawn.triangles.planes]
                inputs += [chain.texels, chain.shape, self.shot.sun, texels, tiles.lit.device]
                yield self.shot.launcher.laid_out(end - begin, kernel, (), inputs)


def light_frames(lightings: Sequence[Lighting], poses: Sequence[int], tiles: Tiles) -> LightFrames:
    """The frames whose light tiles may have. lightings: of each. poses: see LightFrames."""
    first = lightings[0].shot
    widened, size = np.array([each.drawn(tiles).widened for each in lightings]), first.material.size
    return LightFrames(first.frame, poses, widened, size[0] == size[1], max(size))


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
    picture = launcher.unset((height, shot.view.width), wp.vec4)
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
