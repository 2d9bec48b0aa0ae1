"""A reflectance model evaluated by itself, without a picture."""

import functools

import warp as wp

from swimlab.render.kernels.structs import LANES


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
