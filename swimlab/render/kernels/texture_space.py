"""Texture-space lighting beside shading itself: find the texels that will be read, reduce only these, paste them.

A target is cut into square tiles, each one texel of level `tile_level`; `need[tile]` is the finest level that is read
anywhere in the tile, or NEVER. A tile is shaded at that level; its coarser levels are made by reduction.
"""

from typing import Any

import warp as wp

from metrics.kernels.forms import Twins, form
from swimlab.render.kernels.footprint import surface_at
from swimlab.render.kernels.raster import sample_position
from swimlab.render.kernels.sampling import LEAST_BLEND, probes_of
from swimlab.render.kernels.structs import LANES, Chain, Grid, Planes, Sun

NEVER = 127
"""The level of a tile that nothing reads."""

wp.set_module_options({"enable_backward": False})


@wp.func
def normal_as_colour(texel: Any, light: wp.vec3, view: wp.vec3, diffuse: wp.float32) -> wp.vec3:
    """In place of radiance: (N + 1) / 2 squared, which the display's square root turns back into (N + 1) / 2."""
    normal = (wp.normalize(wp.vec3(texel[3], texel[4], texel[5])) + wp.vec3(1.0, 1.0, 1.0)) * 0.5
    return wp.cw_mul(normal, normal)


@wp.func
def ask(need: wp.array2d(dtype=wp.int32), chain: Chain, tile_level: wp.int32, level: wp.int32, uv: wp.vec2):
    """Note that a bilinear sample reads `level` at uv."""
    width = wp.max(chain.width >> level, 1)
    height = wp.max(chain.height >> level, 1)
    left = wp.int32(wp.floor(uv[0] * wp.float32(width) - 0.5))
    top = wp.int32(wp.floor(uv[1] * wp.float32(height) - 0.5))
    first_i = (wp.clamp(left, 0, width - 1) << level) >> tile_level
    first_j = (wp.clamp(top, 0, height - 1) << level) >> tile_level
    last_i = (((wp.clamp(left + 1, 0, width - 1) + 1) << level) - 1) >> tile_level
    last_j = (((wp.clamp(top + 1, 0, height - 1) + 1) << level) - 1) >> tile_level
    finest = wp.min(level, tile_level)
    for j in range(first_j, last_j + 1):
        for i in range(first_i, last_i + 1):
            if need[j, i] > finest:
                need[j, i] = finest


@wp.kernel
def mark(
    first_row: wp.int32,
    rows: wp.int32,
    grid: Grid,
    most: wp.int32,
    segment: wp.int32,
    visible: wp.array2d(dtype=wp.int32),
    segments: wp.array(dtype=wp.int32),
    planes: wp.array(dtype=Planes),
    chain: Chain,
    tile_level: wp.int32,
    need: wp.array2d(dtype=wp.int32),
):
    """Note every texel that pasting one segment onto some rows will read. One thread; callers take the least of all."""
    for j in range(first_row, first_row + rows):
        for i in range(visible.shape[1]):
            triangle = visible[j, i]
            if triangle >= 0 and segments[triangle] == segment:
                surface = surface_at(planes[triangle], grid, sample_position(grid, i, j))
                probes = probes_of(surface, chain, most)
                lod = wp.clamp(probes.lod, 0.0, wp.float32(chain.levels - 1))
                level = wp.int32(lod)
                for k in range(probes.count):
                    uv = probes.first + probes.step * wp.float32(k)
                    ask(need, chain, tile_level, level, uv)
                    if lod - wp.float32(level) > LEAST_BLEND:
                        ask(need, chain, tile_level, level + 1, uv)


@wp.kernel
def keep_needed(
    first_row: wp.int32,
    first_column: wp.int32,
    level: wp.int32,
    tile_level: wp.int32,
    need: wp.array2d(dtype=wp.int32),
    visible: wp.array2d(dtype=wp.int32),
):
    """Mark texels of a band of `level` as not visible where their tile is shaded at another level."""
    row, i = wp.tid()
    tile_j = ((first_row + row) << level) >> tile_level
    tile_i = ((first_column + i) << level) >> tile_level
    if need[tile_j, tile_i] != level:
        visible[row, i] = -1


