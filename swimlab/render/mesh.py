"""The scene as an indexed triangle mesh about the eye: the road, and what hangs over it and stands on it."""

import itertools
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sequences import Camera, Posts, Road, Scene

Doubles = NDArray[np.float64]

ROWS_PER_WAVE = 64
"""Quads along one wave of a hilly road: a chord is then off the sine by at most amplitude / 830."""
UPRIGHT = 1e4
"""Slope of what stands upright, in place of an infinite one: its normal is off by 1e-4 rad."""
WIRE_U = (0.0545, 0.0588)
"""The band of u that wires show: within the left edge line of made asphalt, and as wide as to hold the centre of a
texel of every map and target of 64 texels and more."""


@dataclass(frozen=True)
class Mesh:
    """Triangles with their vertex attributes.

    positions: [N, 3], m, relative to the eye in world axes, so that a road far from the origin keeps its precision.
    uv: [N, 2], place in the segment, 0..1: the repeat coordinate of the maps and, since every segment has a target of
        its own, its unique atlas coordinate too.
    slope: [N], dz/dy of the road.
    triangles: [M, 3], indices of vertices, counter-clockwise seen from above.
    segments: [M], the chart each triangle belongs to, rising: the road's segments, counted along the road from y = 0,
        come first; each wire and post has charts of its own, whose numbers are theirs for one eye only.
    loose: [M], whether the triangle lies over others, so that leaving it out tears no hole.
    """

    positions: Doubles
    uv: Doubles
    slope: Doubles
    triangles: NDArray[np.int32]
    segments: NDArray[np.int64]
    loose: NDArray[np.bool_]

    @cached_property
    def facing(self) -> NDArray[np.bool_]:
        """[M], whether the triangle turns its upper side to the eye."""
        a, b, c = self.positions[self.triangles].transpose(1, 2, 0)
        p, q = b - a, c - a
        volume = (p[1] * q[2] - p[2] * q[1]) * a[0] + (p[2] * q[0] - p[0] * q[2]) * a[1]
        return np.asarray(volume + (p[0] * q[1] - p[1] * q[0]) * a[2] < 0.0)


