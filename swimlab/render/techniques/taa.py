"""Temporal anti-aliasing as engines ship it: one jittered sample a frame, blended into a history that moves along.

Frame t is defined by a recursion from frame -preroll, independent of what was rendered before. The picture of frame s
is h + blend (x - h). x is pixel-aniso at the jitter of s. h is the picture of s - 1, read along the exact motion and
clamped to the colours of x nearby. Where the surface was off-screen or hidden at s - 1 the picture is x. In a sequence
that resizes each frame stands alone: it is the recursion over preroll + 1 jitters of its own still view.
"""

from functools import cache
from typing import Any, Literal

import numpy as np
import warp as wp
from pydantic import Field

from metrics.kernels.launch import Scratch
from sequences import View
from swimlab.render.geometry import seen_from
from swimlab.render.inputs import BOX
from swimlab.render.kernels.accumulation import resolve_with, sample_with
from swimlab.render.kernels.clamp import CLAMPS
from swimlab.render.kernels.history import READS
from swimlab.render.kernels.texture_filter import anisotropic_to
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, core_of, to_image, total


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


class Accumulation:
    """A renderer that remembers its last frame, so that the frame after it costs one frame and not the recursion."""

    def __init__(self) -> None:
        self._recursion: Recursion | None = None
        self._frame = 0

    def __call__(self, shot: Shot, settings: TaaSettings) -> Picture:
        """The shot's picture; all shots of one renderer are of one sequence, under one set of settings."""
        if shot.sequence.motion.resizes:
            return still(shot, settings)
        recursion, first = self._recursion, self._frame + 1
        if recursion is None or shot.frame < first:
            recursion, first = Recursion(shot, settings), -settings.preroll
        self._recursion = None  # of which nothing is known if a frame fails
        for frame in range(first, shot.frame + 1):
            recursion.advance(shot.at(frame), shot.sequence.view(frame - 1), frame)
        self._recursion, self._frame = recursion, shot.frame
        return Picture(to_image(recursion.picture), shaded=recursion.shaded)


def still(shot: Shot, settings: TaaSettings) -> Picture:
    """The recursion over one view."""
    recursion, shaded = Recursion(shot, settings), 0
    for step in range(-settings.preroll, 1):
        recursion.advance(shot, shot.view, step)
        shaded += recursion.shaded
    return Picture(to_image(recursion.picture), shaded=shaded)


class Recursion:
    """Steps of the recursion, over frames of one size. Arrays that only the next step needs are used again.

    picture: [H, W], premultiplied, on the device; each step makes a new one.
    """

    def __init__(self, shot: Shot, settings: TaaSettings) -> None:
        launcher, size = shot.launcher, (shot.view.height, shot.view.width)
        core = core_of(shot, anisotropic_to(settings.anisotropy), BOX)
        self._sample = sample_with(core.fill, core.shade, core.width, launcher.device)
        self._resolve = resolve_with(READS[settings.history], CLAMPS[settings.clamp], launcher.device)
        self._texels, self._chain, _ = core.arguments
        self._blend, self._jitters = settings.blend, jitters(settings.period)
        self._fresh, self._places = launcher.empty(size, wp.vec4), launcher.empty(size, wp.vec4)
        # 1/w at pixels' centres, of this step and of the one before.
        self._nearness, self._nearness_before = launcher.empty(size, wp.float32), launcher.empty(size, wp.float32)
        self._shaded = launcher.unset((shot.view.height,), wp.int32)
        self.picture: Any = None

    @property
    def shaded(self) -> int:
        """Samples shaded for the last step."""
        return total(self._shaded)

    def advance(self, shot: Shot, before: View, step: int) -> None:
        """One step: a new sample of each pixel, jittered by `step`, and the history, which is of `before`."""
        launcher, view, triangles, grid = shot.launcher, shot.view, shot.triangles, shot.grid()
        x, y = self._jitters[step % len(self._jitters)]
        origin = wp.vec2d(view.origin[0] + x * view.pitch[0], view.origin[1] + y * view.pitch[1])
        picture = launcher.unset((view.height, view.width), wp.vec4)
        fresh = picture if self.picture is None else self._fresh
        sample = launcher.laid_out(
            view.height,
            self._sample,
            (),
            [
                origin,
                grid,
                seen_from(shot, before),
                triangles.edges,
                triangles.planes,
                triangles.bounds,
                self._texels,
                self._chain,
                shot.sun,
                fresh,
                self._shaded,
                self._nearness,
                self._places,
            ],
            own=Scratch(view.width, wp.int32),
        )
        if self.picture is None:
            sample()
        else:
            history = [self.picture, self._nearness_before]
            resolve = launcher.laid_out(
                view.height,
                self._resolve,
                (),
                [self._blend, fresh, self._nearness, self._places, *history, picture],
                own=Scratch(view.width, wp.vec4, 2),
            )
            sample()  # when all is laid out, as it empties the caches
            resolve()
        self.picture = picture
        self._nearness, self._nearness_before = self._nearness_before, self._nearness


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
