"""Tiles of a frame's targets: what is known of them, and the memory that holds those that are kept."""

from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from metrics.kernels.shared import Shared
from swimlab.render.kernels.placing import KINDS, LEVELS, ROWS, WAYS, place_tiles
from swimlab.render.kernels.texture_space import Atlas
from swimlab.render.kernels.tiles import MOST_TEXELS
from swimlab.render.layout import Ints, Layout, matched
from swimlab.runs.record import RunError

MOST_ADDRESSED = 1 << 31
"""Texels that kernels can tell apart."""


class Tiles:
    """What is known of the tiles of a frame, in arrays that serve all frames with the same targets.

    need: [entries], the finest level that is read of each tile, NEVER for none. finest: [n], that of each target.
    table: [ROWS, entries] (see `swimlab.render.kernels.placing`). pages: [entries], the `table` of Pages. atlas: as
    kernels take them.

    Tiles to be shaded, as `light_tiles` takes them: jobs, [entries, 4], of which so many are set; order and kept,
    [entries], its `tiles` and `kept`; lit, [entries], the texels of each job.
    """

    def __init__(self, launcher: Launcher, layout: Layout) -> None:
        self.layout, size = layout, (layout.entries,)
        self.shapes = launcher.shared(layout.shapes.shape, wp.int32)
        self.shapes.host[...] = layout.shapes
        self.finest = launcher.shared((len(layout.widths),), wp.int32)
        self.table, self._other = (launcher.shared((ROWS, *size), wp.int32) for _ in range(2))
        self.jobs = launcher.shared((*size, 4), wp.int32)
        self.need, self.pages, self.order, self.kept, self.lit = (launcher.shared(size, wp.int32) for _ in range(5))
        self.atlas: Any = Atlas()
        self.atlas.shapes = launcher.view(self.shapes.host, wp.vec4i)
        self.atlas.table = self.pages.device

    def hold(self, frame: int) -> "Held":
        """What is known of them in a frame. The next one writes to the other table, so that what was held is let go."""
        held = Held(frame, self.layout, self.shapes, self.table)
        self.table, self._other = self._other, self.table
        return held

    def shaded(self, jobs: "Jobs") -> int:
        """How many texels were lit, when all jobs are done."""
        self.lit.fetch()
        return int(self.lit.host[: jobs.total].sum(dtype=np.int64))


class Shelf:
    """Tiles whose arrays are used again when a frame has the same targets."""

    def __init__(self, launcher: Launcher, room: int = 1) -> None:
        """room: how many layouts a frame needs."""
        self._launcher, self._kept = launcher, deque[Tiles](maxlen=room)

    def take(self, segments: NDArray[np.int64], widths: Ints) -> Tiles:
        """The tiles of some targets (see Layout)."""
        for tiles in self._kept:
            if tiles.layout.has(segments, widths):
                self._kept.remove(tiles)
                break
        else:
            tiles = Tiles(self._launcher, Layout(segments, widths))
        self._kept.append(tiles)  # the last that goes when there is no room
        return tiles


class LightFrames(NamedTuple):
    """The frames whose light tiles may have: some that follow each other.

    oldest: the first of them. poses: of each a number of where eye and sun were. widened: [frames, targets], whether
    its charts are. square: whether the maps are as long as wide. texels: of them along their longer side.
    """

    oldest: int
    poses: Sequence[int]
    widened: NDArray[np.bool_]
    square: bool
    texels: int


class Jobs(NamedTuple):
    """Which jobs are of which light.

    oldest: the first frame that any is lit as in. ranges: of each frame from that on the first job of each way, and the
    end.
    """

    oldest: int
    ranges: list[list[int]]

    @property
    def total(self) -> int:
        """How many there are."""
        return self.ranges[-1][-1]

    @property
    def frames(self) -> list[int]:
        """The frames that tiles are lit as in."""
        return [frame for frame, ends in enumerate(self.ranges, self.oldest) if ends[0] < ends[-1]]

    def of(self, frame: int) -> list[tuple[int, int]]:
        """Of each way to light a frame's jobs the first of them, and one past the last."""
        return list(pairwise(self.ranges[frame - self.oldest]))


class Held(NamedTuple):
    """The tiles of a frame, whose blocks the pool has, and their table, to which nothing else is written."""

    frame: int
    layout: Layout
    shapes: Shared
    table: Shared

    @staticmethod
    def nothing(launcher: Launcher) -> "Held":
        """No tiles."""
        layout = Layout(np.zeros(0, np.int64), np.zeros(0, np.int32))
        return Held(0, layout, launcher.shared((0, 4), wp.int32), launcher.shared((ROWS, 0), wp.int32))


class Pool:
    """Memory for blocks of texels, RGBA, which grows when it is full. What is given back is taken again."""

    def __init__(self, launcher: Launcher) -> None:
        self._launcher = launcher
        # Where nothing is held a table says 0: its first texels are nobody's.
        self.texels = launcher.zeros(4 * MOST_TEXELS, wp.vec4)
        self._end, self._count = launcher.shared((1,), wp.int64), launcher.shared((KINDS,), wp.int32)
        self._free = launcher.shared((KINDS, 0), wp.int32)

    def place(self, tiles: Tiles, frames: LightFrames, last: Held) -> Jobs:
        """Complete the table and the pages of tiles whose EPOCH is known, and say what is to be shaded.

        last: what holds blocks, all that does; they are kept or given back. Raises RunError for more texels than can be
        addressed.
        """
        launcher, layout = self._launcher, tiles.layout
        if last.layout.entries == 0:
            self._end.host[:], self._count.host[:] = MOST_TEXELS, 0
        self._make_room(int(self._count.host.max()) + last.layout.entries)
        before, after = matched(layout, last.layout)
        count, targets = frames.widened.shape
        places, ranges = np.zeros((count, targets, LEVELS), np.int32), np.empty((count, WAYS + 1), np.int32)
        inputs = [frames.oldest, np.array(frames.poses, np.int32), frames.widened, frames.square, frames.texels]
        inputs += [tiles.shapes, tiles.finest, before, tiles.table, tiles.pages, last.shapes, after, last.table]
        inputs += [self._free, self._count, self._end, places, tiles.order, tiles.kept, tiles.jobs, ranges]
        launcher.start(launcher.record_on_host(place_tiles, inputs))
        end = int(self._end.host[0])
        if end >= MOST_ADDRESSED:
            raise RunError("techniques.tsl.size: the targets of one frame need more than 2^31 texels; choose less")
        if end > len(self.texels):
            grown = launcher.empty(end + end // 4, wp.vec4)
            wp.copy(grown, self.texels)
            self.texels = grown
        for array in (tiles.pages, tiles.order, tiles.kept, tiles.jobs, tiles.finest):
            array.send()
        return Jobs(frames.oldest, ranges.tolist())

    def _make_room(self, room: int) -> None:
        """Room for so many free blocks of each kind."""
        known = self._free.host
        if room > known.shape[1]:
            self._free = self._launcher.shared((KINDS, 2 * room), wp.int32)
            self._free.host[:, : known.shape[1]] = known
