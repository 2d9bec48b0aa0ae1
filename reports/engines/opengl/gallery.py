"""A gallery as triangles: a bumpy floor and wall, a fence of thin bars and a column; metres, y up."""

import numpy as np
from numpy.typing import NDArray

FLOOR, WALL, BAR, COLUMN = range(4)
SIDE = 256
"""Texels a side of the normal map."""

Array = NDArray[np.float64]


def _quad(corner: Array, along: Array, across: Array, surface: int) -> Array:
    """Two triangles, [6, 7]: place, normal, surface."""
    places = [corner + a * along + b * across for a, b in ((0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1))]
    normal = np.cross(along, across)
    return np.array([[*place, *normal / np.linalg.norm(normal), surface] for place in places])


def _post(foot: tuple[float, float, float], width: float, height: float, surface: int) -> Array:
    """Four upright sides."""
    x, z = np.array([width, 0.0, 0.0]), np.array([0.0, 0.0, width])
    up = np.array([0.0, height, 0.0])
    base = np.array(foot) - (x + z) / 2
    sides = ((base + z, x), (base + x + z, -z), (base + x, -x), (base, z))
    return np.concatenate([_quad(corner, along, up, surface) for corner, along in sides])


def still() -> Array:
    """What does not move, [n, 7]."""
    x, y, z = np.diag([60.0, 12.0, -24.0])
    floor = _quad(np.array([-30.0, 0, 12]), x, z, FLOOR)
    wall = _quad(np.array([-30.0, 0, -10]), x, y, WALL)
    bars = [_post((-6 + 0.2 * bar, 0, -6), 0.015, 1.2, BAR) for bar in range(60)]
    return np.concatenate([floor, wall, *bars])


def column() -> Array:
    """What slides past, [n, 7]."""
    return _post((0, 0, -3), 0.7, 6, COLUMN)


def column_place(frame: int) -> tuple[float, float, float]:
    return -1.6 + 0.06 * frame, 0.0, 0.0


def normals() -> NDArray[np.float32]:
    """[SIDE, SIDE, 4]: unit normals of random bumps, z up; they repeat. The last is free."""
    heights = np.random.default_rng(7).random((SIDE, SIDE))
    dx, dy = ((np.roll(heights, -1, axis) - np.roll(heights, 1, axis)) / 4 for axis in (1, 0))
    bumps = np.dstack([-dx, -dy, np.ones_like(dx)])
    bumps /= np.linalg.norm(bumps, axis=2, keepdims=True)
    return np.dstack([bumps, np.ones_like(dx)]).astype(np.float32)


def camera(frame: int) -> tuple[Array, Array]:
    """Where the eye is, and from the world to its axes, [4, 4]: it drifts and turns; it looks along -z."""
    eye = np.array([0.023 * frame, 1.7 + 0.004 * frame, 4 - 0.03 * frame])
    pitch, yaw = -0.12, 0.0015 * frame
    lift = np.array([[1, 0, 0], [0, np.cos(pitch), np.sin(pitch)], [0, -np.sin(pitch), np.cos(pitch)]])
    turn = np.array([[np.cos(yaw), 0, -np.sin(yaw)], [0, 1, 0], [np.sin(yaw), 0, np.cos(yaw)]])
    view = np.eye(4)
    view[:3, :3] = lift @ turn
    view[:3, 3] = -view[:3, :3] @ eye
    return eye, view


def lens(size: tuple[int, int], shift: tuple[float, float] = (0.0, 0.0)) -> Array:
    """From the eye's axes to clip space, [4, 4]; all samples moved by px right and up."""
    width, height = size
    focal, near, far = 1 / np.tan(np.radians(45) / 2), 0.1, 100.0
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = focal * height / width, focal
    matrix[2, 2:] = (far + near) / (near - far), 2 * far * near / (near - far)
    matrix[3, 2] = -1
    matrix[:2, 2] = 2 * shift[0] / width, 2 * shift[1] / height
    return matrix
