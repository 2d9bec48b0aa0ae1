"""Packets: samples gathered side by side, so that one reflectance model is evaluated over many of them at once.

A packet is a local array of rows of LANES floats: the texel's values (8, or as many as its kind has), then position (m,
relative to the eye) and slope. Shading leaves radiance in the first three rows. A model may bring a native form that a
compiler can vectorise; else each lane is shaded by the plain form.
"""

import functools

import warp as wp

from swimlab.render.kernels.locate import footprint_of
from swimlab.render.kernels.shading import shade_with
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Sun, Surface

wp.set_module_options({"enable_backward": False})


def rows_of(width: int) -> int:
    """Values of a sample whose texel has `width` floats."""
    return width + 4


@functools.cache
def put_in(width: int) -> wp.Function:
    """The function that stores a texel of `width` floats in a lane; native, as so many indexed stores are slow."""
    texel_type = TEXELS[width]
    snippet = f"for (int row = 0; row < {width}; ++row) lanes.data[{LANES}*row + lane] = texel.c[row];"

    @wp.func_native(snippet)
    def put(lanes: wp.array(dtype=wp.float32), lane: wp.int32, texel: texel_type): ...

    return put


@functools.cache
def take_from(width: int) -> wp.Function:
    """The function that reads a texel of `width` floats from a lane; native, as `put_in` is."""
    texel_type = TEXELS[width]
    snippet = f"""
    wp::vec_t<{width}, float> texel;
    for (int row = 0; row < {width}; ++row) texel.c[row] = lanes.data[{LANES}*row + lane];
    return texel;
"""

    @wp.func_native(snippet)
    def take(lanes: wp.array(dtype=wp.float32), lane: wp.int32) -> texel_type: ...

    return take


@functools.cache
def each_lane(texture_filter: wp.Function, width: int) -> wp.Function:
    """The filling of a packet with filtered texels lane by lane: the truth that native forms are tested against.

    `texture_filter(texels, chain, surface) -> texel`, of `width` floats.
    """
    texel_type = TEXELS[width]
    put = put_in(width)

    @wp.func(module="unique")
    def fill(
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        places: wp.array(dtype=wp.float64),
        count: wp.int32,
        lanes: wp.array(dtype=wp.float32),
    ):
        for lane in range(count):
            put(lanes, lane, texture_filter(texels, chain, footprint_of(places, lane)))

    return fill


@functools.cache
def resolved(fill: wp.Function, resolve: wp.Function, width: int) -> wp.Function:
    """The filling of a packet, followed by `resolve(texel, chain)` in each lane."""
    texel_type = TEXELS[width]
    take, put = take_from(width), put_in(width)

    @wp.func(module="unique")
    def fill_and_resolve(
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        places: wp.array(dtype=wp.float64),
        count: wp.int32,
        lanes: wp.array(dtype=wp.float32),
    ):
        fill(texels, chain, places, count, lanes)
        for lane in range(count):
            put(lanes, lane, resolve(take(lanes, lane), chain))

    return fill_and_resolve


@wp.func
def radiance(lanes: wp.array(dtype=wp.float32), lane: wp.int32) -> wp.vec3:
    """What shading left in a lane."""
    return wp.vec3(lanes[lane], lanes[LANES + lane], lanes[2 * LANES + lane])


@functools.cache
def plain_packet(reflect: wp.Function, width: int) -> wp.Function:
    """Shading of a packet lane by lane: the readable truth that native forms are tested against.

    `reflect(texel, light, view, diffuse)` works in the road's tangent frame on texels of `width` floats.
    """
    shade, take = shade_with(reflect, width), take_from(width)

    @wp.func(module="unique")
    def shade_packet(lanes: wp.array(dtype=wp.float32), sun: Sun):
        for lane in range(LANES):
            surface = Surface()
            surface.position = wp.vec3d(
                wp.float64(lanes[width * LANES + lane]),
                wp.float64(lanes[(width + 1) * LANES + lane]),
                wp.float64(lanes[(width + 2) * LANES + lane]),
            )
            surface.slope = lanes[(width + 3) * LANES + lane]
            colour = shade(take(lanes, lane), surface, sun)
            for row in range(3):
                lanes[row * LANES + lane] = colour[row]

    return shade_packet
