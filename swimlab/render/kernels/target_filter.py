"""How the targets of texture-space lighting are filled from the maps, texel by texel, and how they are read."""

import warp as wp

from metrics.kernels.forms import Twins, form
from swimlab.render.kernels import sampling
from swimlab.render.kernels.packet import put_in
from swimlab.render.kernels.probes import ANISOTROPIC_PROBES
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Pages
from swimlab.render.kernels.texture_filter import AGREES, filter_of, transposed

PAGED = """
    // Of each lane's two levels: size, the block that holds a texel (see `sampling.fetch`), and what the second weighs.
    float wide[2][LANES], blend[LANES], share[LANES];
    int right[2][LANES], shift[2][LANES], entry[2][LANES], before[2][LANES];
    const int last = chain.levels - 1, full_width = chain.width, tile_level = chain.tile_level;
    const int tiles = full_width >> tile_level;
    const int* __restrict table = chain.table.data;
    int most = 1, blended = 0;
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const float coarsest = (float)last, l = lod[k] > 0.0f ? (lod[k] < coarsest ? lod[k] : coarsest) : 0.0f;
        const int level = (int)l;
        blend[k] = l - (float)level;
        for (int o = 0; o < 2; ++o) {
            const int here = o ? (level < last ? level + 1 : level) : level, w = full_width >> here;
            const bool fine = here < tile_level;
            right[o][k] = w - 1; wide[o][k] = (float)w;
            shift[o][k] = fine ? tile_level - here : 31;
            entry[o][k] = fine ? chain.first : chain.first - 1;
            const int side = fine ? 1 << (tile_level - here) : w, finest = fine ? 1 << tile_level : tiles;
            before[o][k] = 4*(finest*finest - side*side)/3;
        }
        share[k] = 1.0f/(float)number[k];
        most = number[k] > most ? number[k] : most;
        blended |= blend[k] > 1.0e-6f;
    }
    // Of a probe: where its four texels lie, first within their blocks, the entries of these, and how far it lies from
    // the first texel to the next. Entries are looked up lane by lane, as vectors of loads from anywhere take longer;
    // texels are sent for before any is read, as light lies all over the pool.
    int at[2][4][LANES], block[2][4][LANES];
    float across[2][LANES], down[2][LANES];
    auto address = [&](int o, float i) {
        #pragma clang loop vectorize(assume_safety)
        for (int k = 0; k < count; ++k) {
            const float x = (fu[k] + su[k]*i)*wide[o][k] - 0.5f, y = (fv[k] + sv[k]*i)*wide[o][k] - 0.5f;
            const float left = __builtin_floorf(x), top = __builtin_floorf(y);
            across[o][k] = x - left; down[o][k] = y - top;
            const int r = right[o][k], s = shift[o][k], i0 = (int)left, j0 = (int)top, i1 = i0 + 1, j1 = j0 + 1;
            const int a0 = i0 < 0 ? 0 : i0 > r ? r : i0, a1 = i1 < 0 ? 0 : i1 > r ? r : i1;
            const int b0 = j0 < 0 ? 0 : j0 > r ? r : j0, b1 = j1 < 0 ? 0 : j1 > r ? r : j1;
            const int side = s < 31 ? 1 << s : r + 1, mask = side - 1;
            const int upper = before[o][k] + (b0 & mask)*side, lower = before[o][k] + (b1 & mask)*side;
            const int above = entry[o][k] + (b0 >> s)*tiles, below = entry[o][k] + (b1 >> s)*tiles;
            block[o][0][k] = above + (a0 >> s); block[o][1][k] = above + (a1 >> s);
            block[o][2][k] = below + (a0 >> s); block[o][3][k] = below + (a1 >> s);
            at[o][0][k] = upper + (a0 & mask); at[o][1][k] = upper + (a1 & mask);
            at[o][2][k] = lower + (a0 & mask); at[o][3][k] = lower + (a1 & mask);
        }
        for (int k = 0; k < count; ++k) {
            if (i >= number[k]) continue;
            for (int which = 0; which < 4; ++which) at[o][which][k] += table[block[o][which][k]];
            __builtin_prefetch(data + 4*(long long)at[o][0][k]);
            __builtin_prefetch(data + 4*(long long)at[o][2][k]);
        }
    };
"""


@form(cases=[(1,), (16,)], agrees=AGREES)
def paged(most: int) -> Twins:
    """`anisotropic`, of light with alpha in a target of which only some tiles are held."""
    probes = ANISOTROPIC_PROBES.replace("MOST", f"{most}.0")
    return filter_of(sampling.anisotropic_to(most), probes, 4, PAGED, Pages)


ALIGNED = """
    typedef float vec_a __attribute__((ext_vector_type(8), aligned(4)));
    const float* __restrict data = (const float*)texels.data;
    const double* __restrict q = centres.data;
    const float step = (float)(q[2*LANES]*(double)chain.width);
    int bits; __builtin_memcpy(&bits, &step, 4);
    const int level = (bits >> 23) - 127, w = chain.width >> level, h = chain.height >> level;
    const int start = chain.offsets.data[level];
    int at[LANES];
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < count; ++k) {
        const int i = (int)(q[k]*w) & (w - 1), j = (int)(q[LANES + k]*h) & (h - 1);
        at[k] = (start + j*w + i)*WIDTH;
    }
    // Send for the rows below, which the next packet is likely to read.
    const int rows = (at[count - 1] - at[0])/(w*WIDTH) + 1;
    for (int k = 0; k < count; k += 2) __builtin_prefetch(data + at[k] + (long long)rows*w*WIDTH);
    float* __restrict out = lanes.data;
    int done = 0;
BLOCKS
    for (int k = 0; k < count; ++k)
        for (int row = k < done ? 8 : 0; row < WIDTH; ++row) out[row*LANES + k] = data[at[k] + row];
""".replace("LANES", str(LANES))


@form(cases=[(8,), (9,)])
def aligned(width: int) -> Twins:
    """Texels of one level of a square chain whose centres the places are, in cells of that level."""
    texel_type = TEXELS[width]
    put = put_in(width).native

    @wp.func(module="unique")
    def fill(
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        centres: wp.array(dtype=wp.float64),
        count: wp.int32,
        lanes: wp.array(dtype=wp.float32),
    ):
        level = wp.int32(wp.round(wp.log2(wp.float32(centres[2 * LANES] * wp.float64(chain.width)))))
        w = chain.width >> level
        h = chain.height >> level
        for lane in range(count):
            i = wp.int32(centres[lane] * wp.float64(w))
            j = wp.int32(centres[LANES + lane] * wp.float64(h))
            put(lanes, lane, sampling.fetch(texels, chain, level, i, j))

    blocks = transposed("*(const vec_a*)(data + at[done + i])")
    return Twins(fill, ALIGNED.replace("WIDTH", str(width)).replace("BLOCKS", blocks), width)
