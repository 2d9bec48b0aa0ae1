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

from metrics.kernels.launch import Launcher, OnRows, Strip
from sequences import Camera
from swimlab.render.kernels.raster import NEAR, rasterise
from swimlab.render.kernels.set_up import set_up_triangles
from swimlab.render.kernels.structs import Edges, Planes
from swimlab.render.mesh import Doubles, Mesh

MANY_TRIANGLES = 1024
"""Triangles that are worth another thread."""


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


def on_screen(launcher: Launcher, mesh: Mesh, projection: Doubles, *, thinnest: float = 0.0) -> Triangles:
    """The mesh as the camera sees it, without triangles that face away.

    thinnest: px; loose triangles of a lesser altitude on the screen are not drawn either, as sampling would hit them
    only now and then.
    """
    points = mesh.positions @ projection.T
    facing = mesh.facing
    slivers = np.zeros_like(facing)
    if thinnest > 0.0:
        slivers = facing & mesh.loose
        slivers[slivers] = _altitudes(points[mesh.triangles[slivers]]) < thinnest
    triangles = set_up(launcher, points, mesh, drawn=facing & ~slivers)
    return replace(
        triangles, back_faces=len(facing) - int(np.count_nonzero(facing)), slivers=int(np.count_nonzero(slivers))
    )


def set_up(
    launcher: Launcher,
    points: Doubles,
    mesh: Mesh,
    chosen: NDArray[np.int64] | slice = slice(None),
    *,
    drawn: NDArray[np.bool_] | None = None,
) -> Triangles:
    """Edge functions and plane equations of the chosen triangles, as `set_up_triangles` has them.

    points: [N, 3], homogeneous image coordinates of the mesh's vertices. A triangle without area covers nothing, nor
    does one that is not to be `drawn` (of the chosen; default: all are): its place stays empty.
    """
    corners = mesh.triangles[chosen]
    inputs = [launcher.lent(points, wp.vec3d), launcher.lent(mesh.uv, wp.vec2d)]
    inputs += [launcher.lent(mesh.positions, wp.vec3d), launcher.lent(mesh.slope, wp.float64)]
    inputs += [launcher.lent(corners, wp.vec3i)]
    inputs += [launcher.lent(np.ones(len(corners), bool) if drawn is None else drawn, wp.bool)]
    ready, set_up_all = to_set_up(launcher, len(corners), inputs)
    set_up_all()
    return ready


def to_set_up(launcher: Launcher, count: int, inputs: Sequence[Any]) -> tuple[Triangles, OnRows]:
    """So many triangles, and what sets them up from the first inputs of `set_up_triangles`."""
    ready = Triangles(*[launcher.unset((count,), dtype) for dtype in (Edges, Planes, wp.vec2d)])
    given = [*inputs, ready.edges, ready.planes, ready.bounds]
    return ready, launcher.laid_out(count, set_up_triangles, (), given, strip=MANY_TRIANGLES)


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


def _altitudes(v: Doubles) -> Doubles:
    """Least altitude of each triangle [K, 3, 3] on the screen, px; infinite where it is not all before the eye."""
    w = v[:, :, 2:]
    in_front = np.all(w > NEAR, axis=(1, 2))
    corner = v[:, :, :2] / np.where(w > NEAR, w, 1.0)
    side = corner[:, (1, 2, 0)] - corner
    area = np.abs(side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0])
    longest = np.linalg.norm(side, axis=2).max(axis=1, initial=0.0)
    return np.where(in_front, area / np.where(longest > 0.0, longest, 1.0), np.inf)
