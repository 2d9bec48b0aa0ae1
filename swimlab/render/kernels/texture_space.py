"""Texture-space lighting beside shading itself: which texels a picture reads, and pasting the light.

A target is cut into square tiles, each one texel of level `tile_level`. Of each tile the finest level is noted that is
read anywhere in it, or NEVER. An Atlas says how large the targets are and where their tiles are held.
"""

from typing import Any

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.packet import PLACES, footprint_of, locate_before, packet_end, rows_of
from swimlab.render.kernels.probes import ANISOTROPIC_PROBES, LOG2
from swimlab.render.kernels.raster import see_row
from swimlab.render.kernels.samples import blanking, gathering
from swimlab.render.kernels.sampling import LEAST_BLEND, probes_of
from swimlab.render.kernels.structs import LANES, Edges, Grid, Pages, Planes, Sun

NEVER = 127
"""The level of a tile that nothing reads."""

wp.set_module_options({"enable_backward": False})


@wp.struct
class Atlas:
    """All targets of a frame: of each its texels a side, levels, `tile_level` and `first`; and `table`, as in Pages.

    charts: the chart of each triangle of the scene. targets: the target of each chart, -1 where it has none.
    """

    shapes: wp.array(dtype=wp.vec4i)
    table: wp.array(dtype=wp.int32)
    charts: wp.array(dtype=wp.int32)
    targets: wp.array(dtype=wp.int32)


@wp.func
def pages_of(atlas: Atlas, target: wp.int32) -> Pages:
    """The shape of one target."""
    pages = Pages()
    shape = atlas.shapes[target]
    pages.width = shape[0]
    pages.height = shape[0]
    pages.levels = shape[1]
    pages.clamps = 1
    pages.tile_level = shape[2]
    pages.first = shape[3]
    pages.table = atlas.table
    return pages


@wp.func
def normal_as_colour(texel: Any, light: wp.vec3, view: wp.vec3, diffuse: wp.float32) -> wp.vec3:
    """In place of radiance: (N + 1) / 2 squared, which the display's square root turns back into (N + 1) / 2."""
    normal = (wp.normalize(wp.vec3(texel[3], texel[4], texel[5])) + wp.vec3(1.0, 1.0, 1.0)) * 0.5
    return wp.cw_mul(normal, normal)


@wp.func
def ask(need: wp.array(dtype=wp.int32), pages: Pages, level: wp.int32, uv: wp.vec2):
    """Note that a bilinear sample reads `level` at uv."""
    width = pages.width >> level
    left = wp.int32(wp.floor(uv[0] * wp.float32(width) - 0.5))
    top = wp.int32(wp.floor(uv[1] * wp.float32(width) - 0.5))
    first_i = (wp.clamp(left, 0, width - 1) << level) >> pages.tile_level
    first_j = (wp.clamp(top, 0, width - 1) << level) >> pages.tile_level
    last_i = (((wp.clamp(left + 1, 0, width - 1) + 1) << level) - 1) >> pages.tile_level
    last_j = (((wp.clamp(top + 1, 0, width - 1) + 1) << level) - 1) >> pages.tile_level
    finest = wp.min(level, pages.tile_level)
    for j in range(first_j, last_j + 1):
        for i in range(first_i, last_i + 1):
            wp.atomic_min(need, pages.first + j * (pages.width >> pages.tile_level) + i, finest)


