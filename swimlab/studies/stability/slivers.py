"""Triangles far thinner than a pixel: who owns a sample, and what it sees there."""

from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher, Strip
from swimlab.render.kernels.inspection import surfaces
from swimlab.render.kernels.structs import Grid
from swimlab.render.mesh import Mesh
from swimlab.render.triangles import set_up, visibility
from swimlab.studies.stability.twin import Doubles

SIDE = 12
LEFT, TOP, BOTTOM = 3.3137, 1.3, 10.7
"""Where the strip of slivers begins, px."""
WIDTHS = (1.0, 1e-2, 1e-3, 1e-4)
MOST = 40_000
"""Slivers of a strip."""
EXTENT = 4.0
"""Width of a strip, px."""


class Slivers(NamedTuple):
    """A strip of a surface seen in perspective, cut into slivers.

    triangles: how many. wrong: samples within it that none owns, or beyond it that one does. off: largest error of the
    place on the surface that a sample sees, px. naive: samples that edge functions in single precision give to no
    triangle or to two.
    """

    triangles: int
    wrong: int
    off: float
    naive: int


def strips(launcher: Launcher) -> dict[float, Slivers]:
    """By the slivers' width, px."""
    return {width: _strip(launcher, width) for width in WIDTHS}


def _strip(launcher: Launcher, width: float) -> Slivers:
    count = min(MOST, int(np.ceil(EXTENT / width)))
    x = LEFT + width * np.arange(count + 1)
    # Nearer at its lower edge: depth makes texture coordinates bend between the two.
    near, far = 0.5, 2.0
    points = np.concatenate([_row(x, TOP) * far, _row(x, BOTTOM) * near])
    uv = np.stack([np.concatenate([x * far, x * near]), np.repeat([0.0, 1.0], count + 1)], axis=1)
    i, below = np.arange(count), count + 1
    halves = [np.stack([i, i + 1, i + 1 + below], axis=1), np.stack([i, i + 1 + below, i + below], axis=1)]
    triangles = np.concatenate(halves).astype(np.int32)
    zero = np.zeros(len(points))
    mesh = Mesh(points, uv, zero, triangles, np.zeros(len(triangles), np.int64), np.zeros(len(triangles), bool))
    grid: Any = Grid()
    grid.origin, grid.pitch, grid.width, grid.height = wp.vec2d(0.0, 0.0), wp.vec2d(1.0, 1.0), SIDE, SIDE
    ready = set_up(launcher, points, mesh)
    visible = visibility(launcher, ready, grid, Strip(0, SIDE))
    found, dx, dy = (launcher.zeros((SIDE, SIDE), wp.vec2d) for _ in range(3))
    place = launcher.zeros((SIDE, SIDE), wp.vec3d)
    launcher.launch(surfaces, (SIDE, SIDE), [grid, visible, ready.planes, found, dx, dy, place])
    hit = visible.numpy() >= 0
    row, column = np.mgrid[:SIDE, :SIDE] + 0.5
    inside = (column > x[0]) & (column < x[-1]) & (row > TOP) & (row < BOTTOM)
    share = (row - TOP) / (BOTTOM - TOP)
    depth = 1 / ((1 - share) / far + share / near)
    exact = np.stack([column * depth, share / near * depth], axis=-1)
    off = np.abs((found.numpy() - exact) / depth[..., None] * [1, SIDE])[hit & inside].max(initial=0.0)
    naive = _naively(points[triangles].astype(np.float32), np.stack([column, row], axis=-1)[inside])
    return Slivers(len(triangles), int(np.sum(hit != inside)), float(off), int(np.sum(naive != 1)))


def _row(x: NDArray[np.floating], y: float) -> Doubles:
    return np.stack([x, np.full_like(x, y), np.ones_like(x)], axis=1)


def _naively(corners: NDArray[np.float32], samples: Doubles) -> NDArray[np.int64]:
    """How many triangles own each sample by edge functions of projected corners in single precision."""
    projected = corners[..., :2] / corners[..., 2:]
    x, y = samples.astype(np.float32).T[..., None]
    inside = np.ones((len(samples), len(corners)), bool)
    for k in range(3):
        a, b = projected[:, k], projected[:, (k + 1) % 3]
        inside &= (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0]) >= 0
    return np.asarray(inside.sum(axis=1))