def charts_in(segments: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The charts that triangles belong to, and the place of the first triangle of each. segments: rising."""
    first = np.flatnonzero(np.diff(segments, prepend=segments[:1] - 1))
    return segments[first], first


class Ribbon(NamedTuple):
    """A band along the road: its middle (m right of the centre line), width (m), u from left to right, m above it."""

    middle: float
    width: float
    u: tuple[float, float]
    lift: float
    quads: int


def scene_mesh(scene: Scene, camera: Camera) -> Mesh:
    """Road, wires and posts from one segment behind the eye to exactly `road.length` ahead, cut at segments' ends.

    Each segment has its own vertices, in `tessellation(road)` quads; a wire has one quad across.
    """
    road = scene.road
    across, along = tessellation(road)
    ribbons = [Ribbon(0.0, road.width, (0.0, 1.0), 0.0, across)]
    if scene.wires is not None:
        width, lift = scene.wires.width, scene.wires.height
        ribbons += [Ribbon(x, width, WIRE_U, lift, 1) for x in scene.wires.places(road).tolist()]
    posts = scene.posts
    if posts is not None and posts.rail > 0:
        ribbons += [Ribbon(x, posts.rail, WIRE_U, posts.height, 1) for x in posts.rows]
    start = camera.distance - road.segment
    end = camera.distance + road.length
    segments = range(floor(start / road.segment), ceil(end / road.segment))
    rows = _rows(road, along, segments, start, end)
    parts: list[Mesh] = []
    count = 0
    for index, ribbon in enumerate(ribbons):
        parts.append(_band(road, camera, ribbon, rows, count, index * len(segments)))
        count += len(parts[-1].positions)
    if posts is not None:
        places = posts.spacing * np.arange(np.ceil(start / posts.spacing), np.floor(end / posts.spacing) + 1)
        first = segments.stop + (len(ribbons) - 1) * len(segments)
        for chart, (y, x) in enumerate(itertools.product(places.tolist(), posts.rows), first):
            parts.append(_board(road, camera, posts, (x, y), count, chart))
            count += len(parts[-1].positions)
    if len(parts) == 1:
        return parts[0]
    return Mesh(*(np.concatenate(columns) for columns in zip(*(vars(part).values() for part in parts), strict=True)))


def _board(road: Road, camera: Camera, posts: Posts, place: tuple[float, float], count: int, chart: int) -> Mesh:
    """A post at (x, y), m in the road's axes, that turns its face to where the road comes from.

    It shows the maps in their own size, from the left edge of the road and the beginning of a segment on.
    """
    x, y = place
    side, up = np.array([-0.5, 0.5, 0.5, -0.5]), np.array([0.0, 0.0, 1.0, 1.0])
    foot = float(road.height_at(np.array([y]))[0]) - float(camera.eye(road)[2])
    corners = [x + side * posts.width - camera.lateral, np.full(4, y - camera.distance), foot + up * posts.height]
    shown = np.minimum(1.0, [posts.width / road.width, posts.height / road.segment])
    return Mesh(
        positions=np.stack(corners, axis=1),
        uv=np.stack([side + 0.5, up], axis=1) * shown,
        slope=np.full(4, UPRIGHT),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32) + np.int32(count),
        segments=np.full(2, chart),
        loose=np.ones(2, dtype=bool),
    )


def tessellation(road: Road) -> tuple[int, int]:
    """Quads of a segment across and along the road: as its table says, else one, and ROWS_PER_WAVE a wave of hills."""
    if road.tessellation is not None:
        return road.tessellation
    if road.wavelength is None:
        return 1, 1
    return 1, int(np.ceil(road.segment / road.wavelength * ROWS_PER_WAVE))


class Rows(NamedTuple):
    """Rows of vertices across a ribbon, nearest first.

    lengths: how many rows each segment has. segment, v: of each row, the segment that it belongs to, and v there, 0..1.
    """

    lengths: tuple[int, ...]
    segment: NDArray[np.int64]
    v: Doubles


def _rows(road: Road, along: int, segments: range, start: float, end: float) -> Rows:
    """`along` quads a segment, of which the first is cut at `start` and the last at `end` (m along the road)."""
    whole = np.arange(along + 1) / along
    low = max(0.0, (start - segments[0] * road.segment) / road.segment)
    high = min(1.0, (end - segments[-1] * road.segment) / road.segment)
    between = len(segments) - 2
    if between < 0:  # the road's length is lost in rounding
        v = _cut(whole, low, high)
        lengths: tuple[int, ...] = (len(v),)
    else:
        first, last = _cut(whole, low, 1.0), _cut(whole, 0.0, high)
        v = np.concatenate([first, np.tile(whole, between), last])
        lengths = (len(first), *(along + 1,) * between, len(last))
    return Rows(lengths, np.repeat(np.arange(segments.start, segments.stop), lengths), v)


def _cut(whole: Doubles, low: float, high: float) -> Doubles:
    return np.concatenate([[low], whole[(whole > low) & (whole < high)], [high]])


@lru_cache(maxsize=4)
def _quads(lengths: tuple[int, ...], quads: int) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Triangles [M, 3] of a ribbon of `quads` quads across, and which of its segments each belongs to, 0 and on."""
    segment, columns = np.repeat(np.arange(len(lengths)), lengths), quads + 1
    joined = np.flatnonzero(segment[1:] == segment[:-1])
    corner = (joined[:, None] * columns + np.arange(quads)).ravel()
    square = np.array([0, 1, columns + 1, 0, columns + 1, columns])
    return (corner[:, None] + square).reshape(-1, 3).astype(np.int32), np.repeat(segment[joined], 2 * quads)


def _band(road: Road, camera: Camera, ribbon: Ribbon, rows: Rows, count: int, chart: int) -> Mesh:
    """A ribbon along its rows; vertices are numbered from `count` on, a segment's chart is its number and `chart`."""
    columns = ribbon.quads + 1
    across = np.arange(columns) / ribbon.quads
    origin = rows.segment * road.segment
    y = origin + rows.v * road.segment
    positions = np.empty((len(y), columns, 3))
    positions[..., 0] = ribbon.middle + (across - 0.5) * ribbon.width - camera.lateral
    positions[..., 1] = ((origin - camera.distance) + rows.v * road.segment)[:, None]
    positions[..., 2] = (road.height_at(y) - float(camera.eye(road)[2]) + ribbon.lift)[:, None]
    left, right = ribbon.u
    uv = np.empty((len(y), columns, 2))
    uv[..., 0] = left + across * (right - left)
    uv[..., 1] = rows.v[:, None]
    triangles, segment = _quads(rows.lengths, ribbon.quads)
    return Mesh(
        positions=positions.reshape(-1, 3),
        uv=uv.reshape(-1, 2),
        slope=np.repeat(road.slope_at(y), columns),
        triangles=triangles + np.int32(count),
        segments=segment + (rows.segment[0] + chart),
        loose=np.full(len(triangles), ribbon.lift > 0.0),
    )
