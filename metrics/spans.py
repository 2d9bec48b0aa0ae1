"""Which frames are aligned with each other, and by what: a spatially uniform motion, or exact correspondence."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrics import bands
from metrics.clip import Clip
from metrics.correspondence import Correspondence
from metrics.geometry import Field, Geometry, Mask
from metrics.glued import Glued
from metrics.kernels.launch import Launcher
from metrics.tiles import Level, Offset, lay

# A motion field whose values lie this near to each other is taken as uniform, px.
UNIFORM = 1e-4

# Motion is held for a whole span, so a span under non-uniform motion ends here: frames, and pixels in all of them.
LONGEST_UNWARPED = 32
MOST_UNWARPED = 2**25

# A span may be so long that this share of what a single frame would show is still measured. Under a uniform motion
# long spans cost nothing but area; unwarped ones also lose accuracy.
KEPT = 0.2
KEPT_UNWARPED = 0.45

# What changes more slowly than a span is long reads as static, and of an error fixed to the screen what it does not
# travel: spans shorter than this, frames and px, are made only where the longer ones leave next to nothing, this share
# of enough.
SHORTEST = 16
SHORTEST_TRAVEL = 50.0
LITTLE = 1 / 3

# A pixel counts as measured where the squared windows of tiles sum to this.
HALF = 0.5

ROOM = 256e6
"""Bytes that the correspondences of a clip may take, and as much its geometry."""


@dataclass(frozen=True)
class Span:
    """Frames start..stop-1, aligned to one anchor frame; or a part of its tiles, measured at a time.

    shape: [H, W] of the frames, px.
    offsets: how far the surface is from where the anchor frame has it, (y, x) px, for every frame; all 0 when
        the pictures are unwarped to the anchor's grid, for which there is a `correspondence`, and a pattern that is
        `glued` to the surface by it.
    measured: share of the frame that the whole span's tiles weigh, 0..1.
    covered: share of wholly covered pixels in the anchor frame.
    bands: for every level the band of distance [n] of each tile; None without depth.
    left: for every level [n, octaves], the share of a noise's energy that unwarping leaves; None where nothing is.
    part: which part of the span's tiles these are.
    rows: rows of the anchor frame that pictures are aligned for.
    reached: [H, W], the pixels of the anchor frame that tiles weigh by one half or more.
    """

    start: int
    stop: int
    anchor: int
    shape: tuple[int, int]
    offsets: list[Offset]
    levels: list[Level]
    measured: float
    covered: float
    bands: list[NDArray[np.intp]] | None = field(repr=False)
    left: list[NDArray[np.float64]] | None = field(repr=False)
    rows: slice
    reached: Mask = field(repr=False)
    correspondence: Correspondence | None = field(default=None, repr=False)
    glued: Glued | None = field(default=None, repr=False)
    part: int = 0

    @property
    def count(self) -> int:
        return self.stop - self.start

    def placements(self) -> "Iterator[Placement]":
        """Where the frames lie on the anchor frame, in the order of time."""
        if self.correspondence is None:
            yield from (Placement(self, t) for t in range(self.start, self.stop))
            return
        for t, away in enumerate(self.correspondence.places(self.rows), self.start):
            yield Placement(self, t, away)


@dataclass(frozen=True)
class Placement:
    """Where frame t of a span lies: at an offset, or unwarped.

    away: how far, px (x, y), from each pixel of the span's rows of the anchor frame its surface is in this frame,
    [rows, W, 2]; None where tiles lie at an offset.
    """

    span: Span
    t: int
    away: Field | None = None

    def align(self, planes: NDArray[Any]) -> NDArray[np.float32]:
        """The frame's [channels, H, W] in the grid in which tiles lie; the span's rows only if it is unwarped."""
        if self.span.correspondence is None or self.away is None:
            return planes.astype(np.float32, copy=False)
        return self.span.correspondence.take(planes, self.away, self.span.rows)


@dataclass(frozen=True)
class Alignment:
    """How a clip's frames lie on each other: work that clips of one geometry, such as several techniques, share.

    steps: [count, 2] (y, x) px by which the whole picture moves into each frame; None if it does not move as one.
    """

    geometry: Geometry
    steps: NDArray[np.float64] | None
    spans: Iterable[Span]


def align(clip: Clip, *, keep: bool = True, room: float = ROOM, launcher: Launcher | None = None) -> Alignment:
    """Align a clip's frames by its motion and coverage.

    keep: hold all spans, to be used again; else they are made as they are asked for, once.
    room: bytes that motion and coverage may take, and half as many places if the motion is not uniform; what does not
        fit is read or found again.
    launcher: runs the kernels; None: one with all cores.
    """
    together = clip.count if keep else min(clip.count, longest_unwarped(clip))
    geometry = Geometry(clip, room=room if fits(clip, together + 1, room) else 0.0)
    steps = uniform_steps(geometry)
    spans = plan(geometry, steps, launcher or Launcher(), room=room / 2 / together)
    return Alignment(geometry, steps, list(spans) if keep else spans)


def fits(clip: Clip, count: int, room: float) -> bool:
    """Whether the motion of so many frames fits in `room` bytes.

    A span's is gone through several times: if not all of it fits, what is asked for next would always be gone already.
    """
    return 8.0 * count * clip.shape[0] * clip.shape[1] <= room


def longest_unwarped(clip: Clip) -> int:
    """Frames of a span under non-uniform motion at most."""
    height, width = clip.shape
    return min(LONGEST_UNWARPED, max(SHORTEST, MOST_UNWARPED // (height * width)))


def uniform_steps(geometry: Geometry) -> NDArray[np.float64] | None:
    """[count, 2] (y, x) px by which the whole picture moves into each frame, or None if it is not so.

    A field is uniform if it varies by no more than UNIFORM px over the covered pixels; its mean is the step. Into the
    first frame of a shot nothing moves.
    """
    clip = geometry.clip
    if not callable(clip.motion):
        return np.tile(np.asarray(clip.motion, dtype=np.float64)[::-1], (clip.count, 1))
    steps = np.zeros((clip.count, 2))
    for t in range(1, clip.count):
        if t in clip.cuts:
            continue
        surface = geometry.surface(t)
        seen = surface.motion[surface.whole]
        if len(seen) and max(np.ptp(seen[:, axis]) for axis in range(2)) > UNIFORM:
            return None
        steps[t] = seen.mean(axis=0, dtype=np.float64)[::-1] if len(seen) else steps[t - 1]
    return steps


def plan(geometry: Geometry, steps: NDArray[np.float64] | None, launcher: Launcher, *, room: float) -> Iterator[Span]:
    """Cut every shot of a clip in spans as long as tiles stay in view; yields them one by one, in order.

    The spans of a shot are about equal, 1, 2, 4, ... of them: as few as measure enough of what a single frame shows.
    room: bytes that the places of a frame may take.
    """

    def make(start: int, stop: int) -> Span:
        return _span(geometry, start, stop, steps, launcher, room)

    for first, last in pairwise([0, *geometry.clip.cuts, geometry.count]):
        longest = last - first if steps is not None else longest_unwarped(geometry.clip)
        yield from _plan_shot(first, last, make, longest, steps)


def _plan_shot(
    first: int, last: int, make: Callable[[int, int], Span], longest: int, steps: NDArray[np.float64] | None
) -> Iterator[Span]:
    """The spans of frames first..last-1. make: start, stop -> a span. longest: frames of one at most."""
    count, middle = last - first, (first + last) // 2
    enough = (KEPT if steps is not None else KEPT_UNWARPED) * make(middle, middle + 1).measured
    number = -(-count // longest)
    while True:
        edges = np.linspace(first, last, number + 1).round().astype(int)
        bounds = [(int(start), int(stop)) for start, stop in pairwise(edges)]
        trial = bounds[number // 2]
        span = make(*trial)
        short = span.measured > LITTLE * enough and _too_short(count / (2 * number), steps)
        if span.measured >= enough or count < 4 * number or short:
            break
        number *= 2
    for bound in bounds:
        yield span if bound == trial else make(*bound)


def _too_short(count: float, steps: NDArray[np.float64] | None) -> bool:
    """Whether a span of so many frames is too short to show what moves against the surface."""
    travel = np.inf if steps is None or len(steps) < 2 else count * float(np.hypot(*steps[1:].mean(axis=0)))
    return count < SHORTEST or travel < SHORTEST_TRAVEL


def _span(
    geometry: Geometry, start: int, stop: int, steps: NDArray[np.float64] | None, launcher: Launcher, room: float
) -> Span:
    correspondence = glued = None
    shape = geometry.shape
    if steps is None:
        anchor = (start + stop - 1) // 2
        offsets: list[Offset] = [(0.0, 0.0)] * (stop - start)
        correspondence = Correspondence(geometry, launcher, start, stop, room=room * (stop - start))
        usable = correspondence.usable
        levels, weight = lay(shape, offsets[:1], lambda _: usable)
        correspondence.usable = weight > 0
    else:
        anchor = start
        travelled = np.vstack([np.zeros(2), np.cumsum(steps[start + 1 : stop], axis=0)])
        offsets = [(float(y), float(x)) for y, x in travelled]
        levels, weight = lay(shape, offsets, lambda index: geometry.surface(start + index).mask)
    left = None if correspondence is None else correspondence.left_of(levels)
    tile_bands = bands.of_tiles(geometry.clip, levels, anchor)
    if correspondence is not None:
        glued = Glued(start, stop, shape, levels, tile_bands, correspondence, launcher)
    return Span(
        start,
        stop,
        anchor,
        shape=shape,
        offsets=offsets,
        levels=levels,
        measured=float(np.minimum(weight, 1.0).mean()),
        covered=float(geometry.surface(anchor).whole.mean()),
        bands=tile_bands,
        left=left,
        rows=slice(0, shape[0]),
        reached=weight >= HALF,
        correspondence=correspondence,
        glued=glued,
    )
