"""Where the tiles of a frame's targets are: their order in a table, and the memory that holds those that are kept."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.kernels.placing import KINDS, LEVELS, ROWS, TABLE, choose_levels, place_tiles
from swimlab.render.kernels.texture_space import Atlas
from swimlab.render.kernels.tiles import MOST_TEXELS, TILE_LEVEL
from swimlab.runs.record import RunError

Ints = NDArray[np.int32]

MOST_ADDRESSED = 1 << 31
"""Texels that kernels can tell apart."""


@dataclass(frozen=True, eq=False)
class Layout:
    """The order of tiles in a table: of each target an entry for its coarse levels, then one a tile, row by row.

    segments: [n], the charts that have a target, rising. widths: [n], texels along each target, powers of two.
    """

    segments: NDArray[np.int64]
    widths: Ints

    @cached_property
    def levels(self) -> Ints:
        """Levels of each target."""
        return np.frexp(self.widths)[1]

    @cached_property
    def tile_levels(self) -> Ints:
        """The level of each target at which one texel covers one tile."""
        return np.minimum(self.levels - 1, np.int32(TILE_LEVEL))

    @cached_property
    def across(self) -> Ints:
        """Tiles along each target."""
        return self.widths >> self.tile_levels

    @cached_property
    def firsts(self) -> NDArray[np.int64]:
        """Entry of each target's first tile."""
        return np.cumsum(self.across.astype(np.int64) ** 2 + 1) - self.across**2

    @cached_property
    def entries(self) -> int:
        """Length of the table."""
        return int(np.sum(self.across.astype(np.int64) ** 2 + 1))

    @cached_property
    def shapes(self) -> Ints:
        """[n, 4], as kernels take them (see Atlas)."""
        return np.stack([self.widths, self.levels, self.tile_levels, self.firsts], axis=1).astype(np.int32)

    def of(self, target: int) -> slice:
        """The entries of a target's tiles."""
        first = int(self.firsts[target])
        return slice(first, first + int(self.across[target]) ** 2)

    def on(self, launcher: Launcher, charts: Any, targets: Any) -> Any:
        """The Atlas that kernels take, without its table. charts, targets: of triangles and charts, on the device."""
        atlas: Any = Atlas()
        atlas.shapes = launcher.view(self.shapes, wp.vec4i)
        atlas.charts, atlas.targets = charts, targets
        return atlas


class Tiles(NamedTuple):
    """What is known of the tiles of a frame.

    table: [ROWS, entries] (see `swimlab.render.kernels.placing`). finest: [n], the finest level that is read of each
    target. atlas: as kernels take them.
    """

    layout: Layout
    table: Ints
    finest: Ints
    atlas: Any

    @staticmethod
    def read(launcher: Launcher, layout: Layout, atlas: Any, need: Ints, coarsest: Ints, shading: int) -> "Tiles":
        """The tiles that are shaded and kept. need: [entries], the finest level that is read of each; see
        `choose_levels` for the others."""
        table, finest = np.empty((ROWS, layout.entries), np.int32), np.empty(len(layout.widths), np.int32)
        tiles = Tiles(layout, table, finest, atlas)
        launcher.launch_on_host(choose_levels, [layout.shapes, coarsest, need, shading, table, finest])
        return tiles


class Jobs(NamedTuple):
    """Tiles to be shaded, each as in some frame, as `light_tiles` takes them (see `swimlab.render.kernels.tiles`).

    oldest: the first frame that any is lit as in. ranges: of each frame from that on its first job, and the end. jobs:
    [n, 4]. tiles, kept: on the device.
    """

    layout: Layout
    oldest: int
    ranges: Ints
    jobs: Ints
    tiles: Any
    kept: Any

    @property
    def frames(self) -> list[int]:
        """The frames that tiles are lit as in."""
        first = self.ranges.tolist()
        return [self.oldest + k for k in range(len(first) - 1) if first[k] < first[k + 1]]

    def as_in(self, frame: int) -> Ints:
        """The jobs of a frame."""
        first = frame - self.oldest
        return self.jobs[slice(*self.ranges[first : first + 2])]


