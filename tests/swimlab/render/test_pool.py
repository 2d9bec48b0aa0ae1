"""Where light is held, and in what order tiles are lit."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from made_tiles import tiles_of

from swimlab.render.atlas import Held, Light, Pool
from swimlab.render.kernels.placing import ALIGNED, BETWEEN, FILTERED
from swimlab.render.kernels.texture_space import NEVER
from swimlab.render.kernels.tile_table import ANEW, EPOCH, HELD, MOST_TEXELS, POSE, SHADE, START, TILE_LEVEL
from swimlab.render.layout import Layout, matched


def light_of(layout, numbers, widened=(), square=True, texels=32):
    """How tiles are lit in the last of frames from 0 on. widened: targets whose charts are."""
    return Light(len(numbers) - 1, numbers, np.isin(np.arange(len(layout.widths)), list(widened)), square, texels)


def test_blocks_of_targets_that_change_are_given_back(launcher):
    """However often they do, the pool grows no more."""
    pool, last, ends = Pool(launcher), Held.nothing(launcher), []
    segments = np.arange(3)
    layouts = [Layout(segments, np.array(widths, np.int32)) for widths in ([64, 32, 16], [32, 64, 64])]
    for frame in range(60):
        tiles = tiles_of(launcher, layouts[frame % 2])
        tiles.table.host[EPOCH] = 0
        pool.placing(tiles, light_of(tiles.layout, [7]), last)()
        ends.append(len(pool.texels))
        last = tiles.hold()
    assert ends[2:] == ends[2:3] * 58


def test_a_block_that_is_finer_than_wanted_is_given_back_whole(launcher):
    """What is held of a tile may have more levels than are wanted of it now; it is all there when they are."""
    pool, last, ends = Pool(launcher), Held.nothing(launcher), []
    layout = Layout(np.arange(2), np.array([64, 32], np.int32))
    for keep, shade in [(0, 0), (2, 0), (1, 0), (NEVER, NEVER)] * 20:
        tiles = tiles_of(launcher, layout, shade, keep)
        tiles.table.host[EPOCH] = 0
        pool.placing(tiles, light_of(layout, [7]), last)()
        first = layout.of(0).start
        assert tiles.table.host[HELD, first] == (NEVER if keep == NEVER else 0)
        assert (tiles.table.host[ANEW, first] == 0) == (keep == 0)
        ends.append(len(pool.texels))
        last = tiles.hold()
    assert ends[1:] == ends[1:2] * 79


LEVELS = st.one_of(st.integers(0, TILE_LEVEL), st.just(NEVER))


@st.composite
def clips(draw):
    """Tiles of some frames: which charts have targets, how large, at which level they are shaded, which levels are
    wanted, and of which light."""
    frames = []
    for _ in range(draw(st.integers(1, 6))):
        segments = np.array(sorted(draw(st.sets(st.integers(0, 5), min_size=1))))
        widths = np.array(draw(st.lists(st.sampled_from([16, 32, 64]), min_size=len(segments), max_size=len(segments))))
        layout = Layout(segments, widths.astype(np.int32))
        keep = np.array(draw(st.lists(LEVELS, min_size=layout.entries, max_size=layout.entries)))
        owners = np.searchsorted(layout.firsts - 1, np.arange(layout.entries), side="right") - 1
        keep = np.where(keep == NEVER, NEVER, np.minimum(keep, layout.tile_levels[owners]))
        keep[layout.firsts - 1] = 0
        below = st.lists(st.integers(0, TILE_LEVEL), min_size=layout.entries, max_size=layout.entries)
        shade = np.where(keep == NEVER, NEVER, np.minimum(keep, draw(below)))
        epochs = draw(st.lists(st.integers(0, 1), min_size=layout.entries, max_size=layout.entries))
        frames.append((layout, shade, keep, np.array(epochs)))
    return frames


def size_of_block(layout, entry, keep):
    """Texels that an entry holds: a tile's levels but its last, all coarse levels of a target."""
    target = np.searchsorted(layout.firsts - 1, entry, side="right") - 1
    across, tile_level = int(layout.across[target]), int(layout.tile_levels[target])
    if entry == layout.firsts[target] - 1:
        return sum(4**level for level in range(across.bit_length()))
    return sum(4**level for level in range(1, tile_level - keep + 1))


