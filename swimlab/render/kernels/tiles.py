"""Lighting tiles of targets: a task shades some tiles at one level, and reduces them while they are in the cache.

A job is [target, level, first, count]: `count` tiles of a target, `tiles[first]`..., to be shaded at `level`; `tiles`
has each tile's entry in the table of its target (see Pages), `kept` the finest level that is kept, or NEVER. A job has
as many texels as a tile at level 0, at coarse levels of many tiles. Levels of a tile lie one after another, down to one
texel.
"""

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once
from swimlab.render.kernels.job_texels import centre, locate_texels, owner_of
from swimlab.render.kernels.packet import PLACES, rows_of
from swimlab.render.kernels.raster import covers
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Edges, Pages, Planes, Sun
from swimlab.render.kernels.texture_space import NEVER, Atlas, pages_of
from swimlab.render.kernels.tile_table import MOST_TEXELS

wp.set_module_options({"enable_backward": False})


COLLECT = """
    const float* __restrict a = lanes.data;
    const int depth2 = 2*depth, tile = 1 << depth2, all = (4*tile - 1)/3;
    float* __restrict out = (float*)texels.data;
    int found = 0;
    for (int k = 0; k < count; ++k) found += owners.data[k] >= 0;
    if (found == count && tile >= LANES) {
        out += 4*((s >> depth2)*all + (s & (tile - 1)));
        for (int k = 0; k < count; ++k) {
            out[4*k] = a[k]; out[4*k + 1] = a[LANES + k]; out[4*k + 2] = a[2*LANES + k]; out[4*k + 3] = 1.0f;
        }
        return found;
    }
    for (int k = 0; k < count; ++k) {
        if (owners.data[k] < 0) continue;
        float* to = out + 4*(((s + k) >> depth2)*all + ((s + k) & (tile - 1)));
        to[0] = a[k]; to[1] = a[LANES + k]; to[2] = a[2*LANES + k]; to[3] = 1.0f;
    }
    return found;
""".replace("LANES", str(LANES))


@form()
def collecting() -> Twins:
    """The function that puts a packet's radiance into the tiles of a job, from texel `s` on; how many texels they are.

    depth: log2 of a tile's side. owners: the triangle under each lane; lanes without one are left out.
    """

    @wp.func(module="unique")
    def collect(
        lanes: wp.array(dtype=wp.float32),
        owners: wp.array(dtype=wp.int32),
        s: wp.int32,
        count: wp.int32,
        depth: wp.int32,
        texels: wp.array(dtype=wp.vec4),
    ) -> wp.int32:
        found = wp.int32(0)
        tile = 1 << (2 * depth)
        for k in range(count):
            if owners[k] >= 0:
                here = s + k
                place = (here / tile) * ((4 * tile - 1) / 3) + here % tile
                texels[place] = wp.vec4(lanes[k], lanes[LANES + k], lanes[2 * LANES + k], 1.0)
                found += 1
        return found

    return Twins(collect, COLLECT)


@wp.func
def halve_square(texels: wp.array(dtype=wp.vec4), first: wp.int32, side: wp.int32) -> wp.int32:
    """Put the means of 2x2 behind a square of texels, and return where they begin."""
    out = first + side * side
    half = side / 2
    for j in range(half):
        for i in range(half):
            at = first + 2 * j * side + 2 * i
            total = (texels[at] + texels[at + 1]) + (texels[at + side] + texels[at + side + 1])
            texels[out + j * half + i] = total * 0.25
    return out


KEEP = """
    const int depth = pages.tile_level - level, all = ((4 << 2*depth) - 1)/3, finest = 1 << pages.tile_level;
    float* to = (float*)held.data;
    for (int t = 0; t < count; ++t) {
        const int wanted = kept.data[first + t], entry = tiles.data[first + t];
        if (wanted > pages.tile_level) continue;
        float* block = (float*)(texels.data + t*all);
        const float* upper = block;
        for (int side = 1 << depth; side > 1; side >>= 1) {
            float* __restrict out = block + (upper - block) + 4*side*side;
            for (int j = 0; j < side/2; ++j, upper += 8*side, out += 2*side) {
                const float* lower = upper + 4*side;
                for (int i = 0; i < side/2; ++i)
                    for (int c = 0; c < 4; ++c)
                        out[4*i + c] = ((upper[8*i + c] + upper[8*i + 4 + c])
                                        + (lower[8*i + c] + lower[8*i + 4 + c]))*0.25f;
            }
        }
        const int side = 1 << (pages.tile_level - wanted), mine = ((4*side*side) - 1)/3;
        float* out = to + 4*(pages.table.data[entry] + 4*(finest*finest - side*side)/3);
        for (int k = 0; k < 4*(mine - 1); ++k) out[k] = block[4*(all - mine) + k];
        out = to + 4*(pages.table.data[pages.first - 1] + entry - pages.first);
        for (int c = 0; c < 4; ++c) out[c] = block[4*(all - 1) + c];
    }
"""


