"""Which charts have targets, how large, and the order of their tiles in tables."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from swimlab.render.kernels.tile_table import TILE_LEVEL

Ints = NDArray[np.int32]


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

    def has(self, segments: NDArray[np.int64], widths: Ints) -> bool:
        """Whether it is the layout of these."""
        pairs = (self.segments, segments), (self.widths, widths)
        return all(mine is other or np.array_equal(mine, other) for mine, other in pairs)


@lru_cache(maxsize=4)
def equal_widths(targets: int, width: int) -> Ints:
    """[targets], all of one width."""
    widths = np.full(targets, width, np.int32)
    widths.flags.writeable = False  # since whoever asks for as many is given the same
    return widths


def matched(now: NDArray[np.int64], last: NDArray[np.int64]) -> tuple[Ints, Ints]:
    """Of each of some charts its place among others, -1 where it is not; and the other way round. Both rising."""
    place = placed(now, last).astype(np.int32)
    found = np.flatnonzero(place >= 0)
    after = np.full(len(last), -1, np.int32)
    after[place[found]] = found
    return place, after


def placed(wanted: NDArray[np.int64], known: NDArray[np.int64]) -> NDArray[np.int64]:
    """The place of each wanted number among known ones, which rise, or -1."""
    if len(known) == 0:
        return np.full(len(wanted), -1)
    place = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    return np.where(known[place] == wanted, place, -1)