MARK = """
    const double* __restrict q = places.data;
    const double W = (double)pages.width, H = W;
    float lod[LANES], fu[LANES], fv[LANES], su[LANES], sv[LANES];
    int number[LANES];
PROBES
    const int tile_level = pages.tile_level, tiles = pages.width >> tile_level, full = pages.width;
    const float coarsest = (float)(pages.levels - 1);
    int* __restrict wanted = need.data + pages.first;
    // Lanes are taken in whole vectors, which is faster: those beyond `count` have no probes.
    const int padded = (count + 15) & ~15;
    for (int k = count; k < padded; ++k) number[k] = 0, lod[k] = fu[k] = fv[k] = su[k] = sv[k] = 0.0f;
    int level[2][LANES], finest[2][LANES + 1], asks[2][LANES + 1], key[LANES + 1], before[2][LANES];
    int probes = 1, blended = 0;
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < padded; ++k) {
        const float l = lod[k] > 0.0f ? (lod[k] < coarsest ? lod[k] : coarsest) : 0.0f;
        const int finer = (int)l, both = l - (float)finer > 1.0e-6f, coarser = finer + both;
        level[0][k] = finer; level[1][k] = coarser;
        finest[0][k + 1] = finer < tile_level ? finer : tile_level;
        finest[1][k + 1] = coarser < tile_level ? coarser : tile_level;
        asks[0][k + 1] = number[k]; asks[1][k + 1] = both ? number[k] : 0;
        probes = number[k] > probes ? number[k] : probes;
        blended |= both;
    }
    key[0] = asks[0][0] = asks[1][0] = finest[0][0] = finest[1][0] = 0;
    for (int i = 0; i < probes; ++i) for (int o = 0; o <= blended; ++o) {
        // The tiles that a sample touches, first and last column and row, in one number.
        #pragma clang loop vectorize(assume_safety)
        for (int k = 0; k < padded; ++k) {
            const int l = level[o][k], r = (full >> l) - 1;
            const float w = (float)(r + 1);
            const int left = (int)__builtin_floorf((fu[k] + su[k]*(float)i)*w - 0.5f), right = left + 1;
            const int top = (int)__builtin_floorf((fv[k] + sv[k]*(float)i)*w - 0.5f), low = top + 1;
            const int a0 = left < 0 ? 0 : left > r ? r : left, a1 = right < 0 ? 0 : right > r ? r : right;
            const int b0 = top < 0 ? 0 : top > r ? r : top, b1 = low < 0 ? 0 : low > r ? r : low;
            const unsigned c0 = (a0 << l) >> tile_level, c1 = (((a1 + 1) << l) - 1) >> tile_level;
            const unsigned r0 = (b0 << l) >> tile_level, r1 = (((b1 + 1) << l) - 1) >> tile_level;
            key[k + 1] = (int)(c0 | c1 << 8 | r0 << 16 | r1 << 24);
        }
        // A lane's tiles are noted where neither its last probe nor the lane before it has noted the same.
        unsigned char notes[LANES];
        #pragma clang loop vectorize(assume_safety)
        for (int k = 0; k < padded; ++k) {
            const int same = (i < asks[o][k]) & (key[k + 1] == key[k]) & (finest[o][k + 1] == finest[o][k]);
            notes[k] = (i < asks[o][k + 1]) & !same & ((i == 0) | (key[k + 1] != before[o][k]));
            before[o][k] = key[k + 1];
        }
        for (int first = 0; first < padded; first += 16) {
            unsigned long long some[2]; __builtin_memcpy(some, notes + first, 16);
            if (!(some[0] | some[1])) continue;
            for (int k = first; k < first + 16; ++k) {
                if (!notes[k]) continue;
                const unsigned u = (unsigned)key[k + 1];
                const int least = finest[o][k + 1];
                for (unsigned j = u >> 16 & 255; j <= u >> 24; ++j)
                    for (unsigned c = u & 255; c <= (u >> 8 & 255); ++c)
                        // Other threads lower the same levels, but rarely.
                        for (int now = wanted[j*tiles + c]; now > least;)
                            if (__atomic_compare_exchange_n(wanted + j*tiles + c, &now, least, true, __ATOMIC_RELAXED,
                                                            __ATOMIC_RELAXED)) break;
            }
        }
    }
"""


