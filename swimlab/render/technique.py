"""What a technique is, and how pixel-shading techniques are made of a texture filter."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray
from pydantic import Field

from metrics.kernels.launch import Scratch, Strip
from swimlab.render.inputs import BOX, Inputs
from swimlab.render.kernels.samples import draw_samples, shade_samples
from swimlab.render.kernels.texture_filter import TextureFilter, anisotropic_to
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.triangles import Triangles

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
    recursive: whether a frame that is rendered alone costs all frames before it.
    """

    name: str
    summary: str
    source: str
    render: Render
    settings: type[Settings] = Settings
    memory: Callable[[], Render] | None = None
    recursive: bool = False

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
    launcher, triangles, grid = shot.launcher, shot.triangles, shot.grid(n, jittered=jittered)
    size = (shot.view.height, shot.view.width)
    picture = launcher.unset(size, wp.vec4)
    error = launcher.unset(size, wp.vec4) if n > 1 else picture  # to which nothing is written for one sample
    shaded = launcher.unset((shot.view.height,), wp.int32)
    core = core_of(shot, texture_filter, inputs)
    given = [n, grid, triangles.edges, triangles.planes, triangles.bounds, *core.arguments, picture, error, shaded]
    launcher.over(
        shot.view.height,
        draw_samples(core.fill, core.shade, core.width),
        (),
        given,
        n=n,
        own=Scratch(grid.width, wp.int32, n),
    )
    return Picture(to_image(picture), to_image(error) if n > 1 else None, total(shaded))


class MomentSettings(Settings):
    """How far a footprint may be stretched."""

    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis")


def moment_technique(inputs: Inputs, *, summary: str, source: str) -> Technique:
    """The technique of some inputs: they are read anisotropically at the pixel's centre and shaded once."""

    def render(shot: Shot, settings: MomentSettings) -> Picture:
        return render_samples(shot, anisotropic_to(settings.anisotropy), n=1, inputs=inputs)

    return Technique(name=inputs.name, summary=summary, source=source, render=render, settings=MomentSettings)


class Core(NamedTuple):
    """What kernels of shading are made of: fill and shade a packet of texels of `width` floats; and its arguments.

    arguments: texels, the shape of their chain, the sun.
    """

    fill: wp.Function
    shade: wp.Function
    width: int
    arguments: list[Any]


def core_of(shot: Shot, texture_filter: TextureFilter, inputs: Inputs) -> Core:
    """The shading of a shot's material from some inputs, or from those that stand in for them."""
    inputs = shot.inputs(inputs)
    chain = shot.material.chain(inputs)
    width = chain.floats
    fill = inputs.after(texture_filter.fill(width, shot.launcher.device), width, shot.launcher.device)
    return Core(fill, shot.shade_packet(inputs, width), width, [chain.texels, chain.shape, shot.sun])


def shading(shot: Shot, texture_filter: TextureFilter, n: int, inputs: Inputs = BOX) -> Callable[..., None]:
    """The function that shades a strip of n x n samples a pixel.

    Its arguments are grid, triangles, visible (see `visibility`), strip, picture [H, W], error ([H, W] if n > 1) and
    shaded ([H], samples). It adds to rows of picture and error and fills rows of shaded, from `row` on (default: the
    strip's first). Kernels are made here, once, and not in the threads that call the function.
    """
    launcher, core = shot.launcher, core_of(shot, texture_filter, inputs)
    kernel = shade_samples(core.fill, core.shade, core.width)

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
        arguments += [*core.arguments, picture, error, shaded]
        launcher.launch(kernel, strip.rows, arguments)

    return shade


def to_image(picture: Any) -> Image:
    """A device picture [H, W] of 4-vectors as floats [H, W, 4]."""
    return np.asarray(on_host(picture), np.float32)


def total(counts: Any) -> int:
    """The sum of counts on the device."""
    return int(on_host(counts).sum(dtype=np.int64))


def on_host(array: Any) -> NDArray[Any]:
    """An array's values, to be read: the same memory where it is the host's."""
    if isinstance(array, np.ndarray):
        return array
    return np.asarray(array) if array.device.is_cpu else np.asarray(array.numpy())
