"""Mip chains on the device, for texels of any vector type: how they are built, and the texture filters that read them.

The levels of a chain are packed one after another; every texel of a level is the mean of the 2x2 below it. Texel
centres lie at (i + .5) / n. Addresses repeat or clamp as the chain says.
"""

from typing import Any

import warp as wp

from metrics.kernels.making import made_once
from swimlab.render.kernels.footprint import ellipse, isotropic_level
from swimlab.render.kernels.structs import TEXELS, Chain, Pages, Surface

LEAST_BLEND = 1e-6
"""A coarser level that would weigh less than float rounding is not read."""

wp.set_module_options({"enable_backward": False})


@wp.func
def fetch(texels: wp.array(dtype=Any), chain: Chain, level: wp.int32, i: wp.int32, j: wp.int32):
    """Texel (i, j) of a level."""
    width = wp.max(chain.width >> level, 1)
    height = wp.max(chain.height >> level, 1)
    if chain.clamps == 1:
        i = wp.clamp(i, 0, width - 1)
        j = wp.clamp(j, 0, height - 1)
    else:
        i = i & (width - 1)
        j = j & (height - 1)
    return texels[chain.offsets[level] + j * width + i]


@wp.func
def fetch(texels: wp.array(dtype=Any), chain: Pages, level: wp.int32, i: wp.int32, j: wp.int32):  # noqa: F811
    """Texel (i, j) of a level of which the tile is held."""
    width = wp.max(chain.width >> level, 1)
    i = wp.clamp(i, 0, width - 1)
    j = wp.clamp(j, 0, width - 1)
    # Of the block that holds the texel: texels a side at this level and at the block's finest, log2 of the former.
    shift = wp.int32(31)
    side = width
    finest = chain.width >> chain.tile_level
    entry = chain.first - 1
    if level < chain.tile_level:
        shift = chain.tile_level - level
        side = 1 << shift
        finest = 1 << chain.tile_level
        entry = chain.first + (j >> shift) * (chain.width >> chain.tile_level) + (i >> shift)
    before = 4 * (finest * finest - side * side) / 3
    return texels[chain.table[entry] + before + (j & (side - 1)) * side + (i & (side - 1))]


@wp.kernel
def halve(level: wp.int32, chain: Chain, texels: wp.array(dtype=Any)):
    """Fill one texel of `level` from the level below; a side that is already 1 texel long stays so."""
    j, i = wp.tid()
    below = level - 1
    right = wp.min(2 * i + 1, wp.max(chain.width >> below, 1) - 1)
    lower = wp.min(2 * j + 1, wp.max(chain.height >> below, 1) - 1)
    total = fetch(texels, chain, below, 2 * i, 2 * j) + fetch(texels, chain, below, right, 2 * j)
    total += fetch(texels, chain, below, 2 * i, lower) + fetch(texels, chain, below, right, lower)
    texels[chain.offsets[level] + j * wp.max(chain.width >> level, 1) + i] = total * 0.25


HALVE = {
    dtype: wp.overload(halve, {"level": wp.int32, "chain": Chain, "texels": wp.array(dtype=dtype)})
    for dtype in TEXELS.values()
}
"""`halve` for every kind of texel."""


@made_once
def resolving(resolve: wp.Function, width: int) -> wp.Kernel:
    """The kernel that applies `resolve(texel, chain)` to every texel of a chain, of `width` floats."""
    texel_type = TEXELS[width]

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(texels: wp.array(dtype=texel_type), chain: Chain, out: wp.array(dtype=texel_type)):
        out[wp.tid()] = resolve(texels[wp.tid()], chain)

    return kernel


@wp.func
def point(texels: wp.array(dtype=Any), chain: Chain, uv: wp.vec2d):
    """The texel of level 0 that holds uv: floor(u n), floor(v n). A place within rounding of an edge is beyond it."""
    rounding = wp.float64(1.0e-9)
    i = wp.int32(wp.floor(uv[0] * wp.float64(chain.width) + rounding))
    j = wp.int32(wp.floor(uv[1] * wp.float64(chain.height) + rounding))
    return fetch(texels, chain, 0, i, j)


