"""What is known of the tiles of a frame: a table, [ROWS, entries] (see `swimlab.render.layout.Layout`)."""

import warp as wp

from swimlab.render.kernels.texture_space import NEVER

SHADE, KEEP, EPOCH, POSE, HELD, START, ANEW = range(7)
"""Rows of the table. SHADE: the level at which a tile is shaded, NEVER for none. KEEP: the finest level that is wanted
of its light, NEVER for none. EPOCH: the frame whose light it is. POSE: a number of where eye and sun were. HELD: the
finest level that its block has, NEVER for none. START: the block's first texel in the pool. ANEW: the level to shade it
at now, NEVER where its light is held.
"""
ROWS = 7

TILE_LEVEL = 5
"""log2 of the texels along a tile, in targets that are as large."""

MOST_TEXELS = (4 ** (TILE_LEVEL + 1) - 1) // 3
"""Texels of all levels of a tile."""

LEVELS = TILE_LEVEL + 1
"""Levels of a tile."""

wp.set_module_options({"enable_backward": False})


@wp.func
def tiles_in(shapes: wp.array(dtype=wp.vec4i), target: wp.int32) -> wp.int32:
    """How many tiles a target has."""
    across = shapes[target][0] >> shapes[target][2]
    return across * across


@wp.func
def tiles_in_sight(shapes: wp.array(dtype=wp.vec4i), finest: wp.array(dtype=wp.int32), target: wp.int32) -> wp.int32:
    """How many tiles a target has that may be read: none where it is out of sight."""
    if finest[target] == NEVER:
        return 0
    return tiles_in(shapes, target)
