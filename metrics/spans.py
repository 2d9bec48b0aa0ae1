"""Which frames are aligned with each other, and by what: a spatially uniform motion, or exact correspondence."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics import bands
from metrics.clip import Clip
from metrics.correspondence import Correspondence
from metrics.geometry import Field, Geometry, Mask
from metrics.kernels.launch import Launcher
from metrics.plan import Plan, longest_unwarped, plan_shots, uniform_steps
from metrics.tiles import Level, Offset, lay

# A pixel counts as measured where the squared windows of tiles sum to this.
HALF = 0.5

ROOM = 256e6
"""Bytes that the correspondences of a clip may take, and as much its geometry."""


Tiles = tuple[tuple[int, ...], ...]
"""Of every level, how many tiles, and the first one's place (y, x): they follow each other in the level's order."""


class TileFloor(NamedTuple):
    """Of the tiles of one size: their bands of distance [n], and a pattern's energy [n] and what of it flickers."""

    size: int
    bands: NDArray[np.intp] | None
    energy: NDArray[np.float64]
    flicker: NDArray[np.float64]


@dataclass(frozen=True)
class Span:
    """Frames start..stop-1, aligned to one anchor frame; or a part of its tiles, measured at a time.

    shape: [H, W] of the frames, px.
    offsets: how far the surface is from where the anchor frame has it, (y, x) px, for every frame; all 0 when
        the pictures are unwarped to the anchor's grid, for which there is a `correspondence`.
    measured: share of the frame that the whole span's tiles weigh, 0..1.
    covered: share of wholly covered pixels in the anchor frame.
    bands: for every level the band of distance [n] of each tile; None without depth.
    left: for every level [n, octaves], the share of a noise's energy that unwarping leaves; None where nothing is.
    part: which part of the span's tiles these are.
    rows: rows of the anchor frame that pictures are aligned for.
    reached: [H, W], the pixels of the anchor frame that tiles weigh by one half or more.
    floors: tiles of a part -> what came of a pattern that is glued to the surface, once it is measured.
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
    floors: dict[Tiles, list[TileFloor]] = field(default_factory=dict, repr=False)
    part: int = 0

    @property
    def count(self) -> int:
        return self.stop - self.start

    @property
    def tiles(self) -> Tiles:
        """Which tiles these are of all of the span's: how it is cut in parts differs with memory and measures."""
        return tuple((level.count, *level.origin[:1].ravel().tolist()) for level in self.levels)

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


def align(
    clip: Clip,
    *,
    plan: Plan | None = None,
    some: slice = slice(None),
    keep: bool = True,
    room: float = ROOM,
    launcher: Launcher | None = None,
) -> Alignment:
    """Align a clip's frames by its motion and coverage.

    plan: from `plan_spans`; None: found here. some: which of its spans to make.
    keep: hold all spans, to be used again; else they are made as they are asked for, once.
    room: bytes that motion and coverage may take, and half as many places if the motion is not uniform; what does not
        fit is read or found again.
    launcher: runs the kernels, and those of measuring with the spans, until when it stays open; None: one with all
        cores.
    """
    geometry, places = _share_out(clip, room, together=clip.count if keep else None)
    steps = uniform_steps(geometry) if plan is None else plan.steps
    make = _maker(geometry, steps, launcher or Launcher(), places)
    spans = _spans(geometry, steps, make) if plan is None else (make(*bounds) for bounds in plan.bounds[some])
    return Alignment(geometry, steps, list(spans) if keep else spans)


def plan_spans(clip: Clip, *, room: float = ROOM, launcher: Launcher | None = None) -> Plan:
    """The spans in which a clip is measured, without those that are not asked for. The rest as for `align`."""
    geometry, places = _share_out(clip, room, together=None)
    steps = uniform_steps(geometry)
    make = _maker(geometry, steps, launcher or Launcher(), places)
    return Plan(steps, tuple(bound for bounds, _ in plan_shots(geometry, steps, make) for bound in bounds))


def _share_out(clip: Clip, room: float, *, together: int | None) -> tuple[Geometry, float]:
    """A clip's geometry, and the bytes that the places of one frame may take.

    together: frames that are held at a time; None: those of one span. A span's motion is gone through several times: if
    not all of it fits, what is asked for next would always be gone already, so that no more is held than is needed.
    """
    frames = together or min(clip.count, longest_unwarped(clip))
    motion = 8.0 * clip.shape[0] * clip.shape[1]
    return Geometry(clip, room=room if motion * (frames + 1) <= room else 0.0), room / 2 / frames


def _maker(
    geometry: Geometry, steps: NDArray[np.float64] | None, launcher: Launcher, places: float
) -> Callable[[int, int], Span]:
    """What makes spans. places: bytes that those of a frame may take."""
    return lambda start, stop: _span(geometry, start, stop, steps, launcher, places)


def _spans(geometry: Geometry, steps: NDArray[np.float64] | None, make: Callable[[int, int], Span]) -> Iterator[Span]:
    """A clip's spans one by one, in order; the one that was made for the plan is not made again."""
    for bounds, middle in plan_shots(geometry, steps, make):
        half = len(bounds) // 2
        yield from (make(*bound) for bound in bounds[:half])
        yield middle
        del middle  # Its places are not held here while those after it are made.
        yield from (make(*bound) for bound in bounds[half + 1 :])


def _span(
    geometry: Geometry, start: int, stop: int, steps: NDArray[np.float64] | None, launcher: Launcher, room: float
) -> Span:
    correspondence = None
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
    )