@wp.func
def bilinear(texels: wp.array(dtype=Any), chain: Any, level: wp.int32, uv: wp.vec2):
    """The four nearest texels of a level, weighted by nearness."""
    x = uv[0] * wp.float32(wp.max(chain.width >> level, 1)) - 0.5
    y = uv[1] * wp.float32(wp.max(chain.height >> level, 1)) - 0.5
    left = wp.floor(x)
    top = wp.floor(y)
    i = wp.int32(left)
    j = wp.int32(top)
    a = x - left
    b = y - top
    upper = fetch(texels, chain, level, i, j) * (1.0 - a) + fetch(texels, chain, level, i + 1, j) * a
    lower = fetch(texels, chain, level, i, j + 1) * (1.0 - a) + fetch(texels, chain, level, i + 1, j + 1) * a
    return upper * (1.0 - b) + lower * b


@wp.func
def trilinear(texels: wp.array(dtype=Any), chain: Any, lod: wp.float32, uv: wp.vec2):
    """Bilinear samples of the two levels about `lod` (clamped to the chain), blended linearly."""
    lod = wp.clamp(lod, 0.0, wp.float32(chain.levels - 1))
    level = wp.int32(lod)
    blend = lod - wp.float32(level)
    fine = bilinear(texels, chain, level, uv)
    if blend > LEAST_BLEND:
        fine = fine * (1.0 - blend) + bilinear(texels, chain, level + 1, uv) * blend
    return fine


@wp.func
def finest(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
    """Bilinear filter of the finest level."""
    return bilinear(texels, chain, 0, wp.vec2(surface.uv))


@wp.func
def isotropic(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
    """Trilinear filter at the level of the longer derivative."""
    return trilinear(texels, chain, wp.float32(isotropic_level(surface, chain)), wp.vec2(surface.uv))


@wp.struct
class Probes:
    """Places at which an anisotropic filter reads: `count` of them at level `lod`, from `first` on, `step` apart."""

    count: wp.int32
    lod: wp.float32
    first: wp.vec2
    step: wp.vec2


@wp.func
def probes_of(surface: Surface, chain: Any, most: wp.int32) -> Probes:
    """Up to `most` probes, evenly along the footprint's major axis.

    With singular values s1 >= s2 of the footprint in texels: N = 1 where s1 <= 1, else
    min(ceil(s1/s2 - 1e-6), most); lod = log2(s1/N); probe i at ((i + .5)/N - .5) s1 along the major axis. After
    EXT_texture_filter_anisotropic, with the ellipse's axes in place of the derivatives (Heckbert 1989).
    """
    shape = ellipse(surface, chain)
    probes = wp.int32(1)
    if shape.major > wp.float64(1.0):
        probes = most
        if shape.minor * wp.float64(most) > shape.major:
            probes = wp.int32(wp.ceil(shape.major / shape.minor - wp.float64(1.0e-6)))
        probes = wp.clamp(probes, 1, most)
    length = wp.vec2(
        wp.float32(shape.axis[0] * shape.major / wp.float64(chain.width)),
        wp.float32(shape.axis[1] * shape.major / wp.float64(chain.height)),
    )
    found = Probes()
    found.count = probes
    found.lod = wp.float32(wp.log2(shape.major / wp.float64(probes)))
    found.step = length / wp.float32(probes)
    found.first = wp.vec2(surface.uv) - (length - found.step) * 0.5
    return found


@wp.func
def anisotropic(texels: wp.array(dtype=Any), chain: Any, surface: Surface, most: wp.int32):
    """The mean of the trilinear samples at `probes_of` the footprint."""
    probes = probes_of(surface, chain, most)
    total = trilinear(texels, chain, probes.lod, probes.first)
    for i in range(1, probes.count):
        total += trilinear(texels, chain, probes.lod, probes.first + probes.step * wp.float32(i))
    return total * (1.0 / wp.float32(probes.count))


@made_once
def anisotropic_to(most: int) -> wp.Function:
    """The anisotropic filter with up to `most` probes, as a technique's texture filter."""

    @wp.func(module="unique")
    def stretched(texels: wp.array(dtype=Any), chain: Any, surface: Surface):
        return anisotropic(texels, chain, surface, most)

    return stretched