@form()
def keeping() -> Twins:
    """The function that reduces the tiles of a job by means of 2x2 and copies the levels that are kept to `held`."""

    @wp.func(module="unique")
    def keep(
        texels: wp.array(dtype=wp.vec4),
        tiles: wp.array(dtype=wp.int32),
        kept: wp.array(dtype=wp.int32),
        first: wp.int32,
        count: wp.int32,
        level: wp.int32,
        pages: Pages,
        held: wp.array(dtype=wp.vec4),
    ):
        depth = pages.tile_level - level
        whole = ((4 << (2 * depth)) - 1) / 3
        finest = 1 << pages.tile_level
        for t in range(count):
            wanted = kept[first + t]
            entry = tiles[first + t]
            if wanted <= pages.tile_level:
                upper = wp.int32(t * whole)
                side = wp.int32(1 << depth)
                while side > 1:
                    upper = halve_square(texels, upper, side)
                    side = side / 2
                side = 1 << (pages.tile_level - wanted)
                mine = (4 * side * side - 1) / 3
                start = pages.table[entry] + 4 * (finest * finest - side * side) / 3
                for k in range(mine - 1):
                    held[start + k] = texels[t * whole + whole - mine + k]
                held[pages.table[pages.first - 1] + entry - pages.first] = texels[t * whole + whole - 1]

    return Twins(keep, KEEP)


@made_once
def light_tiles(fill: wp.Function, shade_packet: wp.Function, width: int) -> wp.Kernel:
    """The kernel that shades, reduces and keeps tiles, one thread a job.

    Techniques differ in `fill` and `shade_packet`, as in `shade_samples`. charts: of each target the first of its
    triangles and one past the last. lit: receives how many texels each job shaded.
    """
    texel_type = TEXELS[width]
    locate, collect, keep = locate_texels(width).native, collecting().native, keeping().native
    floats = LANES * rows_of(width)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first_job: wp.int32,
        jobs: wp.array2d(dtype=wp.int32),
        tiles: wp.array(dtype=wp.int32),
        kept: wp.array(dtype=wp.int32),
        atlas: Atlas,
        charts: wp.array(dtype=wp.vec2i),
        edges: wp.array(dtype=Edges),
        planes: wp.array(dtype=Planes),
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        held: wp.array(dtype=wp.vec4),
        lit: wp.array(dtype=wp.int64),
    ):
        job = first_job + wp.tid()
        target = jobs[job, 0]
        level = jobs[job, 1]
        first = jobs[job, 2]
        count = jobs[job, 3]
        pages = pages_of(atlas, target)
        chart = charts[target]
        depth = pages.tile_level - level
        light = wp.zeros(shape=(MOST_TEXELS,), dtype=wp.vec4)
        lanes = wp.zeros(shape=(floats,), dtype=wp.float32)
        places = wp.zeros(shape=(PLACES,), dtype=wp.float64)
        owners = wp.zeros(shape=(LANES,), dtype=wp.int32)
        side = 1 << depth
        tile = side * side
        total = count * tile
        if chart[0] == chart[1]:
            total = wp.int32(0)
        owner = wp.int32(-1)
        whole = wp.bool(False)
        guess = chart[0]
        found = wp.int32(0)
        s = wp.int32(0)
        while s < total:
            n = wp.min(LANES, total - s)
            # A tile whose corners one triangle owns is wholly that triangle's.
            if tile >= LANES and s % tile == 0:
                owner = owner_of(edges, chart, guess, centre(tiles, first, pages, level, s))
                whole = owner >= 0
                if whole:
                    whole = whole and covers(edges[owner], centre(tiles, first, pages, level, s + side - 1))
                    whole = whole and covers(edges[owner], centre(tiles, first, pages, level, s + tile - side))
                    whole = whole and covers(edges[owner], centre(tiles, first, pages, level, s + tile - 1))
                if whole:
                    for k in range(LANES):
                        owners[k] = owner
                    guess = owner
            if whole:
                locate(planes[owner], tiles, first, pages, level, s, 0, n, places, lanes)
            else:
                for k in range(n):
                    here = owner_of(edges, chart, guess, centre(tiles, first, pages, level, s + k))
                    owners[k] = here
                    guess = wp.where(here >= 0, here, guess)
                k = wp.int32(0)
                while k < n:
                    stop = wp.int32(k + 1)
                    while stop < n and owners[stop] == owners[k]:
                        stop += 1
                    # Lanes without a triangle have a place too, as filters take all lanes.
                    plane = wp.where(owners[k] >= 0, owners[k], guess)
                    locate(planes[plane], tiles, first, pages, level, s, k, stop, places, lanes)
                    k = stop
            fill(texels, chain, places, n, lanes)
            shade_packet(lanes, sun)
            found += collect(lanes, owners, s, n, depth, light)
            s += n
        keep(light, tiles, kept, first, count, level, pages, held)
        lit[job] = wp.int64(found)

    return kernel


@wp.kernel
def reduce_coarse(
    first_target: wp.int32, atlas: Atlas, finest: wp.array(dtype=wp.int32), held: wp.array(dtype=wp.vec4)
):
    """Fill the levels of a target at which a texel is more than a tile, one thread a target.

    finest: the finest level that is read of each, NEVER for none.
    """
    target = first_target + wp.tid()
    if finest[target] != NEVER:
        pages = pages_of(atlas, target)
        upper = wp.int32(pages.table[pages.first - 1])
        side = wp.int32(pages.width >> pages.tile_level)
        while side > 1:
            upper = halve_square(held, upper, side)
            side = side / 2
