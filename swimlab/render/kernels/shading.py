"""The shading core: from a filtered texel and the surface it lies on to radiance.

Pixel shading, texture-space lighting and the reference all call the same function over other domains.
"""

import warp as wp

from metrics.kernels.making import made_once
from swimlab.render.kernels.structs import TEXELS, Sun, Surface

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
def power_below_one(x: wp.float32, power: wp.float32) -> wp.float32:
    """(1 - x)^power for x in 0..1, good to powers of 1e5 at small x; 0^0 is 1.

    log(1 - x) follows Kahan: log(u) x / (1 - u) with u = 1 - x rounded.
    """
    u = 1.0 - x
    if u <= 0.0:
        return wp.where(power == 0.0, 1.0, 0.0)
    logarithm = -x
    if u < 1.0:
        logarithm = wp.log(u) * (x / (1.0 - u))
    return wp.exp(power * logarithm)


@wp.func
def power_of_cosine(h: wp.vec3, power: wp.float32) -> wp.float32:
    """sat(h.z)^power for a unit vector h of the local frame, good to powers of 1e5.

    Within 45 degrees of the peak it is (1 - h.x^2 - h.y^2)^(power/2): near 1, h.z in float32 lacks the digits that the
    power multiplies. Towards the horizon the sine lacks them, and the power is taken of h.z.
    """
    if h[2] <= 0.0:
        return wp.where(power == 0.0, 1.0, 0.0)
    squared = h[0] * h[0] + h[1] * h[1]
    if squared > 0.5:
        return wp.exp(power * wp.log(h[2]))
    return power_below_one(squared, 0.5 * power)


@wp.func
def half_vector(light: wp.vec3, view: wp.vec3) -> wp.vec3:
    """The unit vector halfway between two unit vectors, also nearly opposite ones; 0 between opposite ones.

    As |L| = |V|, L + V is perpendicular to L - V. What it has along L - V is rounding, which matters where L + V is
    short; there |L - V|^2 is nearly 4, and that part is subtracted.
    """
    total = light + view
    apart = light - view
    return wp.normalize(total - apart * (0.25 * wp.dot(total, apart)))


@wp.func
def tangent_about(normal: wp.vec3, along: wp.vec3) -> wp.vec3:
    """The unit tangent nearest to `along`; across the road where `along` is parallel to the normal."""
    tangent = along - normal * wp.dot(normal, along)
    if wp.length_sq(tangent) < 1.0e-12:
        axis = wp.where(wp.abs(normal[0]) < 0.9, wp.vec3(1.0, 0.0, 0.0), wp.vec3(0.0, 1.0, 0.0))
        tangent = axis - normal * wp.dot(normal, axis)
    return wp.normalize(tangent)


@made_once
def in_local_frame(evaluate: wp.Function, width: int) -> wp.Function:
    """A reflectance model over filtered texels of `width` floats, evaluated in the local frame of each texel.

    There the texel's normal (of any length but 0) is (0, 0, 1) and its tangent, the road's x axis if the maps have no
    twist, is (1, 0, 0). Parameters: texel, unit vectors to light and eye in the road's tangent frame, diffuse.
    """
    texel_type = TEXELS[width]
    twisted = width == 10

    @wp.func(module="unique")
    def reflect(texel: texel_type, light: wp.vec3, view: wp.vec3, diffuse: wp.float32) -> wp.vec3:
        normal = wp.normalize(wp.vec3(texel[3], texel[4], texel[5]))
        along = wp.vec3(1.0, 0.0, 0.0)
        if wp.static(twisted):
            along = wp.vec3(texel[width - 2], texel[width - 1], 0.0)
        tangent = tangent_about(normal, along)
        bitangent = wp.cross(normal, tangent)
        to_light = wp.vec3(wp.dot(tangent, light), wp.dot(bitangent, light), wp.dot(normal, light))
        to_eye = wp.vec3(wp.dot(tangent, view), wp.dot(bitangent, view), wp.dot(normal, view))
        albedo = wp.vec3(texel[0], texel[1], texel[2])
        return evaluate(albedo, texel[6], texel[7], to_light, to_eye, diffuse)

    return reflect


@made_once
def shade_with(reflect: wp.Function, width: int) -> wp.Function:
    """The shading function: from a filtered texel of `width` floats, its surface and the sun to linear radiance."""
    texel_type = TEXELS[width]

    @wp.func(module="unique")
    def shade(texel: texel_type, surface: Surface, sun: Sun) -> wp.vec3:
        light = local(surface.slope, sun.direction)
        view = local(surface.slope, -wp.normalize(wp.vec3(surface.position)))
        return reflect(texel, light, view, sun.diffuse)

    return shade