@settings(derandomize=True, max_examples=60)
@given(frames=clips())
def test_blocks_that_are_held_never_overlap(launcher, frames):
    """Whatever was given back before; all lie within the pool, beyond the texels that are nobody's. What is held of
    the frame before lies where it lay, and all else is to be shaded anew."""
    pool, last = Pool(launcher), Held.nothing(launcher)
    for layout, shade, keep, epochs in frames:
        tiles = tiles_of(launcher, layout, shade, keep)
        table, held = tiles.table.host, last.table.host
        table[EPOCH] = epochs
        pool.placing(tiles, light_of(layout, [7, 8]), last)()
        kept, start, anew = table[HELD], table[START], table[ANEW]
        blocks = [(start[k], size_of_block(layout, k, kept[k])) for k in np.flatnonzero(kept != NEVER)]
        begin, size = np.array(sorted((b, s) for b, s in blocks if s) or [(MOST_TEXELS, 0)]).T
        assert (begin[1:] >= (begin + size)[:-1]).all()
        assert (begin >= MOST_TEXELS).all()
        assert (begin + size <= len(pool.texels)).all()
        assert ((kept <= keep) | (keep == NEVER)).all()
        for target, place in enumerate(matched(layout.segments, last.layout.segments)[0]):
            if place >= 0 and last.layout.widths[place] != layout.widths[target]:
                place = -1
            for entry in range(layout.of(target).start, layout.of(target).stop):
                was = entry - layout.of(target).start + last.layout.of(place).start if place >= 0 else None
                same = was is not None and all(held[row, was] == table[row, entry] for row in (SHADE, POSE))
                if same and held[HELD, was] <= keep[entry]:
                    assert anew[entry] == NEVER
                    assert (kept[entry], start[entry]) == (held[HELD, was], held[START, was])
                else:
                    assert (anew[entry], kept[entry]) == (shade[entry], keep[entry])
        last = tiles.hold()


@settings(derandomize=True, max_examples=40)
@given(frames=clips(), square=st.booleans(), texels=st.sampled_from([8, 32]), widened=st.sets(st.integers(0, 1)))
def test_each_tile_is_in_one_job(launcher, frames, square, texels, widened):
    """Jobs are of one way, target and level each, and no larger than a whole tile."""
    layout, shade, keep, _ = frames[0]
    tiles = tiles_of(launcher, layout, shade, keep)
    table = tiles.table.host
    table[EPOCH] = 0
    given = light_of(layout, [0], widened, square, texels)
    jobs = Pool(launcher).placing(tiles, given, Held.nothing(launcher))()
    order, done = tiles.order.host, []
    for way, rows in jobs.by_way.items():
        for target, level, first, count in tiles.jobs.host[rows.start : rows.stop].tolist():
            mine = order[first : first + count]
            done += mine.tolist()
            fits = square and target not in widened
            assert way == (BETWEEN if layout.widths[target] >> level > texels else ALIGNED if fits else FILTERED)
            assert count << 2 * (layout.tile_levels[target] - level) <= 4**TILE_LEVEL
            assert (np.searchsorted(layout.firsts - 1, mine, side="right") - 1 == target).all()
            assert (table[ANEW, mine] == level).all()
            assert np.array_equal(tiles.kept.host[first : first + count], keep[mine])
    of_tiles = np.setdiff1d(np.flatnonzero(keep != NEVER), layout.firsts - 1)
    assert sorted(done) == of_tiles.tolist()
    assert jobs.total == sum(map(len, jobs.by_way.values()))
