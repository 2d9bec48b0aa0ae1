"""Tiles of a frame's targets: what is known of them, and the memory that holds those that are kept."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from metrics.kernels.shared import Shared
from swimlab.render.kernels.choosing import fit_targets
from swimlab.render.kernels.placing import KINDS, WAYS, place_tiles
from swimlab.render.kernels.texture_space import Atlas
from swimlab.render.kernels.tile_table import LEVELS, MOST_TEXELS, ROWS
from swimlab.render.layout import Ints, Layout, matched
from swimlab.runs.record import RunError

MOST_ADDRESSED = 1 << 31
"""Texels that kernels can tell apart."""


class Tiles:
    """What is known of the tiles of a frame, in arrays that serve all frames with the same targets.

    segments: [n], the charts that have a target, rising. shapes: [n], as in Atlas. need: [entries], the finest level
    that is read of each tile, NEVER for none. finest: [n], that of each target. table: [ROWS, entries] (see
    `swimlab.render.kernels.tile_table`). pages: [entries], the `table` of Pages. atlas: as kernels take them.
    everywhere, nowhere: [n], each target's own place, and -1. fitted: whether the layout is another one in each frame.

    Tiles to be shaded, as `light_tiles` takes them: jobs, [entries, 4], of which so many are set; order and kept,
    [entries], its `tiles` and `kept`; lit, [entries], the texels of each job.
    """

    def __init__(self, launcher: Launcher, layout: Layout) -> None:
        """layout: of all frames, or of the largest targets where these are fitted.

        Of smaller targets arrays are longer than their layout; what is beyond it says nothing.
        """
        self._launcher, self.segments, self._layout = launcher, layout.segments, cast("Layout | None", layout)
        count, size = len(layout.segments), (layout.entries,)
        self.finest, self.everywhere, self.nowhere = (launcher.shared((count,), wp.int32) for _ in range(3))
        self.everywhere.host[:], self.nowhere.host[:] = np.arange(count), -1
        self.jobs = launcher.shared((*size, 4), wp.int32)
        self.need, self.pages, self.order, self.kept = (launcher.shared(size, wp.int32) for _ in range(4))
        self.lit = launcher.shared(size, wp.int64)
        self._sides = [self._side(layout)]
        self.atlas: Any = Atlas()
        self.atlas.shapes, self.atlas.table = self.shapes.device, self.pages.device
        self._shown: tuple[Any, ...] = self.shapes.device, None, None
        self.fitted = False

    def _side(self, layout: Layout) -> tuple[Shared, Shared]:
        shapes = self._launcher.shared((len(layout.segments),), wp.vec4i)
        shapes.host[...] = layout.shapes
        shapes.send()
        return shapes, self._launcher.shared((ROWS, len(self.need.host)), wp.int32)

    @property
    def shapes(self) -> Shared:
        """Of this frame."""
        return self._sides[0][0]

    @property
    def table(self) -> Shared:
        """Of this frame."""
        return self._sides[0][1]

    @property
    def layout(self) -> Layout:
        """Of this frame, once targets are fitted."""
        if self._layout is None:
            self._layout = Layout(self.segments, self.shapes.host[:, 0].copy())
        return self._layout

    def show(self, owners: Any, targets: Any) -> None:
        """Have kernels find them (see Atlas). owners: its charts."""
        atlas, now = self.atlas, (self.shapes.device, owners, targets)
        if any(a is not b for a, b in zip(now, self._shown, strict=True)):
            atlas.shapes, atlas.charts, atlas.targets = self._shown = now

    def fitting(self, whole: "Tiles", coarser: int) -> Callable[[], None]:
        """What makes targets as large as their charts are read in whole ones, and by some levels smaller."""
        self.fitted = True
        fit = self._launcher.on_host(fit_targets, [whole.finest, coarser, whole.shapes, self.shapes])

        def fit_all() -> None:
            fit()
            self.shapes.send()
            self._layout = None

        return fit_all

    def hold(self) -> "Held":
        """What is known of them now. The next frame writes to other memory, so that what was held is let go."""
        held = Held(self.layout, self.shapes, self.table)
        others = self._sides[1:] or [self._side(held.layout)]
        self._sides = [*others, self._sides[0]]  # at once, or an interrupt might leave the same one twice
        return held

    def shaded(self, jobs: "Jobs") -> int:
        """How many texels were lit, when all jobs are done."""
        self.lit.fetch()
        return int(self.lit.host[: jobs.total].sum())


class Shelf:
    """Tiles whose arrays are used again when a frame has the same targets."""

    def __init__(self, launcher: Launcher) -> None:
        self._launcher, self._kept = launcher, cast("tuple[Layout, Tiles] | None", None)

    def take(self, segments: NDArray[np.int64], widths: Ints) -> Tiles:
        """The tiles of some targets, all of these widths or less (see Layout)."""
        if self._kept is None or not self._kept[0].has(segments, widths):
            layout = Layout(segments, widths)
            self._kept = layout, Tiles(self._launcher, layout)
        return self._kept[1]


class Light(NamedTuple):
    """How the light of a frame is made, and told from what is held.

    numbers: of each frame whose light may be held, up to this one, a number of where eye and sun were. widened:
    [targets], whether their charts are. square: whether the maps are as long as wide. texels: of them along their
    longer side.
    """

    frame: int
    numbers: Sequence[int]
    widened: NDArray[np.bool_]
    square: bool
    texels: int


class Jobs(NamedTuple):
    """Which jobs are lit in which way, where any are, and how many there are."""

    by_way: Mapping[int, range]
    total: int

    @staticmethod
    def of(ends: Sequence[int]) -> "Jobs":
        """ends: one past the last job of each way."""
        ranges = map(range, [0, *ends], ends)
        return Jobs({way: jobs for way, jobs in enumerate(ranges) if jobs}, ends[-1])


class Held(NamedTuple):
    """The tiles of a frame, whose blocks the pool has, and their table, to which nothing else is written."""

    layout: Layout
    shapes: Shared
    table: Shared

    @staticmethod
    def nothing(launcher: Launcher) -> "Held":
        """No tiles."""
        layout = Layout(np.zeros(0, np.int64), np.zeros(0, np.int32))
        return Held(layout, launcher.shared((0,), wp.vec4i), launcher.shared((ROWS, 0), wp.int32))

    def matched(self, tiles: Tiles) -> tuple[Any, Any]:
        """Of each target of a frame its place in this one, -1 where it has none; and the other way round."""
        if self.layout.segments is tiles.segments:
            return tiles.everywhere, tiles.everywhere
        if len(self.layout.segments) == 0:
            return tiles.nowhere, np.zeros(0, np.int32)
        return matched(tiles.segments, self.layout.segments)


class Ordering(NamedTuple):
    """Arrays of the host by which jobs are put in order (see `swimlab.render.kernels.placing`)."""

    poses: Shared
    widened: Shared
    places: Shared
    ends: Shared

    @staticmethod
    def of(launcher: Launcher, frames: int, targets: int) -> "Ordering":
        """For so many."""
        kinds = ((frames,), wp.int32), ((targets,), wp.bool), ((targets, LEVELS), wp.int32), ((WAYS,), wp.int32)
        return Ordering(*[launcher.shared(*each) for each in kinds])


class Pool:
    """Memory for blocks of texels, RGBA, which grows when it is full. What is given back is taken again."""

    def __init__(self, launcher: Launcher) -> None:
        self._launcher = launcher
        # Where nothing is held a table says 0: its first texels are nobody's.
        self.texels = launcher.zeros(4 * MOST_TEXELS, wp.vec4)
        self._end, self._count = launcher.shared((1,), wp.int64), launcher.shared((KINDS,), wp.int32)
        self._free = launcher.shared((KINDS, 0), wp.int32)
        self._ordering = Ordering.of(launcher, 0, 0)

    def placing(self, tiles: Tiles, light: Light, last: Held) -> Callable[[], Jobs]:
        """What completes the table and the pages of tiles whose EPOCH is known, and says what is to be shaded.

        last: what holds blocks, all that does; they are kept or given back. It raises RunError for more texels than can
        be addressed.
        """
        launcher, entries = self._launcher, last.layout.entries
        if entries > 0:
            self._make_room(int(self._count.host.max()) + entries)
        before, after = last.matched(tiles)
        size = len(light.numbers), len(tiles.segments)
        if size != (len(self._ordering.poses.host), len(self._ordering.widened.host)):
            self._ordering = Ordering.of(launcher, *size)
        poses, widened, places, ends = self._ordering
        poses.host[:], widened.host[:] = light.numbers, light.widened
        inputs = [light.frame - len(light.numbers) + 1, poses, widened, light.square, light.texels]
        inputs += [tiles.shapes, tiles.finest, before, tiles.table, tiles.pages, last.shapes, after, last.table]
        inputs += [self._free, self._count, self._end, places, tiles.order, tiles.kept, tiles.jobs, ends]
        filled = launcher.on_host(place_tiles, inputs)

        def place() -> Jobs:
            filled()
            self._grow()
            for array in (tiles.pages, tiles.order, tiles.kept, tiles.jobs, tiles.finest):
                array.send()
            return Jobs.of(ends.host.tolist())

        return place

    def _grow(self) -> None:
        """As far as blocks are taken."""
        launcher, end = self._launcher, int(self._end.host[0])
        if end >= MOST_ADDRESSED:
            raise RunError("techniques.tsl.size: the targets of one frame need more than 2^31 texels; choose less")
        if end > len(self.texels):
            grown = launcher.empty(end + end // 4, wp.vec4)
            wp.copy(grown, self.texels)
            self.texels = grown

    def _make_room(self, room: int) -> None:
        """Room for so many free blocks of each kind."""
        known = self._free.host
        if room > known.shape[1]:
            self._free = self._launcher.shared((KINDS, 2 * room), wp.int32)
            self._free.host[:, : known.shape[1]] = known