@form(cases=[(1,), (16,)])
def marking(most: int) -> Twins:
    """The function that notes all texels which anisotropic samples of a packet's places read, with up to `most` probes.

    A target has at most 256 tiles a side.
    """

    @wp.func(module="unique")
    def mark(pages: Pages, places: wp.array(dtype=wp.float64), count: wp.int32, need: wp.array(dtype=wp.int32)):
        for lane in range(count):
            probes = probes_of(footprint_of(places, lane), pages, most)
            lod = wp.clamp(probes.lod, 0.0, wp.float32(pages.levels - 1))
            level = wp.int32(lod)
            for k in range(probes.count):
                uv = probes.first + probes.step * wp.float32(k)
                ask(need, pages, level, uv)
                if lod - wp.float32(level) > LEAST_BLEND:
                    ask(need, pages, level + 1, uv)

    code = MARK.replace("PROBES", LOG2 + ANISOTROPIC_PROBES.replace("MOST", f"{most}.0")).replace("LANES", str(LANES))
    return Twins(mark, code)


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


LIGHT_LANES = LANES * rows_of(4)


@made_once
def read_with(mark: wp.Function) -> wp.Kernel:
    """The kernel that finds what rows of a picture show, and notes all texels that pasting them reads; a row a thread.

    visible: the triangle that each pixel sees, which is found where `draws` is set. seen: of each chart, 0 before, 1
    where one of these rows shows it. need: of each tile the finest level that is read, NEVER before.
    """
    locate = locate_before(4).native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first_row: wp.int32,
        draws: wp.bool,
        grid: Grid,
        edges: wp.array(dtype=Edges),
        planes: wp.array(dtype=Planes),
        bounds: wp.array(dtype=wp.vec2d),
        visible: wp.array2d(dtype=wp.int32),
        seen: wp.array(dtype=wp.int32),
        atlas: Atlas,
        need: wp.array(dtype=wp.int32),
    ):
        j = first_row + wp.tid()
        if draws:
            see_row(j, j, grid, edges, planes, bounds, visible)
        lanes = wp.zeros(shape=(LIGHT_LANES,), dtype=wp.float32)
        places = wp.zeros(shape=(PLACES,), dtype=wp.float64)
        x = wp.int32(0)
        while x < grid.width:
            triangle = visible[j, x]
            stop = packet_end(visible, j, x, grid.width)
            if triangle >= 0:
                chart = atlas.charts[triangle]
                target = atlas.targets[chart]
                seen[chart] = 1
                if target >= 0:
                    locate(planes[triangle], grid, x, j, stop - x, places, lanes)
                    mark(pages_of(atlas, target), places, stop - x, need)
            x = stop

    return kernel


@made_once
def paste_with(fill: wp.Function) -> wp.Kernel:
    """The kernel that fills rows of a picture from the targets: the light is the texture. One thread a row."""
    locate, gather, unpremultiply = locate_before(4).native, gathering().native, unpremultiplication().native
    blank = blanking().native

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first_row: wp.int32,
        grid: Grid,
        visible: wp.array2d(dtype=wp.int32),
        planes: wp.array(dtype=Planes),
        atlas: Atlas,
        texels: wp.array(dtype=wp.vec4),
        sun: Sun,
        picture: wp.array2d(dtype=wp.vec4),
    ):
        j = first_row + wp.tid()
        blank(picture, j)
        lanes = wp.zeros(shape=(LIGHT_LANES,), dtype=wp.float32)
        places = wp.zeros(shape=(PLACES,), dtype=wp.float64)
        x = wp.int32(0)
        while x < grid.width:
            triangle = visible[j, x]
            stop = packet_end(visible, j, x, grid.width)
            if triangle >= 0:
                locate(planes[triangle], grid, x, j, stop - x, places, lanes)
                fill(texels, pages_of(atlas, atlas.targets[atlas.charts[triangle]]), places, stop - x, lanes)
                unpremultiply(lanes, sun)
                gather(lanes, x, stop - x, 1, 0, j, picture, picture)
            x = stop

    return kernel
