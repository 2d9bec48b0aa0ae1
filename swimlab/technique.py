"""What a technique is, and how the pixel-shading ones are made of a texture filter."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from swimlab.kernels.samples import shade_samples
from swimlab.launch import Strip
from swimlab.shot import Shot
from swimlab.triangles import Triangles, visibility

Image = NDArray[np.float32]


class Settings(BaseModel):
    """Settings of a technique: plain values with defaults and bounds. This one has none."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Picture(NamedTuple):
    """A rendered frame: `rgba` [H, W, 4], linear, premultiplied; `error` its own standard error where known, alike."""

    rgba: Image
    error: Image | None = None


@dataclass(frozen=True)
class Technique:
    """An order of filtering and shading, with its name, one line about it, its source and its settings."""

    name: str
    summary: str
    source: str
    render: Callable[[Shot, Any], Picture]
    settings: type[Settings] = Settings


TextureFilter = Callable[[Any], wp.Function]


def pixel_shading(texture_filter: TextureFilter) -> Callable[[Shot, Any], Picture]:
    """Filter the inputs at the pixel's centre, shade once.

    `texture_filter(settings)` makes the device function (texels, chain, surface) -> texel.
    """
    specialised = cache(texture_filter)

    def render(shot: Shot, settings: Settings) -> Picture:
        return render_samples(shot, specialised(settings), n=1)

    return render


def render_samples(shot: Shot, texture_filter: wp.Function, *, n: int, jittered: bool = False) -> Picture:
    """Shade n x n samples a pixel and average them; with n > 1 the error is half the difference of two halves."""
    launcher = shot.launcher
    size = (shot.view.height, shot.view.width)
    picture = launcher.empty(size, wp.vec4)
    error = launcher.empty(size if n > 1 else (0, 0), wp.vec4)
    shade = shade_grid(shot, texture_filter, shot.grid(n, jittered=jittered), n)
    triangles = shot.triangles
    launcher.each(launcher.strips(size[0], n), lambda strip: shade(triangles, strip, picture, error))
    return Picture(to_image(picture), to_image(error) if n > 1 else None)


def shade_grid(shot: Shot, texture_filter: wp.Function, grid: Any, n: int) -> Callable[..., None]:
    """What rasterises and shades a strip of a grid, of the screen or of a target in texture space.

    It is called with triangles, strip, picture [H, W] and error ([H, W] if n > 1), and fills rows of the latter two
    from `row` on (default: the strip's own). Kernels are made here, once, and not in the threads that call it.
    """
    launcher, chain, texels, sun = shot.launcher, shot.material.shape, shot.material.texels, shot.sun
    kernel = shade_samples(texture_filter, shot.shade_packet, n > 1)

    def shade(triangles: Triangles, strip: Strip, picture: Any, error: Any, *, row: int | None = None) -> None:
        visible = visibility(launcher, triangles, grid, strip, n)
        inputs = [
            strip.first,
            strip.first if row is None else row,
            n,
            grid,
            visible,
            triangles.planes,
            texels,
            chain,
            sun,
            picture,
            error,
        ]
        launcher.launch(kernel, strip.rows, inputs)

    return shade


def to_image(picture: Any) -> Image:
    """A device picture [H, W] of 4-vectors as floats [H, W, 4]."""
    return np.asarray(picture.numpy(), np.float32)