class Held(NamedTuple):
    """The tiles of a frame, whose blocks the pool has."""

    frame: int
    tiles: Tiles


_NO_TARGETS = Layout(np.zeros(0, np.int64), np.zeros(0, np.int32))
NO_TILES = Tiles(_NO_TARGETS, np.zeros((ROWS, 0), np.int32), np.zeros(0, np.int32), None)
NOTHING = Held(0, NO_TILES)


class Pool:
    """Memory for blocks of texels, RGBA, which grows when it is full. What is given back is taken again."""

    def __init__(self, launcher: Launcher) -> None:
        self._launcher = launcher
        # Where nothing is held a table says 0: its first texels are nobody's.
        self.texels = launcher.zeros(4 * MOST_TEXELS, wp.vec4)
        self._end = np.full(1, MOST_TEXELS, np.int64)
        self._free, self._count = np.empty((KINDS, 0), np.int32), np.zeros(KINDS, np.int32)

    def place(self, tiles: Tiles, poses: Sequence[int], oldest: int, last: Tiles = NO_TILES) -> Jobs:
        """Complete the table and the atlas of tiles whose EPOCH is known, and say what is to be shaded.

        last: tiles that hold blocks, all that do; they are kept or given back. poses: a number of where eye and sun
        were in each frame from `oldest` on. Raises RunError for more texels than can be addressed.
        """
        launcher, layout = self._launcher, tiles.layout
        if last is NO_TILES:
            self._end[:], self._count[:] = MOST_TEXELS, 0
        room = int(self._count.max()) + last.layout.entries
        if room > self._free.shape[1]:
            more = np.zeros((KINDS, 2 * room - self._free.shape[1]), np.int32)
            self._free = np.concatenate([self._free, more], axis=1)
        before, after = matched(layout, last.layout)
        inputs = [oldest, np.array(poses, np.int32), layout.shapes, before, tiles.table]
        inputs += [last.layout.shapes, after, last.table, self._free, self._count, self._end]
        places = np.zeros((len(poses), len(layout.widths), LEVELS), np.int32)
        order, kept = np.empty((2, layout.entries), np.int32)
        jobs, ranges = np.empty((layout.entries, 4), np.int32), np.empty(len(poses) + 1, np.int32)
        launcher.launch_on_host(place_tiles, [*inputs, places, order, kept, jobs, ranges])
        end = int(self._end[0])
        if end >= MOST_ADDRESSED:
            raise RunError("techniques.tsl.size: the targets of one frame need more than 2^31 texels; choose less")
        if end > len(self.texels):
            grown = launcher.empty(end + end // 4, wp.vec4)
            wp.copy(grown, self.texels)
            self.texels = grown
        tiles.atlas.table = launcher.view(tiles.table[TABLE], wp.int32)
        return Jobs(layout, oldest, ranges, jobs, launcher.view(order, wp.int32), launcher.view(kept, wp.int32))


def matched(now: Layout, last: Layout) -> tuple[Ints, Ints]:
    """Of each target of a layout its place in another, -1 where that has none as large; and the other way round."""
    place = placed(now.segments, last.segments)
    found = np.flatnonzero(place >= 0)
    found = found[last.widths[place[found]] == now.widths[found]]
    before, after = np.full(len(now.widths), -1, np.int32), np.full(len(last.widths), -1, np.int32)
    before[found], after[place[found]] = place[found], found
    return before, after


def placed(wanted: NDArray[np.int64], known: NDArray[np.int64]) -> NDArray[np.int64]:
    """The place of each wanted number among known ones, which rise, or -1."""
    if len(known) == 0:
        return np.full(len(wanted), -1)
    place = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    return np.where(known[place] == wanted, place, -1)
