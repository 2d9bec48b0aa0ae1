"""From a visible triangle to the surface under a sample: attributes, their analytic derivatives, and the footprint.

Everything here is in double precision: texel addresses must hold after kilometres of driving and at the horizon.
"""

from typing import Any

import warp as wp

from swimlab.render.kernels.structs import Chain, Grid, Planes, Surface

wp.set_module_options({"enable_backward": False})


@wp.struct
class Ellipse:
    """A pixel's footprint in texels: full lengths of its axes and the direction of the major one."""

    major: wp.float64
    minor: wp.float64
    axis: wp.vec2d


@wp.func
def surface_at(planes: Planes, grid: Grid, p: wp.vec2d) -> Surface:
    """Attributes at p from the plane equations, with the derivatives of uv by one cell of the grid.

    For u = U/W with U, W linear in (x, y): du/dx = (U_x - u W_x) / W.
    """
    values = planes @ wp.vec3d(p[0], p[1], wp.float64(1.0))
    w = wp.float64(1.0) / values[0]
    u = values[1] * w
    v = values[2] * w
    surface = Surface()
    surface.uv = wp.vec2d(u, v)
    along_x = w * grid.pitch[0]
    along_y = w * grid.pitch[1]
    surface.dx = wp.vec2d((planes[1, 0] - u * planes[0, 0]) * along_x, (planes[2, 0] - v * planes[0, 0]) * along_x)
    surface.dy = wp.vec2d((planes[1, 1] - u * planes[0, 1]) * along_y, (planes[2, 1] - v * planes[0, 1]) * along_y)
    surface.position = wp.vec3d(values[3] * w, values[4] * w, values[5] * w)
    surface.slope = wp.float32(values[6] * w)
    return surface


@wp.func
def in_texels(derivative: wp.vec2d, chain: Any) -> wp.vec2d:
    """A derivative of uv in texels of level 0."""
    return wp.vec2d(derivative[0] * wp.float64(chain.width), derivative[1] * wp.float64(chain.height))


@wp.func
def isotropic_level(surface: Surface, chain: Chain) -> wp.float64:
    """The trilinear level of detail, log2 of the longer derivative in texels, unclamped."""
    return wp.log2(wp.max(wp.length(in_texels(surface.dx, chain)), wp.length(in_texels(surface.dy, chain))))


@wp.func
def ellipse(surface: Surface, chain: Any) -> Ellipse:
    """Axes of the footprint: singular values and left singular vector of J = [d(uv)/dx, d(uv)/dy] in texels.

    Heckbert 1989, Fundamentals of Texture Mapping; the derivatives themselves are not the axes of a sheared footprint.
    """
    x = in_texels(surface.dx, chain)
    y = in_texels(surface.dy, chain)
    a = x[0] * x[0] + y[0] * y[0]
    b = x[0] * x[1] + y[0] * y[1]
    c = x[1] * x[1] + y[1] * y[1]
    half = wp.float64(0.5)
    radius = wp.sqrt(half * (a - c) * half * (a - c) + b * b)
    square = half * (a + c) + radius
    shape = Ellipse()
    shape.major = wp.sqrt(square)
    # The product of the singular values is |det J|; the difference half (a + c) - radius would cancel.
    shape.minor = wp.float64(0.0)
    if shape.major > wp.float64(0.0):
        shape.minor = wp.abs(x[0] * y[1] - x[1] * y[0]) / shape.major
    axis = wp.vec2d(b, square - a)
    if a >= c:
        axis = wp.vec2d(square - c, b)
    length = wp.length(axis)
    shape.axis = wp.vec2d(wp.float64(1.0), wp.float64(0.0))
    if length > wp.float64(0.0):
        shape.axis = axis / length
    return shape
