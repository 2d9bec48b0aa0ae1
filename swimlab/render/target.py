"""Targets of texture-space lighting: a segment of the road drawn with atlas coordinates as positions, and lit."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher, OnRows
from metrics.kernels.shared import Shared
from swimlab.render.atlas import Jobs, Light, Tiles
from swimlab.render.charts import Charts, Drawn, charts_of
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.choosing import choose_levels
from swimlab.render.kernels.placing import ALIGNED, BETWEEN
from swimlab.render.kernels.target_filter import aligned, paged
from swimlab.render.kernels.texture_filter import ISOTROPIC
from swimlab.render.kernels.texture_space import NEVER, marking, paste_with, read_with
from swimlab.render.kernels.tiles import light_tiles, reduce_coarse
from swimlab.render.layout import placed
from swimlab.render.shot import Shot
from swimlab.render.texture import MipChain

MANY_TARGETS = 64
"""Targets whose coarse levels are worth another thread."""

Before = Callable[[Tiles], None]
"""Called with tiles before they are marked, to lay out what follows, as kernels empty the caches. Where more is in
sight than had targets it is called again, with other tiles: what it laid out before is not run."""

TilesOf = Callable[[NDArray[np.int64]], Tiles]
"""The tiles of charts with some numbers."""


def lay_out_nothing(_: Tiles) -> None:
    """Where nothing follows."""


class Screen:
    """Which pixel sees which chart, frame after frame; its arrays serve all frames with as many pixels and charts.

    shot: the frame. grid, visible: on the device; visible, [H, W], is the triangle seen by each pixel. paste: the
    kernel that pastes light. in_sight: how many charts are. segments: [n], numbers of the charts that have a target,
    rising: all, or where these are too many those in sight, and some that were, as far charts come and go.
    """

    def __init__(self, launcher: Launcher, anisotropy: int, shading: int, most: int = 0) -> None:
        """anisotropy: most probes of a footprint when light is pasted. shading: what is shaded (see
        `swimlab.render.kernels.choosing`). most: targets, unless more are in sight.
        """
        self._launcher, self._shading, self._most = launcher, shading, most
        self._read = read_with(marking(anisotropy).on(launcher.device))
        self.paste = paste_with(paged(anisotropy).on(launcher.device))
        self.visible: Any = launcher.empty((0, 0), wp.int32)
        self._seen, self._owners, self._targets, self._places = (launcher.shared((0,), wp.int32) for _ in range(4))
        self._counts = launcher.shared((2,), wp.int32)
        self._charts: Charts | None = None
        self._narrowest: Any = np.zeros(0)
        self.segments = np.zeros(0, np.int64)

    def see(self, shot: Shot, tiles_of: TilesOf, before: Before = lay_out_nothing) -> Tiles:
        """Rasterise a frame's screen once, and mark the tiles of some segments' charts, with all in sight."""
        charts, size = charts_of(shot), (shot.view.height, shot.view.width)
        self.shot, self.grid = shot, shot.grid()
        if self.visible.shape != size:
            self.visible = self._launcher.empty(size, wp.int32)
        if charts is not self._charts:
            self._assign(charts, charts.segments if len(charts.segments) <= self._most else self.segments)
        self._seen.fill(0)
        tiles = tiles_of(self.segments)
        self.marking(tiles, before, draws=True)()
        self.in_sight, have_targets = self._counts.host.tolist()
        if have_targets < self.in_sight:
            seen = charts.segments[self._seen.host != 0]
            wanted = np.union1d(self.segments, seen)
            self._assign(charts, wanted if len(wanted) <= self._most else seen)
            tiles = tiles_of(self.segments)
            self.marking(tiles, before)()
        return tiles

    def _assign(self, charts: Charts, segments: NDArray[np.int64]) -> None:
        """Give charts with these numbers a target, of which some may not be of this mesh."""
        self._charts = None  # until it is so
        if not np.array_equal(segments, self.segments):
            self.segments = segments
        self._seen = self._one_for_each(charts.segments, self._seen)
        self._targets = self._one_for_each(charts.segments, self._targets)
        self._places = self._one_for_each(segments, self._places)
        self._owners = self._one_for_each(charts.owners, self._owners)
        self._owners.host[:] = charts.owners
        self._owners.send()
        self._places.host[...] = place = placed(segments, charts.segments)
        has = np.flatnonzero(place >= 0)
        self._targets.host.fill(-1)
        self._targets.host[place[has]] = has
        self._targets.send()
        self._narrowest, self._charts = charts.narrowest, charts

    def _one_for_each(self, of: NDArray[Any], array: Shared) -> Shared:
        """The array where it has a number for each, or another one."""
        return array if array.host.shape == of.shape else self._launcher.shared(of.shape, wp.int32)

    def marking(self, tiles: Tiles, before: Before, *, draws: bool = False) -> Callable[[], None]:
        """What sets what pasting reads of each tile, and which are shaded and kept.

        before: called with the tiles, unless there are none. draws: whether it is found anew which triangle each pixel
        sees.
        """
        launcher, shot, atlas = self._launcher, self.shot, tiles.atlas
        tiles.show(self._owners.device, self._targets.device)
        tiles.need.fill(NEVER)
        triangles = shot.triangles
        inputs = [draws, self.grid, triangles.edges, triangles.planes, triangles.bounds]
        inputs += [self.visible, self._seen.device, atlas, tiles.need.device]
        read = launcher.laid_out(shot.view.height, self._read, (), inputs)
        known = [self._seen, self._narrowest, self._places, tiles.shapes, tiles.need, self._shading, shot.frame]
        choose = launcher.on_host(choose_levels, [*known, tiles.table, tiles.finest, self._counts])
        if len(tiles.segments) > 0:
            before(tiles)

        def mark() -> None:
            read()
            for array in (tiles.need, self._seen):
                array.fetch()
            choose()

        return mark


class Lighting:
    """Lights tiles as a frame's eye sees them, under that frame's sun."""

    def __init__(self, shot: Shot, ways: "Ways") -> None:
        self.shot, self._ways, self._charts = shot, ways, charts_of(shot)

    def light(self, tiles: Tiles, numbers: Sequence[int] = (0,)) -> Light:
        """How it lights tiles. numbers: see Light; by default light of no other frame may be held."""
        size = self.shot.material.size
        return Light(self.shot.frame, numbers, self._drawn(tiles).widened, size[0] == size[1], max(size))

    def laid_out(self, way: int, tiles: Tiles, texels: Any) -> OnRows:
        """What lights jobs in a way, given as a range, where the pages say, but for coarse levels."""
        (kernel, chain), drawn = self._ways.of(way), self._drawn(tiles)
        inputs = [tiles.jobs.device, tiles.order.device, tiles.kept.device, tiles.atlas, drawn.ranges]
        inputs += [drawn.triangles.edges, drawn.triangles.planes]
        inputs += [chain.texels, chain.shape, self.shot.sun, texels, tiles.lit.device]
        return self.shot.launcher.laid_out(len(tiles.need.host), kernel, (), inputs)

    def _drawn(self, tiles: Tiles) -> Drawn:
        return self._charts.drawn(tiles)


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


class Relighting:
    """What lights and reduces the tiles of a frame that are to be shaded, laid out for one frame.

    texels: where the light is.
    """

    def __init__(self, tiles: Tiles, texels: Any, lighting: Lighting, likely: Iterable[int] = ()) -> None:
        """likely: ways in which jobs may be lit, to be laid out now; others are when there turn out to be some."""
        launcher, targets = lighting.shot.launcher, len(tiles.segments)
        self._tiles, self._lighting, self.texels = tiles, lighting, texels
        self._ways = {way: self._way(way) for way in likely}
        inputs = [tiles.atlas, tiles.finest.device, texels]
        self._reduce = launcher.laid_out(targets, reduce_coarse, (), inputs, strip=MANY_TARGETS)

    def _way(self, way: int) -> OnRows:
        return self._lighting.laid_out(way, self._tiles, self.texels)

    def __call__(self, jobs: Jobs) -> None:
        """Make the light of now."""
        for way, rows in jobs.by_way.items():
            (self._ways.get(way) or self._way(way))(rows)
        self._reduce()


def pasting(screen: Screen, tiles: Tiles, texels: Any) -> Callable[[], Any]:
    """What makes the picture, [H, W] on the device, when there is light: the light is the texture."""
    shot = screen.shot
    launcher, view = shot.launcher, shot.view
    picture = launcher.unset((view.height, view.width), wp.vec4)
    inputs = [screen.grid, screen.visible, shot.triangles.planes, tiles.atlas, texels, shot.sun, picture]
    paste = launcher.laid_out(view.height, screen.paste, (), inputs)

    def pasted() -> Any:
        paste()
        return picture

    return pasted
