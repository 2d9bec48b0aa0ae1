"""Triangle set-up: from vertices in homogeneous image coordinates to edge functions and plane equations.

All in double precision, before the rasteriser. The same code serves the screen, where points come from the camera, and
texture space, where they are the atlas coordinates: there is one rasteriser.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from sequences import Camera
from swimlab.kernels.raster import NEAR, rasterise
from swimlab.kernels.structs import Edges, Planes
from swimlab.launch import Launcher, Strip
from swimlab.mesh import Doubles, Mesh


@dataclass(frozen=True)
class Triangles:
    """Triangles ready for the rasteriser, on the device: M edge matrices, M plane matrices, M ranges of y (px)."""

    edges: Any
    planes: Any
    bounds: Any


def screen_projection(camera: Camera, height: int, width: int) -> Doubles:
    """The 3x3 matrix that takes a position relative to the eye to homogeneous image px (x w, y w, w).

    Principal point at the picture's centre, square pixels, y down, w in m along the camera axis.
    """
    focal = camera.focal(height)
    intrinsics = np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])
    return np.asarray(intrinsics @ camera.basis(), np.float64)


def on_screen(launcher: Launcher, mesh: Mesh, projection: Doubles) -> Triangles:
    """The mesh as the camera sees it."""
    return set_up(launcher, mesh.positions @ projection.T, mesh, np.arange(len(mesh.triangles)))


def in_texture(launcher: Launcher, mesh: Mesh, segment: int) -> Triangles:
    """One segment's triangles drawn with atlas coordinates as positions; the image is the unit square."""
    points = np.concatenate([mesh.uv, np.ones((len(mesh.uv), 1))], axis=1)
    return set_up(launcher, points, mesh, np.flatnonzero(mesh.segments == segment))


def set_up(launcher: Launcher, points: Doubles, mesh: Mesh, chosen: NDArray[np.int64]) -> Triangles:
    """Edge functions and plane equations (Olano & Greer 1997) of the chosen triangles.

    points: [N, 3], homogeneous image coordinates of the mesh's vertices. With e0 = v1 x v2 and so on and d = v0 . e0,
    1/w = sum e_k / d and a/w = sum a_k e_k / d. A triangle seen from behind has all signs turned; one without area
    covers nothing.
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
    return Triangles(
        edges=launcher.array(edges, Edges),
        planes=launcher.array(planes, Planes),
        bounds=launcher.array(_vertical_bounds(v), wp.vec2d),
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
