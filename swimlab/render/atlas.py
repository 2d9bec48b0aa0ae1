"""Where the tiles of a frame's targets are: their order in a table, and the memory that holds those that are kept."""

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.kernels.texture_space import NEVER, Atlas
from swimlab.render.kernels.tiles import MOST_TEXELS, TILE_LEVEL
from swimlab.runs.record import RunError

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Layout:
    """The order of tiles in a table: of each target an entry for its coarse levels, then one a tile, row by row.

    segments: the charts that have a target. widths: texels along each target, powers of two.
    """

    segments: tuple[int, ...]
    widths: Ints

    @cached_property
    def levels(self) -> Ints:
        """Levels of each target."""
        return np.array([int(width).bit_length() for width in self.widths], np.int64)

    @cached_property
    def tile_levels(self) -> Ints:
        """The level of each target at which one texel covers one tile."""
        return np.minimum(self.levels - 1, TILE_LEVEL)

    @cached_property
    def across(self) -> Ints:
        """Tiles along each target."""
        return self.widths >> self.tile_levels

    @cached_property
    def firsts(self) -> Ints:
        """Entry of each target's first tile."""
        return np.cumsum(self.across**2 + 1) - self.across**2

    def is_same(self, other: "Layout") -> bool:
        """Whether two layouts are equal."""
        return self.segments == other.segments and np.array_equal(self.widths, other.widths)

    @cached_property
    def entries(self) -> int:
        """Length of the table."""
        return int(np.sum(self.across**2 + 1))

    @cached_property
    def owners(self) -> Ints:
        """The target of each entry."""
        return np.repeat(np.arange(len(self.widths)), self.across**2 + 1)

    @cached_property
    def is_tile(self) -> NDArray[np.bool_]:
        """Whether an entry is a tile's."""
        found = np.ones(self.entries, bool)
        found[self.firsts - 1] = False
        return found

    def of(self, target: int) -> slice:
        """The entries of a target's tiles."""
        first = int(self.firsts[target])
        return slice(first, first + int(self.across[target]) ** 2)

    def block(self, levels: Ints) -> Ints:
        """Texels to hold of each entry: of a tile its levels from `levels` [entries] up to but without the last, which
        with all coarser ones is its target's."""
        tile_levels = self.tile_levels[self.owners]
        finest = np.minimum(levels, tile_levels)
        tile = (4 * 4 ** (tile_levels - finest) - 1) // 3 - 1
        coarse = (4 * self.across**2 - 1) // 3
        return np.where(self.is_tile, tile, coarse[self.owners])

    def offset(self, levels: Ints) -> Ints:
        """Texels of a tile that come before a level, by entry."""
        whole = 4 ** self.tile_levels[self.owners]
        return np.where(self.is_tile, 4 * (whole - whole // 4 ** np.minimum(levels, TILE_LEVEL)) // 3, 0)

    def with_coarse(self, keep: Ints) -> Ints:
        """The finest level to hold of each entry: of tiles as given, NEVER for none; of coarse levels 0, for all."""
        return np.where(self.is_tile, keep, 0)

    def table(self, launcher: Launcher, keep: Ints, start: Ints) -> Any:
        """The table on the device: `start` is the first texel of what is held of each entry, down to `keep`."""
        return launcher.view(np.where(keep == NEVER, 0, start - self.offset(keep)).astype(np.int32), wp.int32)

    def on(self, launcher: Launcher, table: Any, targets: Any) -> Any:
        """The Atlas that kernels take, of a table and of the target of each triangle on the device."""
        atlas: Any = Atlas()
        shapes = np.stack([self.widths, self.levels, self.tile_levels, self.firsts], axis=1)
        atlas.shapes = launcher.view(shapes.astype(np.int32), wp.vec4i)
        atlas.table, atlas.targets = table, targets
        return atlas


class Pool:
    """Memory for blocks of texels, RGBA, which grows when it is full. What is given back is taken again."""

    def __init__(self, launcher: Launcher) -> None:
        self._launcher = launcher
        self._free: defaultdict[int, list[Ints]] = defaultdict(list)
        # Where nothing is held a table says 0: its first texels are nobody's.
        self.texels = launcher.zeros(4 * MOST_TEXELS, wp.vec4)
        self._end = MOST_TEXELS

    def clear(self) -> None:
        """Take all blocks back."""
        self._free.clear()
        self._end = MOST_TEXELS

    def take(self, sizes: Ints) -> Ints:
        """The first texels of blocks of some sizes. Raises RunError for more texels than can be addressed."""
        starts, new = np.zeros(len(sizes), np.int64), np.ones(len(sizes), bool)
        for size in [size for size in np.unique(sizes).tolist() if size in self._free]:
            mine, free = np.flatnonzero(sizes == size), np.concatenate(self._free.pop(size))
            old = mine[: len(free)]
            starts[old], new[old] = free[: len(old)], False
            if len(old) < len(free):
                self._free[size] = [free[len(old) :]]
        ends = self._end + np.cumsum(sizes[new])
        starts[new] = ends - sizes[new]
        self._end = int(ends[-1]) if len(ends) else self._end
        if self._end >= 1 << 31:
            raise RunError("techniques.tsl.size: the targets of one frame need more than 2^31 texels; choose less")
        if self._end > len(self.texels):
            grown = self._launcher.empty(self._end + self._end // 4, wp.vec4)
            wp.copy(grown, self.texels)
            self.texels = grown
        return starts

    def hold(self, layout: Layout, keep: Ints) -> Ints:
        """The first texel of a block for each entry of which something is to be kept; 0 for the others."""
        start, held = np.zeros(layout.entries, np.int64), keep != NEVER
        start[held] = self.take(layout.block(keep)[held])
        return start

    def give(self, starts: Ints, sizes: Ints) -> None:
        """Give blocks back."""
        for size in np.unique(sizes).tolist():
            self._free[size].append(starts[sizes == size])
