"""The shading core: from a filtered texel and the surface it lies on to radiance.

Pixel shading, texture-space lighting and the reference all call the same function over other domains.
"""

import functools

import warp as wp

from swimlab.kernels.structs import Sun, Surface, Texel

wp.set_module_options({"enable_backward": False})


@wp.func
def local(slope: wp.float32, direction: wp.vec3) -> wp.vec3:
    """A world direction in the road's tangent frame: x across, y up the slope, z along the geometric normal."""
    scale = 1.0 / wp.sqrt(1.0 + slope * slope)
    return wp.vec3(
        direction[0],
        (direction[1] + slope * direction[2]) * scale,
        (direction[2] - slope * direction[1]) * scale,
    )


@wp.func
def power_of_cosine(n: wp.vec3, h: wp.vec3, power: wp.float32) -> wp.float32:
    """sat(n.h)^power for unit vectors, good to powers of 1e5.

    The power is taken of the sine, exp(power/2 log(1 - |n x h|^2)): near the peak a float's n.h has lost the digits
    that the power multiplies. log(1 - x) follows Kahan: log(u) x / (1 - u) with u = 1 - x rounded.
    """
    if wp.dot(n, h) <= 0.0:
        return wp.where(power == 0.0, 1.0, 0.0)
    x = wp.length_sq(wp.cross(n, h))
    u = 1.0 - x
    if u <= 0.0:
        return wp.where(power == 0.0, 1.0, 0.0)
    logarithm = -x
    if u < 1.0:
        logarithm = wp.log(u) * (x / (1.0 - u))
    return wp.exp(0.5 * power * logarithm)


@functools.cache
def shade_with(brdf: wp.Function) -> wp.Function:
    """The shading function of a reflectance model.

    Parameters: a texel (its normal of any length but 0), the surface and the sun. Returns linear radiance, RGB.
    """

    @wp.func(module="unique")
    def shade(texel: Texel, surface: Surface, sun: Sun) -> wp.vec3:
        normal = wp.normalize(wp.vec3(texel[3], texel[4], texel[5]))
        light = local(surface.slope, sun.direction)
        view = local(surface.slope, -wp.normalize(wp.vec3(surface.position)))
        return brdf(texel, normal, light, view, sun.diffuse)

    return shade
