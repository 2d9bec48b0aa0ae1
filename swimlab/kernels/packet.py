"""Packets: samples gathered side by side, so that one reflectance model is evaluated over many of them at once.

A packet is a local array of ROWS rows of LANES floats: the texel's eight values, then position (m, relative to the eye)
and slope. Shading leaves radiance in the first three rows. A model may bring a native form that a compiler can
vectorise; else each lane is shaded by the plain form.
"""

import functools

import warp as wp

from swimlab.kernels.shading import shade_with
from swimlab.kernels.structs import Sun, Surface, Texel

LANES = 64
"""Samples in a packet."""
ROWS = 12
"""Values of a sample: texel 0..7, position 8..10, slope 11."""

wp.set_module_options({"enable_backward": False})


PUT = """
    float* a = lanes.data + lane;
    for (int row = 0; row < 8; ++row) a[64*row] = texel.c[row];
    a[8*64] = (float)surface.position.c[0];
    a[9*64] = (float)surface.position.c[1];
    a[10*64] = (float)surface.position.c[2];
    a[11*64] = surface.slope;
"""


@wp.func_native(PUT)
def put(lanes: wp.array(dtype=wp.float32), lane: wp.int32, texel: Texel, surface: Surface):
    """Store a filtered texel and its surface in a lane; native, as twelve indexed stores cost more than shading."""


@wp.func
def radiance(lanes: wp.array(dtype=wp.float32), lane: wp.int32) -> wp.vec3:
    """What shading left in a lane."""
    return wp.vec3(lanes[lane], lanes[LANES + lane], lanes[2 * LANES + lane])


@functools.cache
def plain_packet(brdf: wp.Function) -> wp.Function:
    """Shading of a packet lane by lane: the readable truth that native forms are tested against."""
    shade = shade_with(brdf)

    @wp.func(module="unique")
    def shade_packet(lanes: wp.array(dtype=wp.float32), sun: Sun):
        for lane in range(LANES):
            texel = Texel()
            for row in range(8):
                texel[row] = lanes[row * LANES + lane]
            surface = Surface()
            surface.position = wp.vec3d(
                wp.float64(lanes[8 * LANES + lane]),
                wp.float64(lanes[9 * LANES + lane]),
                wp.float64(lanes[10 * LANES + lane]),
            )
            surface.slope = lanes[11 * LANES + lane]
            colour = shade(texel, surface, sun)
            for row in range(3):
                lanes[row * LANES + lane] = colour[row]

    return shade_packet
