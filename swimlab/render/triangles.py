"""Triangle set-up: from vertices in homogeneous image coordinates to edge functions and plane equations.

All in double precision, before the rasteriser. The same code serves the screen, where points come from the camera, and
texture space, where they are the atlas coordinates: there is one rasteriser.
"""

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


def in_texture(launcher: Launcher, mesh: Mesh, segment: int, texel: float) -> Triangles:
    """One segment's triangles drawn with atlas coordinates as positions; the image is the unit square.

    Triangles that face away from the eye are left out (Sloan & Baker, Drawing polygons on the backside). A chart
    narrower than a texel is widened to one about its middle, as it might hold no texel's centre.
    """
    mine = mesh.segments == segment
    chosen = np.flatnonzero(mine & mesh.facing)
    chart = mesh.uv[mesh.triangles[chosen]].reshape(-1, 2)
    low, high = chart.min(axis=0), chart.max(axis=0)
    wider = np.maximum(1.0, texel / np.maximum(high - low, 1e-12))
    middle = (low + high) / 2
    points = np.concatenate([middle + (mesh.uv - middle) * wider, np.ones((len(mesh.uv), 1))], axis=1)
    return replace(set_up(launcher, points, mesh, chosen), back_faces=int(np.sum(mine & ~mesh.facing)))


def narrowest(mesh: Mesh, segment: int) -> float:
    """The least extent in u or v of a segment's triangles that face the eye."""
    corners = mesh.uv[mesh.triangles[(mesh.segments == segment) & mesh.facing]]
    return float(np.min(corners.max(axis=1) - corners.min(axis=1)))


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


def visibility(launcher: Launcher, triangles: Triangles, grid: Any, strip: Strip, n: int = 1) -> Any:
    """The index of the triangle seen by each of the n x n samples of a strip's pixels, -1 for none.

    Returns an int32 device array [strip.rows * n, grid.width].
    """
    visible = launcher.empty((strip.rows * n, grid.width), wp.int32)
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
