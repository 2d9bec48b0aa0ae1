"""Texture-space lighting, as the deck has it: light the texels, filter the light, paste it.

Each visible segment is drawn into a target of its own with atlas coordinates as positions; targets are cleared to
alpha 0, reduced by a box to a mip chain, and read with full anisotropy; RGB is divided by alpha where alpha > 1e-5.
"""

import functools
from math import log2
from queue import SimpleQueue

import numpy as np
import warp as wp
from pydantic import Field, field_validator

from swimlab.kernels.footprint import surface_at
from swimlab.kernels.raster import sample_position
from swimlab.kernels.sampling import anisotropic, trilinear
from swimlab.kernels.structs import Chain, Grid, Planes, Surface, Texel
from swimlab.launch import Strip
from swimlab.shot import Shot
from swimlab.technique import Picture, Settings, Technique, shade_grid, to_image
from swimlab.texture import MipChain
from swimlab.triangles import in_texture, visibility


class TslSettings(Settings):
    """The size of a segment's target and how it is read."""

    size: int = Field(1024, ge=16, le=8192, description="texels along each side of a segment's target, a power of two")
    anisotropy: int = Field(16, ge=1, le=64, description="most probes along the footprint's major axis when pasting")

    @field_validator("size")
    @classmethod
    def _power_of_two(cls, size: int) -> int:
        if size & (size - 1):
            raise ValueError(f"must be a power of two, as {1 << (size.bit_length() - 1)} or {1 << size.bit_length()}")
        return size


@functools.cache
def at_level(lod: float) -> wp.Function:
    """The filter of the inputs: the map's chain at one level of detail."""

    @wp.func(module="unique")
    def level(texels: wp.array(dtype=Texel), chain: Chain, surface: Surface) -> Texel:
        return trilinear(texels, chain, lod, wp.vec2(surface.uv))

    return level


@wp.kernel(enable_backward=False)
def paste(
    first_row: wp.int32,
    grid: Grid,
    most: wp.int32,
    segment: wp.int32,
    visible: wp.array2d(dtype=wp.int32),
    segments: wp.array(dtype=wp.int32),
    planes: wp.array(dtype=Planes),
    target: wp.array(dtype=wp.vec4),
    chain: Chain,
    picture: wp.array2d(dtype=wp.vec4),
):
    """Fill the pixels that see one segment from its lit target."""
    row, i = wp.tid()
    j = first_row + row
    triangle = visible[j, i]
    if triangle >= 0 and segments[triangle] == segment:
        surface = surface_at(planes[triangle], grid, sample_position(grid, i, j))
        colour = anisotropic(target, chain, surface, most)
        if colour[3] > 1.0e-5:
            colour = colour / colour[3]
        picture[j, i] = wp.vec4(colour[0], colour[1], colour[2], 1.0)


def render(shot: Shot, settings: TslSettings) -> Picture:
    """Light, reduce and paste one visible segment after another; one target is alive for each thread."""
    launcher, size = shot.launcher, settings.size
    grid = shot.grid()
    visible = visibility(launcher, shot.triangles, grid, Strip(0, shot.view.height))
    seen = visible.numpy()
    first = int(shot.mesh.segments[0])
    owner = np.where(seen >= 0, shot.mesh.segments[seen], first - 1)
    segments = launcher.array(shot.mesh.segments - first, wp.int32)
    picture = launcher.empty(seen.shape, wp.vec4)
    picture.zero_()

    target_grid = Grid()
    target_grid.pitch = wp.vec2d(1.0 / size, 1.0 / size)
    target_grid.width = target_grid.height = size
    finest = max(shot.material.shape.width, shot.material.shape.height)
    light = shade_grid(shot, at_level(log2(finest / size)), target_grid, 1)
    no_error = launcher.empty((0, 0), wp.vec4)
    idle: SimpleQueue[MipChain] = SimpleQueue()
    for _ in range(launcher.threads):
        idle.put(MipChain.allocate(launcher, width=size, height=size, dtype=wp.vec4, clamps=True))

    def light_and_paste(segment: int) -> None:
        target = idle.get()
        try:
            fill(segment, target)
        finally:
            idle.put(target)

    def fill(segment: int, target: MipChain) -> None:
        triangles = in_texture(launcher, shot.mesh, segment)
        lit = target.texels[: size * size].reshape((size, size))
        for strip in launcher.strips(size):
            light(triangles, strip, lit, no_error)
        target.reduce(launcher)
        rows = np.flatnonzero(np.any(owner == segment, axis=1))
        inputs = [int(rows[0]), grid, settings.anisotropy, segment - first, visible, segments]
        inputs += [shot.triangles.planes, target.texels, target.shape, picture]
        launcher.launch(paste, (int(rows[-1] - rows[0]) + 1, seen.shape[1]), inputs)

    launcher.each(np.unique(owner[seen >= 0]).tolist(), light_and_paste)
    return Picture(to_image(picture))


TECHNIQUE = Technique(
    name="tsl",
    summary="texture-space lighting: texels are shaded, and the light is filtered",
    source="Sloan & Baker, TSL: A case study",
    render=render,
    settings=TslSettings,
)
