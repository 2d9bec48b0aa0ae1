"""The data that kernels share."""

import warp as wp

LANES = 64
"""Samples in a packet."""

Texel = wp.types.vector(length=8, dtype=wp.float32)
"""One texel of the material: albedo r, g, b; normal x, y, z; Ks; power. Interleaved, so that a fetch is one read."""

LeanTexel = wp.types.vector(length=9, dtype=wp.float32)
"""One texel of LEAN's moments; its layout is in `swimlab/render/techniques/lean.py`."""

TwistTexel = wp.types.vector(length=10, dtype=wp.float32)
"""A Texel, then x and y of the tangent."""

TEXELS = {4: wp.vec4, 8: Texel, 9: LeanTexel, 10: TwistTexel}
"""Texels by their number of floats; 4 are light with alpha."""

Edges = wp.types.matrix(shape=(3, 3), dtype=wp.float64)
"""The three edge functions of a triangle: row k dotted with (x, y, 1) is >= 0 inside edge k."""

Planes = wp.types.matrix(shape=(7, 3), dtype=wp.float64)
"""Plane equations of a triangle: rows dotted with (x, y, 1) give 1/w and u, v, x, y, z, slope divided by w."""


@wp.struct
class Grid:
    """A grid of samples over the image plane: cell (i, j) covers `pitch` pixels from `origin` + (i, j) * pitch."""

    origin: wp.vec2d
    pitch: wp.vec2d
    width: wp.int32
    height: wp.int32
    jittered: wp.int32  # 1: the sample lies anywhere in its cell, by `seed`; 0: in the centre
    seed: wp.int32


@wp.struct
class Chain:
    """The shape of a mip chain whose levels lie one after another in one array; sizes are powers of two."""

    width: wp.int32
    height: wp.int32
    levels: wp.int32
    clamps: wp.int32  # 1: addresses are clamped to the edge; 0: they repeat
    centre: wp.vec2  # the slope that moments of slopes are taken about; 0 for other contents
    offsets: wp.array(dtype=wp.int32)


@wp.struct
class Pages:
    """The shape of a chain of levels that is not stored whole: a target of which only some tiles are held.

    It is square and clamped. A tile is one texel of level `tile_level`; its finer levels lie one after another, from
    the finest that is held. The levels from `tile_level` on lie one after another as in a Chain.
    `table` has at `first` - 1 the texel where these begin, and from `first` on, tile by tile, row by row, the texel
    where a tile would begin if it had level 0.
    """

    width: wp.int32
    height: wp.int32
    levels: wp.int32
    clamps: wp.int32
    tile_level: wp.int32
    first: wp.int32
    table: wp.array(dtype=wp.int32)


@wp.struct
class Sun:
    """The light: `direction` towards it in world axes, and the deck's diffuse intensity."""

    direction: wp.vec3
    diffuse: wp.float32


@wp.struct
class Surface:
    """The surface seen by one sample.

    `uv` repeats with the maps, 0..1 within a segment; `dx` and `dy` are its derivatives by sample cell, right and down;
    `position` is relative to the eye in world axes (m); `slope` is dz/dy of the road.
    """

    uv: wp.vec2d
    dx: wp.vec2d
    dy: wp.vec2d
    position: wp.vec3d
    slope: wp.float32
