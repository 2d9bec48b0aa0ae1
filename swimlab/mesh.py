"""The road as an indexed triangle mesh about the eye."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sequences import Camera, Road

Doubles = NDArray[np.float64]

ROWS_PER_WAVE = 64
"""Quads along one wave of a hilly road: the chord then strays from the sine by at most amplitude / 830."""


@dataclass(frozen=True)
class Mesh:
    """Triangles with their vertex attributes.

    positions: [N, 3], m, relative to the eye in world axes, so that a road far from the origin keeps its precision.
    uv: [N, 2], place in the segment, 0..1: the repeat coordinate of the maps and, since every segment has a target of
        its own, its unique atlas coordinate too.
    slope: [N], dz/dy of the road.
    triangles: [M, 3], indices of vertices, counter-clockwise seen from above.
    segments: [M], the segment each triangle belongs to, counted along the road from y = 0.
    """

    positions: Doubles
    uv: Doubles
    slope: Doubles
    triangles: NDArray[np.int32]
    segments: NDArray[np.int64]


def road_mesh(road: Road, camera: Camera) -> Mesh:
    """The road from one segment behind the eye to exactly `road.length` ahead of it, cut at segments' ends.

    Each segment has its own vertices. A flat one is one quad; a hilly one has ROWS_PER_WAVE quads a wavelength.
    """
    start = camera.distance - road.segment
    end = camera.distance + road.length
    eye_z = float(camera.eye(road)[2])
    rows = 1
    if road.profile == "hills" and road.wavelength is not None:
        rows = int(np.ceil(road.segment / road.wavelength * ROWS_PER_WAVE))
    positions, uv, slope, triangles, segments = [], [], [], [], []
    count = 0
    for segment in range(int(np.floor(start / road.segment)), int(np.ceil(end / road.segment))):
        origin = segment * road.segment
        low, high = max(0.0, (start - origin) / road.segment), min(1.0, (end - origin) / road.segment)
        inner = np.arange(rows + 1) / rows
        v = np.concatenate([[low], inner[(inner > low) & (inner < high)], [high]])
        y = origin + v * road.segment
        left_right = np.array([0.0, 1.0])
        grid_u, grid_v = np.meshgrid(left_right, v)
        x = (grid_u - 0.5) * road.width - camera.lateral
        ahead = (origin - camera.distance) + grid_v * road.segment
        height = np.repeat(road.height_at(y) - eye_z, 2)
        positions.append(np.stack([x.ravel(), ahead.ravel(), height], axis=1))
        uv.append(np.stack([grid_u.ravel(), grid_v.ravel()], axis=1))
        slope.append(np.repeat(road.slope_at(y), 2))
        corner = count + 2 * np.arange(len(v) - 1)
        near = np.stack([corner, corner + 1, corner + 3], axis=1)
        far = np.stack([corner, corner + 3, corner + 2], axis=1)
        triangles.append(np.stack([near, far], axis=1).reshape(-1, 3))
        segments.append(np.full(2 * (len(v) - 1), segment))
        count += 2 * len(v)
    return Mesh(
        positions=np.concatenate(positions),
        uv=np.concatenate(uv),
        slope=np.concatenate(slope),
        triangles=np.concatenate(triangles).astype(np.int32),
        segments=np.concatenate(segments),
    )
