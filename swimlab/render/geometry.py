"""The geometry of a frame: coverage, exact motion and depth of each pixel."""

from typing import Any

import warp as wp

from metrics.kernels.launch import Strip
from sequences import View
from swimlab.render.kernels.geometry import Previous, describe
from swimlab.render.shot import Shot
from swimlab.render.triangles import screen_projection, visibility
from swimlab.runs.frames import Geometry

COVERAGE_CELLS = 8
"""Coverage is counted on a grid of this many cells a side in each pixel."""


def describe_geometry(shot: Shot) -> Geometry:
    """Coverage, motion since the previous frame (frame 0 as if from t = -1) and depth, from analytic positions."""
    launcher, grid, n = shot.launcher, shot.grid(), COVERAGE_CELLS
    size = (shot.view.height, shot.view.width)
    coverage = launcher.empty(size, wp.float32)
    motion = launcher.empty(size, wp.vec2)
    depth = launcher.empty(size, wp.float32)
    previous = seen_from(shot, shot.sequence.view(shot.frame - 1))

    def fill(strip: Strip) -> None:
        centres = visibility(launcher, shot.triangles, grid, strip)
        cells = visibility(launcher, shot.triangles, shot.grid(n), strip, n)
        inputs = [
            strip.first,
            n,
            grid,
            shot.triangles.planes,
            centres,
            cells,
            previous,
            coverage,
            motion,
            depth,
        ]
        launcher.launch(describe, (strip.rows, shot.view.width), inputs)

    launcher.each(launcher.strips(shot.view.height, n), fill)
    return Geometry(coverage=coverage.numpy(), motion=motion.numpy(), depth=depth.numpy())


def seen_from(shot: Shot, before: View) -> Previous:
    """Another view of the sequence, usually the previous frame's, as kernels take it to find where a surface was."""
    road, camera = shot.sequence.scene.road, shot.view.camera
    width, height = shot.sequence.size

    def make() -> tuple[Any, Any]:
        projection = wp.mat33d(*screen_projection(before.camera, height, width).ravel().tolist())
        return projection, wp.vec3d(*(camera.eye(road) - before.camera.eye(road)).tolist())

    previous = Previous()
    eyes = road, camera, before.camera, width, height
    previous.projection, previous.offset = shot.kept("eye before", eyes, make)
    previous.origin = wp.vec2d(*before.origin)
    previous.pitch = wp.vec2d(*before.pitch)
    return previous
