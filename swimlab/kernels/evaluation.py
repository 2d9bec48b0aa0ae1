"""A reflectance model evaluated by itself, without a picture."""

import functools

import warp as wp

from swimlab.kernels.packet import put_in, radiance, rows_of
from swimlab.kernels.structs import LANES, TEXELS, Sun


@wp.func
def cosines(
    albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
) -> wp.vec3:
    """No reflectance model, but the least that depends on all that one reads: what is left is the cost of the loop."""
    return albedo * (light[2] + view[2])


@functools.cache
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


@functools.cache
def packets(shade_packet: wp.Function, width: int) -> wp.Kernel:
    """The kernel that fills a packet a thread with texels of `width` floats, shades it on flat ground, adds up red."""
    texel_type = TEXELS[width]
    put = put_in(width)
    floats = LANES * rows_of(width)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        texels: wp.array(dtype=texel_type),
        positions: wp.array(dtype=wp.vec3),
        sun: Sun,
        out: wp.array(dtype=wp.float32),
    ):
        thread = wp.tid()
        lanes = wp.zeros(shape=(floats,), dtype=wp.float32)
        for lane in range(LANES):
            put(lanes, lane, texels[thread * LANES + lane])
            position = positions[thread * LANES + lane]
            for row in range(3):
                lanes[(width + row) * LANES + lane] = position[row]
        shade_packet(lanes, sun)
        total = wp.float32(0.0)
        for lane in range(LANES):
            total += radiance(lanes, lane)[0]
        out[thread] = total

    return kernel
