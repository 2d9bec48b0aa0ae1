"""Kernels that show what device functions return for single samples, without a picture: for studies and tests."""

from typing import Any

import warp as wp

from metrics.kernels.making import made_once
from swimlab.render.kernels.footprint import isotropic_level, surface_at
from swimlab.render.kernels.packet import PLACES, put_in, radiance, rows_of
from swimlab.render.kernels.raster import sample_position
from swimlab.render.kernels.sampling import LEAST_BLEND, probes_of
from swimlab.render.kernels.shading import power_of_cosine
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Grid, Planes, Sun

wp.set_module_options({"enable_backward": False})


@wp.kernel
def raise_cosines(h: wp.array(dtype=wp.vec3), power: wp.float32, out: wp.array(dtype=wp.float32)):
    """sat(h.z)^power of unit vectors."""
    out[wp.tid()] = power_of_cosine(h[wp.tid()], power)


@wp.kernel
def surfaces(
    grid: Grid,
    visible: wp.array2d(dtype=wp.int32),
    planes: wp.array(dtype=Planes),
    uv: wp.array2d(dtype=wp.vec2d),
    dx: wp.array2d(dtype=wp.vec2d),
    dy: wp.array2d(dtype=wp.vec2d),
    position: wp.array2d(dtype=wp.vec3d),
):
    """The surface that each sample of a grid sees: uv, its derivatives by cell right and down, position about the eye.

    Samples that see nothing leave all of them unchanged.
    """
    j, i = wp.tid()
    triangle = visible[j, i]
    if triangle >= 0:
        surface = surface_at(planes[triangle], grid, sample_position(grid, i, j))
        uv[j, i] = surface.uv
        dx[j, i] = surface.dx
        dy[j, i] = surface.dy
        position[j, i] = surface.position


@wp.kernel
def count_reads(
    most: wp.int32,
    grid: Grid,
    visible: wp.array2d(dtype=wp.int32),
    planes: wp.array(dtype=Planes),
    chain: Chain,
    reads: wp.array(dtype=wp.int32),
):
    """Texels that a row of samples reads with up to `most` probes a footprint; 0: by trilinear filtering."""
    j = wp.tid()
    total = wp.int32(0)
    for i in range(grid.width):
        triangle = visible[j, i]
        if triangle >= 0:
            surface = surface_at(planes[triangle], grid, sample_position(grid, i, j))
            count = wp.int32(1)
            lod = wp.float32(isotropic_level(surface, chain))
            if most > 0:
                probes = probes_of(surface, chain, most)
                count = probes.count
                lod = probes.lod
            lod = wp.clamp(lod, 0.0, wp.float32(chain.levels - 1))
            levels = wp.int32(1)
            if lod - wp.floor(lod) > LEAST_BLEND:
                levels = 2
            total += 4 * levels * count
    reads[j] = total


@made_once
def shaded_samples(shade_packet: wp.Function, width: int) -> wp.Kernel:
    """The kernel that shades texels of `width` floats at given places (m, relative to the eye), LANES a thread."""
    texel_type = TEXELS[width]
    put = put_in(width).native
    floats = LANES * rows_of(width)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        texels: wp.array(dtype=texel_type),
        positions: wp.array(dtype=wp.vec3),
        sun: Sun,
        out: wp.array(dtype=wp.vec3),
    ):
        first = wp.tid() * LANES
        lanes = wp.zeros(shape=(floats,), dtype=wp.float32)
        for lane in range(LANES):
            put(lanes, lane, texels[first + lane])
            position = positions[first + lane]
            for row in range(3):
                lanes[(width + row) * LANES + lane] = position[row]
        shade_packet(lanes, sun)
        for lane in range(LANES):
            out[first + lane] = radiance(lanes, lane)

    return kernel


@made_once
def filtered_samples(fill: wp.Function, width: int, shape: Any = Chain) -> wp.Kernel:
    """The kernel that fills `count` lanes of a packet a thread from `places` [N, PLACES].

    The texels go to `out` [N, width * LANES].
    """
    texel_type = TEXELS[width]
    floats = rows_of(width) * LANES

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        texels: wp.array(dtype=texel_type),
        chain: shape,
        count: wp.int32,
        places: wp.array2d(dtype=wp.float64),
        out: wp.array2d(dtype=wp.float32),
    ):
        packet = wp.tid()
        own = wp.zeros(shape=(PLACES,), dtype=wp.float64)
        lanes = wp.zeros(shape=(floats,), dtype=wp.float32)
        for k in range(PLACES):
            own[k] = places[packet, k]
        fill(texels, chain, own, count, lanes)
        for k in range(width * LANES):
            out[packet, k] = lanes[k]

    return kernel


@made_once
def resolve_coarsest(resolve: wp.Function) -> wp.Kernel:
    """The kernel that resolves the moments of the last texel of a chain."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(chain: Chain, texels: wp.array(dtype=Any), out: wp.array(dtype=Any)):
        out[0] = resolve(texels[chain.offsets[chain.levels - 1]], chain)

    return kernel


@wp.func
def cosines(
    albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
) -> wp.vec3:
    """In place of a reflectance model the least that reads all its inputs: the cost of the loop alone."""
    return albedo * (light[2] + view[2])


@made_once
def evaluations(evaluate: wp.Function, each: int = LANES) -> wp.Kernel:
    """The kernel that adds up red over `each` evaluations a thread, under one albedo, Ks and power."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        albedo: wp.vec3,
        ks: wp.float32,
        power: wp.float32,
        diffuse: wp.float32,
        light: wp.array(dtype=wp.vec3),
        view: wp.array(dtype=wp.vec3),
        out: wp.array(dtype=wp.float32),
    ):
        thread = wp.tid()
        total = wp.float32(0.0)
        for i in range(thread * each, thread * each + each):
            total += evaluate(albedo, ks, power, light[i], view[i], diffuse)[0]
        out[thread] = total

    return kernel
