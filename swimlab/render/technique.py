"""What a technique is, and how pixel-shading techniques are made of a texture filter."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray
from pydantic import Field

from metrics.kernels.launch import Strip
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.packet import resolved
from swimlab.render.kernels.samples import shade_samples
from swimlab.render.kernels.texture_filter import TextureFilter, anisotropic_to
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.triangles import Triangles, visibility

Image = NDArray[np.float32]


class Picture(NamedTuple):
    """A rendered frame.

    rgba: [H, W, 4], linear, premultiplied. error: its standard error where known, same layout. shaded: how many
    samples, texels or vertices the reflectance model was evaluated for.
    """

    rgba: Image
    error: Image | None = None
    shaded: int = 0


Render = Callable[[Shot, Any], Picture]
"""From a shot and a technique's settings to the picture, which depends on nothing else."""


@dataclass(frozen=True)
class Technique:
    """An order of filtering and shading, with its name, one line about it, its source and its settings.

    memory: for a technique whose frames build on earlier ones, makes a renderer that keeps what the next frame needs.
        Its pictures are the same, and frames rendered in order cost one frame each.
    """

    name: str
    summary: str
    source: str
    render: Render
    settings: type[Settings] = Settings
    memory: Callable[[], Render] | None = None

    def begin(self) -> Render:
        """The renderer for a run: shots of one sequence under one set of settings."""
        return self.render if self.memory is None else self.memory()


def pixel_shading(texture_filter: Callable[[Any], TextureFilter]) -> Render:
    """Filter the inputs at the pixel's centre, by the filter that `texture_filter(settings)` makes, and shade once."""
    specialised = cache(texture_filter)

    def render(shot: Shot, settings: Settings) -> Picture:
        return render_samples(shot, specialised(settings), n=1)

    return render


def render_samples(
    shot: Shot, texture_filter: TextureFilter, *, n: int, jittered: bool = False, inputs: Inputs = BOX
) -> Picture:
    """Shade n x n samples a pixel and average them; with n > 1 the error is half the difference of two halves."""
    launcher = shot.launcher
    size = (shot.view.height, shot.view.width)
    picture = launcher.zeros(size, wp.vec4)
    error = launcher.zeros(size if n > 1 else (0, 0), wp.vec4)
    shaded = launcher.empty(size[0], wp.int32)
    grid, triangles = shot.grid(n, jittered=jittered), shot.triangles
    shade = shading(shot, texture_filter, n, inputs)

    def fill(strip: Strip) -> None:
        shade(grid, triangles, visibility(launcher, triangles, grid, strip, n), strip, picture, error, shaded)

    launcher.each(launcher.strips(size[0], n), fill)
    return Picture(to_image(picture), to_image(error) if n > 1 else None, int(shaded.numpy().sum(dtype=np.int64)))


class MomentSettings(Settings):
    """How far a footprint may be stretched."""

    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


def moment_technique(inputs: Inputs, *, summary: str, source: str) -> Technique:
    """The technique of some inputs: they are read anisotropically at the pixel's centre and shaded once."""

    def render(shot: Shot, settings: MomentSettings) -> Picture:
        return render_samples(shot, anisotropic_to(settings.anisotropy), n=1, inputs=inputs)

    return Technique(name=inputs.name, summary=summary, source=source, render=render, settings=MomentSettings)


def shading(shot: Shot, texture_filter: TextureFilter, n: int, inputs: Inputs = BOX) -> Callable[..., None]:
    """The function that shades a strip of n x n samples a pixel, of the screen or of a target in texture space.

    Its arguments are grid, triangles, visible (see `visibility`), strip, picture [H, W], error ([H, W] if n > 1) and
    shaded ([H], samples). It adds to rows of picture and error and fills rows of shaded, from `row` on (default: the
    strip's first). Kernels are made here, once, and not in the threads that call the function.
    """
    launcher, sun = shot.launcher, shot.sun
    inputs = shot.inputs(inputs)
    chain = shot.material.chain(inputs)
    width = chain.floats
    fill = texture_filter.fill(width, launcher.device)
    if inputs.resolve is not None:
        fill = resolved(fill, inputs.resolve, width)
    kernel = shade_samples(fill, shot.shade_packet(inputs, width), width)

    def shade(
        grid: Any,
        triangles: Triangles,
        visible: Any,
        strip: Strip,
        picture: Any,
        error: Any,
        shaded: Any,
        *,
        row: int | None = None,
    ) -> None:
        arguments = [strip.first, strip.first if row is None else row, n, grid, visible, triangles.planes]
        arguments += [chain.texels, chain.shape, sun, picture, error, shaded]
        launcher.launch(kernel, strip.rows, arguments)

    return shade


def to_image(picture: Any) -> Image:
    """A device picture [H, W] of 4-vectors as floats [H, W, 4]."""
    return np.asarray(picture.numpy(), np.float32)
