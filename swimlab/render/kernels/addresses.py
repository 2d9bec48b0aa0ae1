"""C++ of where a chain has the texels of a packet's probes, and what each weighs."""

OF_CHAIN = """
    // Of each lane's two levels: size, index of the first texel, and what the second weighs.
    float wide[2][LANES], high[2][LANES], blend[LANES], share[LANES];
    int right[2][LANES], low[2][LANES], start[2][LANES];
    const float coarsest = (float)(chain.levels - 1);
    const int full_width = chain.width, full_height = chain.height, last = chain.levels - 1;
    const int* __restrict offsets = chain.offsets.data;
    int most = 1, blended = 0;
    // Lanes are taken in whole vectors, which is faster: those beyond `count` have no probes, and are not read.
    const int padded = (count + 15) & ~15;
    #pragma clang loop vectorize(assume_safety)
    for (int k = 0; k < padded; ++k) {
        const float l = lod[k] > 0.0f ? (lod[k] < coarsest ? lod[k] : coarsest) : 0.0f;
        const int level = (int)l, next = level < last ? level + 1 : level;
        blend[k] = l - (float)level;
        const int w = full_width >> level, h = full_height >> level;
        const int v = full_width >> next, g = full_height >> next;
        right[0][k] = w > 1 ? w - 1 : 0; low[0][k] = h > 1 ? h - 1 : 0; start[0][k] = offsets[level];
        right[1][k] = v > 1 ? v - 1 : 0; low[1][k] = g > 1 ? g - 1 : 0; start[1][k] = offsets[next];
        for (int o = 0; o < 2; ++o) { wide[o][k] = (float)(right[o][k] + 1); high[o][k] = (float)(low[o][k] + 1); }
        share[k] = 1.0f/(float)number[k];
        most = number[k] > most ? number[k] : most;
        blended |= blend[k] > 1.0e-6f;
    }
    // Of a probe at (u, v): indices of its four texels, and how far it lies from the first to the next.
    auto locate = [&](int o, int k, float u, float v, int at[4][LANES], float& across, float& down, auto inside) {
        const float x = u*wide[o][k] - 0.5f, y = v*high[o][k] - 0.5f;
        const float left = __builtin_floorf(x), top = __builtin_floorf(y);
        across = x - left; down = y - top;
        const int r = right[o][k], l = low[o][k], i0 = (int)left, j0 = (int)top;
        const int a0 = inside(i0, r), a1 = inside(i0 + 1, r);
        const int b0 = start[o][k] + inside(j0, l)*(r + 1), b1 = start[o][k] + inside(j0 + 1, l)*(r + 1);
        at[0][k] = b0 + a0; at[1][k] = b0 + a1; at[2][k] = b1 + a0; at[3][k] = b1 + a1;
    };
    int at[2][4][LANES];
    float across[2][LANES], down[2][LANES];
    auto locate_all = [&](int o, float i, auto inside) {
        #pragma clang loop vectorize(assume_safety)
        for (int k = 0; k < padded; ++k) {
            const float u = su[k]*i, v = sv[k]*i;
            locate(o, k, fu[k] + u, fv[k] + v, at[o], across[o][k], down[o][k], inside);
BESIDE
        }
    };
    auto address = [&](int o, float i) { if (clamps) locate_all(o, i, clamped); else locate_all(o, i, repeated); };
"""
"""C++ that finds the texels of a chain: `address(o, i)` leaves in at[o][0..3][k] the indices of the four that probe i
of lane k takes of its first or second level o, for lanes that have so many probes."""


OF_FINEST = """
    // All lanes read level 0 alone.
    struct { float operator[](int) const { return 1.0f; } } share;
    struct { float operator[](int) const { return 0.0f; } } blend;
    const int most = 1, blended = 0, start = chain.offsets.data[0];
    const int right = chain.width > 1 ? chain.width - 1 : 0, low = chain.height > 1 ? chain.height - 1 : 0;
    const float wide = (float)(right + 1), high = (float)(low + 1);
    int at[2][4][LANES];
    float across[2][LANES], down[2][LANES];
    auto locate = [&](auto inside) {
        #pragma clang loop vectorize(assume_safety)
        for (int k = 0; k < ((count + 15) & ~15); ++k) {
            const float x = (float)q[k]*wide - 0.5f, y = (float)q[LANES + k]*high - 0.5f;
            const float left = __builtin_floorf(x), top = __builtin_floorf(y);
            across[0][k] = x - left; down[0][k] = y - top;
            const int i = (int)left, j = (int)top, a = inside(i, right), b = inside(i + 1, right);
            const int c = start + inside(j, low)*(right + 1), d = start + inside(j + 1, low)*(right + 1);
            at[0][0][k] = c + a; at[0][1][k] = c + b; at[0][2][k] = d + a; at[0][3][k] = d + b;
        }
    };
    auto address = [&](int, float) { if (clamps) locate(clamped); else locate(repeated); };
"""
"""The same for one probe of level 0 in each lane: a seventh of the reference's time is saved."""
