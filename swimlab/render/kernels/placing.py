"""Where the light of tiles is held, and in what order it is made: on the host, in one thread."""

import warp as wp

from swimlab.render.kernels.texture_space import NEVER
from swimlab.render.kernels.tile_table import (
    ANEW,
    EPOCH,
    HELD,
    KEEP,
    LEVELS,
    MOST_TEXELS,
    POSE,
    SHADE,
    START,
    TILE_LEVEL,
    tiles_in,
    tiles_in_sight,
)

KINDS = LEVELS + 9
"""Kinds of blocks, each of one size: a tile's by its levels, coarse levels' by the tiles along their target."""

ALIGNED, BETWEEN, FILTERED = range(3)
"""Ways to light a job: its texels are a level of the maps; they lie between those of level 0; neither."""
WAYS = 3

wp.set_module_options({"enable_backward": False})


@wp.func
def kind_of(width: wp.int32, tile_level: wp.int32, coarse: wp.bool, keep: wp.int32) -> wp.int32:
    """The kind of an entry's block."""
    if not coarse:
        return tile_level - wp.min(keep, tile_level)
    kind = wp.int32(LEVELS)
    while (width >> tile_level) >> (kind - LEVELS) > 1:
        kind += 1
    return kind


@wp.func
def size_of(kind: wp.int32) -> wp.int64:
    """Texels of a block: of a tile all levels but that of one texel, which is among the coarse levels."""
    if kind < LEVELS:
        return ((wp.int64(4) << wp.int64(2 * kind)) - wp.int64(1)) / wp.int64(3) - wp.int64(1)
    return ((wp.int64(4) << wp.int64(2 * (kind - LEVELS))) - wp.int64(1)) / wp.int64(3)


@wp.func
def is_held(
    now: wp.array2d(dtype=wp.int32),
    entry: wp.int32,
    last: wp.array2d(dtype=wp.int32),
    was: wp.int32,
    coarse: wp.bool,
) -> wp.bool:
    """Whether what was held of an entry, if anything, will do for what is wanted of it now."""
    if coarse:
        return True
    same = last[SHADE, was] == now[SHADE, entry] and last[POSE, was] == now[POSE, entry]
    return same and last[HELD, was] <= now[KEEP, entry]


@wp.func
def hold_tiles(
    oldest: wp.int32,
    poses: wp.array(dtype=wp.int32),
    shapes: wp.array(dtype=wp.vec4i),
    finest: wp.array(dtype=wp.int32),
    before: wp.array(dtype=wp.int32),
    now: wp.array2d(dtype=wp.int32),
    pages: wp.array(dtype=wp.int32),
    last_shapes: wp.array(dtype=wp.vec4i),
    after: wp.array(dtype=wp.int32),
    last: wp.array2d(dtype=wp.int32),
    free: wp.array2d(dtype=wp.int32),
    count: wp.array(dtype=wp.int32),
    end: wp.array(dtype=wp.int64),
):
    """Fill POSE, HELD, START and ANEW: blocks of what is lost are given back, and others taken for what is new.

    finest: as `choose_levels` leaves it; of targets out of sight only coarse levels are looked at. pages: receives
    where kernels find blocks, the `table` of Pages. poses: of frames from `oldest` on. before: of each target its place
    in the last frame, or -1; after: the other way round. free: first texels of blocks of each kind that nobody has,
    `count` of each. end: the pool's first texel that nobody ever had. Where nothing was held both begin anew.
    """
    if last_shapes.shape[0] == 0:
        end[0] = wp.int64(MOST_TEXELS)
        for kind in range(KINDS):
            count[kind] = 0
    for k in range(shapes.shape[0]):
        for entry in range(shapes[k][3] - 1, shapes[k][3] + tiles_in_sight(shapes, finest, k)):
            now[POSE, entry] = poses[now[EPOCH, entry] - oldest]
    for j in range(last_shapes.shape[0]):
        k = after[j]
        for i in range(-1, tiles_in(last_shapes, j)):
            was = last_shapes[j][3] + i
            if last[HELD, was] != NEVER:
                lost = k < 0
                if not lost:
                    lost = shapes[k][0] != last_shapes[j][0]
                if not lost:
                    lost = not is_held(now, shapes[k][3] + i, last, was, i < 0)
                if lost:
                    kind = kind_of(last_shapes[j][0], last_shapes[j][2], i < 0, last[HELD, was])
                    free[kind, count[kind]] = last[START, was]
                    count[kind] += 1
    for k in range(shapes.shape[0]):
        tile_level = shapes[k][2]
        whole = 1 << (2 * tile_level)
        j = before[k]
        if j >= 0:
            if last_shapes[j][0] != shapes[k][0]:
                j = wp.int32(-1)
        for i in range(-1, tiles_in_sight(shapes, finest, k)):
            entry = shapes[k][3] + i
            keep = now[KEEP, entry]
            anew = now[SHADE, entry]
            start = wp.int32(0)
            held = wp.bool(False)
            if j >= 0:
                was = last_shapes[j][3] + i
                held = is_held(now, entry, last, was, i < 0)
                if held:
                    keep = last[HELD, was]
                    anew = wp.int32(NEVER)
                    if keep != NEVER:
                        start = last[START, was]
            if not held and keep != NEVER:
                kind = kind_of(shapes[k][0], tile_level, i < 0, keep)
                if count[kind] > 0:
                    count[kind] -= 1
                    start = free[kind, count[kind]]
                else:
                    start = wp.int32(end[0])
                    end[0] += size_of(kind)
            now[HELD, entry] = keep
            now[START, entry] = start
            now[ANEW, entry] = anew
            # A tile's table says where its level 0 would begin.
            if i >= 0 and keep != NEVER:
                start -= 4 * (whole - (whole >> (2 * wp.min(keep, tile_level)))) / 3
            pages[entry] = start


