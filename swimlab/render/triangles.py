"""Triangle set-up: from vertices in homogeneous image coordinates to edge functions and plane equations.

All in double precision, before the rasteriser. The same code serves the screen, where points come from the camera, and
texture space, where they are the atlas coordinates: there is one rasteriser.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher, Strip
from sequences import Camera
from swimlab.render.kernels.raster import NEAR, rasterise
from swimlab.render.kernels.structs import Edges, Planes
from swimlab.render.mesh import Doubles, Mesh

NOWHERE = (np.inf, -np.inf)
"""The range of y of a triangle that is not drawn."""


@dataclass(frozen=True)
class Triangles:
    """Triangles ready for the rasteriser, on the device: M edge matrices, M plane matrices, M ranges of y (px).

    back_faces, slivers: how many of the mesh's triangles are not drawn, since they face away or are too thin.
    """

    edges: Any
    planes: Any
    bounds: Any
    back_faces: int = 0
    slivers: int = 0


def screen_projection(camera: Camera, height: int, width: int) -> Doubles:
    """The 3x3 matrix that takes a position relative to the eye to homogeneous image px (x w, y w, w).

    Principal point at the picture's centre, square pixels, y down, w in m along the camera axis.
    """
    focal = camera.focal(height)
    intrinsics = np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])
    return np.asarray(intrinsics @ camera.basis(), np.float64)


def on_screen(
    launcher: Launcher, mesh: Mesh, projection: Doubles, *, carried: Doubles | None = None, thinnest: float = 0.0
) -> Triangles:
    """The mesh as the camera sees it, without triangles that face away.

    carried: [N, 3], values to interpolate in place of the positions. thinnest: px; loose triangles of a lesser
    altitude on the screen are not drawn either, as sampling would hit them only now and then.
    """
    points = mesh.positions @ projection.T
    facing = mesh.facing
    slivers = facing & mesh.loose
    slivers[slivers] = _altitudes(points[mesh.triangles[slivers]]) < thinnest
    mesh = mesh if carried is None else replace(mesh, positions=carried)
    triangles = set_up(launcher, points, mesh, np.arange(len(mesh.triangles)), drawn=facing & ~slivers)
    return replace(triangles, back_faces=int(np.sum(~facing)), slivers=int(np.sum(slivers)))


@dataclass(frozen=True)
class Charts:
    """Charts in texture space: their triangles, and of each chart the first and one past the last of these.

    widened: whether a chart was widened to a texel.
    """

    triangles: Triangles
    ranges: NDArray[np.int32]
    widened: NDArray[np.bool_]


def in_texture(launcher: Launcher, mesh: Mesh, segments: Sequence[int], texels: Doubles) -> Charts:
    """Some segments, in order, with their atlas coordinates as positions; (0, 0) to (1, 1) is a whole target.

    Triangles that face away from the eye are left out (Sloan & Baker, Drawing polygons on the backside). texels: the
    side of a texel of each target. A chart narrower than that is widened to it about its middle, as it might hold no
    texel's centre.
    """
    mine = np.isin(mesh.segments, segments)
    chosen = np.flatnonzero(mine & mesh.facing)
    owners = mesh.segments[chosen]
    ranges = np.stack([np.searchsorted(owners, segments, side=side) for side in ("left", "right")], axis=1)
    low, high = _extents(mesh, chosen, ranges)
    widened = np.any(high - low < texels[:, None], axis=1)
    points = np.concatenate([mesh.uv, np.ones((len(mesh.uv), 1))], axis=1)
    for k in np.flatnonzero(widened).tolist():
        vertices = np.unique(mesh.triangles[chosen[slice(*ranges[k])]])
        middle = (low[k] + high[k]) / 2
        wider = np.maximum(1.0, texels[k] / np.maximum(high[k] - low[k], 1e-12))
        points[vertices, :2] = middle + (mesh.uv[vertices] - middle) * wider
    triangles = replace(set_up(launcher, points, mesh, chosen), back_faces=int(np.sum(mine & ~mesh.facing)))
    return Charts(triangles, ranges.astype(np.int32), widened)


def _extents(mesh: Mesh, chosen: NDArray[np.int64], ranges: NDArray[np.int64]) -> tuple[Doubles, Doubles]:
    """Lowest and highest uv of each range of the chosen triangles; 0 and 1 where it has none."""
    low, high = np.zeros((len(ranges), 2)), np.ones((len(ranges), 2))
    some = ranges[:, 0] < ranges[:, 1]
    if some.any():
        corners = mesh.uv[mesh.triangles[chosen]]
        low[some] = np.minimum.reduceat(corners.min(axis=1), ranges[some, 0])
        high[some] = np.maximum.reduceat(corners.max(axis=1), ranges[some, 0])
    return low, high


def narrowest(mesh: Mesh, segments: Sequence[int]) -> Doubles:
    """The least extent in u or v of the triangles of each of some segments in sight, in order, that face the eye."""
    chosen = np.flatnonzero(np.isin(mesh.segments, segments) & mesh.facing)
    corners = mesh.uv[mesh.triangles[chosen]]
    extent = np.min(corners.max(axis=1) - corners.min(axis=1), axis=1)
    return np.asarray(np.minimum.reduceat(extent, np.searchsorted(mesh.segments[chosen], segments)))


def set_up(
    launcher: Launcher,
    points: Doubles,
    mesh: Mesh,
    chosen: NDArray[np.int64],
    *,
    drawn: NDArray[np.bool_] | None = None,
) -> Triangles:
    """Edge functions and plane equations (Olano & Greer 1997) of the chosen triangles.

    points: [N, 3], homogeneous image coordinates of the mesh's vertices. With e0 = v1 x v2 and so on and d = v0 . e0,
    1/w = sum e_k / d and a/w = sum a_k e_k / d. A triangle seen from behind has all signs turned; one without area
    covers nothing, nor does one that is not to be `drawn` ([len(chosen)]; default: all are): its place stays empty.
    """
    corners = mesh.triangles[chosen]
    v = points[corners]
    edges = np.stack([_cross(v[:, 1], v[:, 2]), _cross(v[:, 2], v[:, 0]), _cross(v[:, 0], v[:, 1])], axis=1)
    determinant = np.sum(v[:, 0] * edges[:, 0], axis=1)
    edges *= np.sign(determinant)[:, None, None]
    attributes = np.concatenate([mesh.uv, mesh.positions, mesh.slope[:, None]], axis=1)[corners]
    with_one = np.concatenate([np.ones((*corners.shape, 1)), attributes], axis=2)
    area = np.where(determinant == 0.0, 1.0, np.abs(determinant))
    planes = np.einsum("mka,mkc->mac", with_one, edges) / area[:, None, None]
    bounds = _vertical_bounds(v)
    if drawn is not None:
        bounds[~drawn] = NOWHERE
    return Triangles(
        edges=launcher.array(edges, Edges),
        planes=launcher.array(planes, Planes),
        bounds=launcher.array(bounds, wp.vec2d),
    )


def visibility(
    launcher: Launcher, triangles: Triangles, grid: Any, strip: Strip, n: int = 1, *, into: Any = None
) -> Any:
    """The index of the triangle seen by each of the n x n samples of a strip's pixels, -1 for none.

    Returns an int32 device array [strip.rows * n, grid.width], which is `into` where that is given.
    """
    visible = launcher.empty((strip.rows * n, grid.width), wp.int32) if into is None else into
    inputs = [strip.first * n, grid, triangles.edges, triangles.planes, triangles.bounds, visible]
    launcher.launch(rasterise, strip.rows * n, inputs)
    return visible


def _cross(a: Doubles, b: Doubles) -> Doubles:
    """a x b such that _cross(b, a) is exactly its opposite, bit by bit."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )


def _vertical_bounds(v: Doubles) -> Doubles:
    """Lowest and highest y of each triangle, px; everything where a vertex is not in front of the near plane."""
    w = v[:, :, 2]
    in_front = np.all(w > NEAR, axis=1)
    y = v[:, :, 1] / np.where(w > NEAR, w, 1.0)
    low = np.where(in_front, y.min(axis=1), -np.inf)
    high = np.where(in_front, y.max(axis=1), np.inf)
    return np.stack([low, high], axis=1)


def _altitudes(v: Doubles) -> Doubles:
    """Least altitude of each triangle [K, 3, 3] on the screen, px; infinite where it is not all before the eye."""
    w = v[:, :, 2:]
    in_front = np.all(w > NEAR, axis=(1, 2))
    corner = v[:, :, :2] / np.where(w > NEAR, w, 1.0)
    side = corner[:, (1, 2, 0)] - corner
    area = np.abs(side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0])
    longest = np.linalg.norm(side, axis=2).max(axis=1, initial=0.0)
    return np.where(in_front, area / np.where(longest > 0.0, longest, 1.0), np.inf)
