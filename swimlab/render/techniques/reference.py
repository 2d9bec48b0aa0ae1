"""The reference: shade many jittered samples a pixel from the finest level, average them, and estimate the error."""

from math import isqrt
from typing import Any, Literal

import numpy as np
import warp as wp
from pydantic import Field

from metrics.kernels.launch import Strip
from swimlab.render.kernels.pixel_filter import FILTERS, gather_with
from swimlab.render.kernels.texture_filter import FINEST
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, render_samples, shading, to_image
from swimlab.render.triangles import visibility


class ReferenceSettings(Settings):
    """The filter over which a pixel is averaged."""

    filter: Literal["box", "gaussian", "mitchell"] = Field(
        "box", description="pixel filter: box (1 px wide), gaussian (sigma 1/2 px) or mitchell (B = C = 1/3)"
    )


def render(shot: Shot, settings: ReferenceSettings) -> Picture:
    """n x n stratified samples a pixel, n^2 = `shot.samples`, at the same sub-pixel places in every frame."""
    n = isqrt(shot.samples)
    if settings.filter == "box":
        return render_samples(shot, FINEST, n=n, jittered=True)
    return render_filtered(shot, settings.filter, n)


def render_filtered(shot: Shot, name: str, n: int) -> Picture:
    """Shade the samples of the picture and of a margin around it, strip by strip, and gather them into pixels."""
    launcher, view = shot.launcher, shot.view
    weight, reach = FILTERS[name]
    gather = gather_with(weight, reach)
    grid: Any = shot.grid(n, jittered=True)
    grid.origin = wp.vec2d(view.origin[0] - reach * view.pitch[0], view.origin[1] - reach * view.pitch[1])
    grid.width, grid.height = (view.width + 2 * reach) * n, (view.height + 2 * reach) * n
    picture = launcher.empty((view.height, view.width), wp.vec4)
    error = launcher.empty((view.height, view.width), wp.vec4)
    nothing = launcher.empty((0, 0), wp.vec4)
    shaded = np.zeros(view.height, np.int64)
    shade = shading(shot, FINEST, 1)
    triangles = shot.triangles

    def fill(strip: Strip) -> None:
        rows = (strip.rows + 2 * reach) * n
        cells = launcher.zeros((rows, grid.width), wp.vec4)
        count = launcher.empty(rows, wp.int32)
        band = Strip(strip.first * n, rows)
        visible = visibility(launcher, triangles, grid, band)
        shade(grid, triangles, visible, band, cells, nothing, count, row=0)
        shaded[strip.first] = count.numpy().sum(dtype=np.int64)
        inputs = [strip.first, n, grid, cells, picture, error]
        launcher.launch(gather, (strip.rows, view.width), inputs)

    launcher.each(launcher.strips(view.height), fill)
    return Picture(to_image(picture), to_image(error), int(shaded.sum()))


TECHNIQUE = Technique(
    name="reference",
    summary="stratified supersampling of the shading itself",
    source="Cook 1986, Stochastic Sampling in Computer Graphics",
    render=render,
    settings=ReferenceSettings,
)