@wp.func
def way_of(
    widened: wp.array(dtype=wp.bool),
    square: wp.bool,
    texels: wp.int32,
    shapes: wp.array(dtype=wp.vec4i),
    target: wp.int32,
    level: wp.int32,
) -> wp.int32:
    """How a level of a target is lit. Between texels of the maps two normals that are blended by magnification are no
    roughness."""
    if shapes[target][0] >> level > texels:
        return wp.int32(BETWEEN)
    return wp.where(square and not widened[target], wp.int32(ALIGNED), wp.int32(FILTERED))


@wp.func
def order_jobs(
    widened: wp.array(dtype=wp.bool),
    square: wp.bool,
    texels: wp.int32,
    shapes: wp.array(dtype=wp.vec4i),
    finest: wp.array(dtype=wp.int32),
    table: wp.array2d(dtype=wp.int32),
    places: wp.array2d(dtype=wp.int32),
    tiles: wp.array(dtype=wp.int32),
    kept: wp.array(dtype=wp.int32),
    jobs: wp.array2d(dtype=wp.int32),
    ends: wp.array(dtype=wp.int32),
):
    """Jobs of all tiles to be shaded now, by way, target and level (see `swimlab.render.kernels.tiles`).

    widened: of each target, whether its chart is. square: whether the maps are as long as wide. texels: of them along
    their longer side. places: [targets, LEVELS], scratch. ends: [WAYS], receives one past the last job of each.
    """
    for k in range(places.shape[0]):
        for level in range(LEVELS):
            places[k, level] = 0
    for k in range(shapes.shape[0]):
        for entry in range(shapes[k][3], shapes[k][3] + tiles_in_sight(shapes, finest, k)):
            level = table[ANEW, entry]
            if level != NEVER:
                places[k, level] += 1
    placed = wp.int32(0)
    found = wp.int32(0)
    for way in range(WAYS):
        for k in range(shapes.shape[0]):
            for level in range(LEVELS):
                wanted = places[k, level]
                if wanted > 0 and way_of(widened, square, texels, shapes, k, level) == way:
                    stop = placed + wanted
                    places[k, level] = placed
                    while placed < stop:
                        together = wp.min(1 << (2 * (TILE_LEVEL - shapes[k][2] + level)), stop - placed)
                        jobs[found, 0] = k
                        jobs[found, 1] = level
                        jobs[found, 2] = placed
                        jobs[found, 3] = together
                        found += 1
                        placed += together
        ends[way] = found
    for k in range(shapes.shape[0]):
        for entry in range(shapes[k][3], shapes[k][3] + tiles_in_sight(shapes, finest, k)):
            level = table[ANEW, entry]
            if level != NEVER:
                place = places[k, level]
                places[k, level] = place + 1
                tiles[place] = entry
                kept[place] = table[HELD, entry]


@wp.kernel
def place_tiles(
    oldest: wp.int32,
    poses: wp.array(dtype=wp.int32),
    widened: wp.array(dtype=wp.bool),
    square: wp.bool,
    texels: wp.int32,
    shapes: wp.array(dtype=wp.vec4i),
    finest: wp.array(dtype=wp.int32),
    before: wp.array(dtype=wp.int32),
    now: wp.array2d(dtype=wp.int32),
    pages: wp.array(dtype=wp.int32),
    last_shapes: wp.array(dtype=wp.vec4i),
    after: wp.array(dtype=wp.int32),
    last: wp.array2d(dtype=wp.int32),
    free: wp.array2d(dtype=wp.int32),
    count: wp.array(dtype=wp.int32),
    end: wp.array(dtype=wp.int64),
    places: wp.array2d(dtype=wp.int32),
    tiles: wp.array(dtype=wp.int32),
    kept: wp.array(dtype=wp.int32),
    jobs: wp.array2d(dtype=wp.int32),
    ends: wp.array(dtype=wp.int32),
):
    """Hold tiles, and put what is to be shaded in order."""
    hold_tiles(oldest, poses, shapes, finest, before, now, pages, last_shapes, after, last, free, count, end)
    order_jobs(widened, square, texels, shapes, finest, now, places, tiles, kept, jobs, ends)