REDUCE = """
    const int side = chain.width >> level, below = 2*side;
    const int* wanted = (const int*)((const char*)need.data + (long)((j << level) >> tile_level)*need.strides[0]);
    const auto* upper = texels.data + chain.offsets.data[level - 1] + (long)2*j*below;
    const auto* lower = upper + below;
    auto* out = texels.data + chain.offsets.data[level] + (long)j*side;
    for (int i = 0; i < side; ++i)
        if (wanted[(i << level) >> tile_level] < level)
            out[i] = ((upper[2*i] + upper[2*i + 1]) + (lower[2*i] + lower[2*i + 1]))*0.25f;
"""


@form()
def row_reduction() -> Twins:
    """The function that fills texels of row j of `level` by the mean of the 2x2 below.

    It leaves out tiles that were not shaded at a finer level.
    """

    @wp.func(module="unique")
    def reduce(
        j: wp.int32,
        level: wp.int32,
        tile_level: wp.int32,
        need: wp.array2d(dtype=wp.int32),
        chain: Chain,
        texels: wp.array(dtype=wp.vec4),
    ):
        side = chain.width >> level
        for i in range(side):
            if need[(j << level) >> tile_level, (i << level) >> tile_level] < level:
                upper = chain.offsets[level - 1] + 4 * j * side + 2 * i
                lower = upper + 2 * side
                total = (texels[upper] + texels[upper + 1]) + (texels[lower] + texels[lower + 1])
                texels[chain.offsets[level] + j * side + i] = total * 0.25

    return Twins(reduce, REDUCE, 4)


reduce_row = row_reduction().native


@wp.kernel
def reduce_needed(
    first_row: wp.int32,
    level: wp.int32,
    tile_level: wp.int32,
    need: wp.array2d(dtype=wp.int32),
    chain: Chain,
    texels: wp.array(dtype=wp.vec4),
):
    """`reduce_row`, one thread a row."""
    reduce_row(first_row + wp.tid(), level, tile_level, need, chain, texels)


@wp.kernel
def only_segment(
    first_row: wp.int32,
    segment: wp.int32,
    visible: wp.array2d(dtype=wp.int32),
    segments: wp.array(dtype=wp.int32),
    mine: wp.array2d(dtype=wp.int32),
):
    """Copy the cells of some rows of a visibility buffer that see one segment; the others are -1."""
    row, i = wp.tid()
    triangle = visible[first_row + row, i]
    mine[row, i] = -1
    if triangle >= 0 and segments[triangle] == segment:
        mine[row, i] = triangle


UNPREMULTIPLY = """
    float* a = lanes.data;
    for (int k = 0; k < LANES; ++k) {
        const float alpha = a[3*LANES + k] > 1.0e-5f ? a[3*LANES + k] : 1.0f;
        a[k] = a[k]/alpha; a[LANES + k] = a[LANES + k]/alpha; a[2*LANES + k] = a[2*LANES + k]/alpha;
    }
""".replace("LANES", str(LANES))


@form()
def unpremultiplication() -> Twins:
    """The function that stands for shading when light is pasted: RGB is divided by alpha where alpha > 1e-5."""

    @wp.func(module="unique")
    def divide(lanes: wp.array(dtype=wp.float32), sun: Sun):
        for k in range(LANES):
            alpha = wp.where(lanes[3 * LANES + k] > 1.0e-5, lanes[3 * LANES + k], 1.0)
            for row in range(3):
                lanes[row * LANES + k] = lanes[row * LANES + k] / alpha

    return Twins(divide, UNPREMULTIPLY, 4)


unpremultiply = unpremultiplication().native
