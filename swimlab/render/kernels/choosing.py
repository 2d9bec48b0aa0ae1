"""Which tiles are shaded, at what level, and how large targets are: on the host, in one thread."""

import warp as wp

from swimlab.render.kernels.texture_space import NEVER
from swimlab.render.kernels.tile_table import EPOCH, HELD, KEEP, SHADE, TILE_LEVEL, tiles_in

NEEDED, VISIBLE, ALL = range(3)
"""What is shaded: tiles that are read, at the level they are read at; these at level 0; all."""

LEAST_WIDTH = 16
"""Texels along the smallest targets."""

wp.set_module_options({"enable_backward": False})


@wp.kernel
def choose_levels(
    seen: wp.array(dtype=wp.int32),
    narrowest: wp.array(dtype=wp.float64),
    charts: wp.array(dtype=wp.int32),
    shapes: wp.array(dtype=wp.vec4i),
    need: wp.array(dtype=wp.int32),
    shading: wp.int32,
    frame: wp.int32,
    table: wp.array2d(dtype=wp.int32),
    finest: wp.array(dtype=wp.int32),
    counts: wp.array(dtype=wp.int32),
):
    """Fill SHADE and KEEP from the finest level that is read of each tile; `finest` receives that of each target.
    EPOCH is the frame, and HELD says NEVER.

    seen: which charts are in sight. narrowest: the least extent in u or v of the triangles of each chart. charts: of
    each target, -1 for none. shapes: as in Atlas. counts: receives how many charts are in sight, and how many of them
    have a target. Of a target out of sight nothing is shaded. Texels larger than a triangle may miss it, so they are
    shaded at a finer level and reduced. Of coarse levels all are kept.
    """
    for i in range(2):
        counts[i] = 0
    for chart in range(seen.shape[0]):
        counts[0] += wp.where(seen[chart] != 0, wp.int32(1), wp.int32(0))
    for k in range(shapes.shape[0]):
        first = shapes[k][3]
        chart = charts[k]
        shown = wp.bool(False)
        coarsest = wp.int32(0)
        if chart >= 0:
            shown = seen[chart] != 0
        if shown:
            counts[1] += 1
            texels = narrowest[chart] * wp.float64(shapes[k][0])
            while texels >= wp.float64(2.0):
                texels *= wp.float64(0.5)
                coarsest += 1
        least = wp.int32(NEVER)
        for entry in range(first, first + tiles_in(shapes, k)):
            keep = need[entry]
            if keep != NEVER:
                keep = wp.min(keep, coarsest)
            least = wp.min(least, keep)
            shade = keep
            if shown and (shading == ALL or (shading == VISIBLE and keep != NEVER)):
                shade = wp.int32(0)
            table[KEEP, entry] = keep
            table[SHADE, entry] = shade
            table[EPOCH, entry] = frame
            table[HELD, entry] = NEVER
        table[KEEP, first - 1] = 0
        table[SHADE, first - 1] = NEVER
        table[EPOCH, first - 1] = frame
        finest[k] = least


@wp.kernel
def fit_targets(
    finest: wp.array(dtype=wp.int32),
    coarser: wp.int32,
    whole: wp.array(dtype=wp.vec4i),
    shapes: wp.array(dtype=wp.vec4i),
):
    """Targets as large as their charts are read in whole ones, of which `finest` has the finest level, and by some
    levels smaller. shapes: receives theirs (see `swimlab.render.layout.Layout`).
    """
    entries = wp.int32(0)
    for k in range(shapes.shape[0]):
        level = wp.clamp(finest[k] + coarser, wp.int32(0), wp.int32(16))
        width = wp.max(whole[k][0] >> level, wp.int32(LEAST_WIDTH))
        levels = wp.int32(1)
        while width >> levels > 0:
            levels += 1
        tile_level = wp.min(levels - 1, wp.int32(TILE_LEVEL))
        shapes[k] = wp.vec4i(width, levels, tile_level, entries + 1)
        entries += tiles_in(shapes, k) + 1
