"""Temporal anti-aliasing as engines ship it: one jittered sample a frame, blended into a history that moves along.

Frame t is defined by a recursion from frame -preroll, independent of what was rendered before. The picture of frame s
is h + blend (x - h). x is pixel-aniso at the jitter of s. h is the picture of s - 1, read along the exact motion and
clamped to the colours of x nearby. Where the surface was off-screen or hidden at s - 1 the picture is x. In a sequence
that resizes each frame stands alone: it is the recursion over preroll + 1 jitters of its own still view.
"""

from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
import warp as wp
from pydantic import Field

from sequences import View
from swimlab.render.geometry import seen_from
from swimlab.render.inputs import BOX
from swimlab.render.kernels.accumulation import resolve_with, sample_with
from swimlab.render.kernels.clamp import CLAMPS
from swimlab.render.kernels.history import READS
from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, core_of, to_image


class TaaSettings(Settings):
    """How samples are jittered and blended."""

    blend: float = Field(0.1, gt=0, le=1, description="share of the new frame")
    history: Literal["bicubic", "bilinear"] = Field(
        "bicubic", description="how the history is read: Catmull-Rom or not"
    )
    clamp: Literal["box", "variance", "none"] = Field(
        "box", description="what of the history is believed: the range of 3 x 3 new pixels, or mean and deviation"
    )
    period: int = Field(16, ge=1, le=1024, description="frames after which the jitter repeats")
    preroll: int = Field(16, ge=0, le=1024, description="frames before frame 0 with which the history begins")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


class History(NamedTuple):
    """What the next frame needs of a frame, on the device.

    picture: [H, W], premultiplied. nearness: [H, W], 1/w at pixels' centres. shaded: [H], samples shaded for it.
    """

    frame: int
    picture: Any
    nearness: Any
    shaded: Any


class Accumulation:
    """A renderer that remembers its last frame, so that the frame after it costs one frame and not the recursion."""

    def __init__(self) -> None:
        self._last: History | None = None

    def __call__(self, shot: Shot, settings: TaaSettings) -> Picture:
        """The shot's picture; all shots of one renderer are of one sequence, under one set of settings."""
        if shot.sequence.motion.resizes:
            return still(shot, settings)
        last = self._last
        if last is not None and last.frame >= shot.frame:
            last = None
        for frame in range(-settings.preroll if last is None else last.frame + 1, shot.frame + 1):
            last = advance(shot.at(frame), shot.sequence.view(frame - 1), frame, last, settings)
        self._last = last
        return Picture(to_image(last.picture), shaded=int(last.shaded.numpy().sum(dtype=np.int64)))


def still(shot: Shot, settings: TaaSettings) -> Picture:
    """The recursion over one view."""
    last, shaded = None, 0
    for step in range(-settings.preroll, 1):
        last = advance(shot, shot.view, step, last, settings)
        shaded += int(last.shaded.numpy().sum(dtype=np.int64))
    return Picture(to_image(last.picture), shaded=shaded)


def advance(shot: Shot, before: View, step: int, last: History | None, settings: TaaSettings) -> History:
    """One step of the recursion: a new sample of each pixel, jittered by `step`, and the history, that of `before`."""
    launcher, view, triangles, grid = shot.launcher, shot.view, shot.triangles, shot.grid()
    size = (view.height, view.width)
    samples: Any = shot.grid()
    x, y = jitters(settings.period)[step % settings.period]
    samples.origin = wp.vec2d(view.origin[0] + x * view.pitch[0], view.origin[1] + y * view.pitch[1])
    core = core_of(shot, anisotropic_to(settings.anisotropy), BOX)
    fresh, shaded = launcher.empty(size, wp.vec4), launcher.empty(view.height, wp.int32)
    nearness, places = launcher.empty(size, wp.float32), launcher.empty(size, wp.vec4)
    launcher.over(
        view.height,
        sample_with(core.fill, core.shade, core.width, launcher.device),
        (),
        [
            samples,
            grid,
            seen_from(shot, before),
            triangles.edges,
            triangles.planes,
            triangles.bounds,
            *core.arguments,
            fresh,
            shaded,
            nearness,
            places,
        ],
        own=lambda rows: [launcher.empty((rows, view.width), wp.int32)],
    )
    if last is None:
        return History(step, fresh, nearness, shaded)
    picture = launcher.empty(size, wp.vec4)
    resolve = resolve_with(READS[settings.history], CLAMPS[settings.clamp], launcher.device)
    inputs = [settings.blend, fresh, nearness, places, last.picture, last.nearness, picture]
    launcher.over(
        view.height,
        resolve,
        (),
        inputs,
        own=lambda rows: [launcher.empty((2 * rows, view.width), wp.vec4)],
    )
    return History(step, picture, nearness, shaded)


@cache
def jitters(period: int) -> list[tuple[float, float]]:
    """Sub-pixel offsets, px: points 1 to `period` of Halton's sequence in bases 2 and 3, less their mean.

    The mean is subtracted so that the picture is not shifted. Halton 1960, On the efficiency of certain quasi-random
    sequences.
    """
    points = np.array([[halton(index, base) for base in (2, 3)] for index in range(1, period + 1)])
    return [(float(x), float(y)) for x, y in points - points.mean(axis=0)]


def halton(index: int, base: int) -> float:
    """The digits of `index` mirrored at the point: 1, 2, 3 in base 2 are 1/2, 1/4, 3/4."""
    value, share = 0.0, 1.0
    while index:
        index, digit = divmod(index, base)
        share /= base
        value += digit * share
    return value


def render(shot: Shot, settings: TaaSettings) -> Picture:
    """One frame by itself: the whole recursion."""
    return Accumulation()(shot, settings)


TECHNIQUE = Technique(
    name="taa",
    summary="pixel-aniso jittered from frame to frame, blended into a history that follows the true motion",
    source="Karis 2014, High Quality Temporal Supersampling; Salvi 2016, An Excursion in Temporal Supersampling",
    render=render,
    settings=TaaSettings,
    memory=Accumulation,
    recursive=True,
)
