"""What runs the forms of measuring, each on inputs of its own; `test_native_forms.py` compares what they yield."""

import numpy as np
import warp as wp

from metrics.kernels.splines import LINES


def filtered(launcher, shoot, filter, width):
    """Lines of many lengths, rows and columns and of two in turns, also shorter than the recursions look ahead.

    Not all of them fill a group, or groups of places.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        source: wp.array2d(dtype=wp.float32), values: wp.array2d(dtype=wp.float32), scratch: wp.array(dtype=wp.float32)
    ):
        filter(LINES * wp.tid(), source, values, scratch)

    for count, length in ((LINES + 3, 70), (2, 9), (1, 1)):
        random = np.random.default_rng(0).random((count, length, 2), np.float32)
        pairs, scratch = launcher.array(random, wp.float32), launcher.empty(LINES * length, wp.float32)
        groups = -(-count // LINES)
        apart, upright = launcher.empty((count, length), wp.float32), launcher.empty((length, count), wp.float32)
        launcher.launch(kernel, groups, [pairs[:, :, 1], apart, scratch])
        assert (apart.numpy() != random[..., 1]).any()
        launcher.launch(kernel, groups, [pairs[:, :, 1], upright.transpose(), scratch])
        assert np.array_equal(upright.numpy().T, apart.numpy())
        upright.assign(random[..., 1].T)
        for lines in (upright.transpose(), launcher.array(random[..., 1], wp.float32)):
            launcher.launch(kernel, groups, [lines, lines, scratch])
            assert np.array_equal(lines.numpy(), apart.numpy())
        yield apart.numpy()


def unwarped(launcher, shoot, unwarp, width):
    """Rows of a picture, some pixels of which are not usable; places far apart, and side by side."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        picture: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
        usable: wp.array2d(dtype=wp.uint8),
        seen: wp.array3d(dtype=wp.float32),
    ):
        unwarp(wp.tid(), picture, away, usable, 5, seen)

    random = np.random.default_rng(0)
    usable = random.random((9, 40)) < 0.7
    picture, apart = random.random((3, 30, 40), np.float32), random.uniform(-20, 20, (9, 40, 2))
    there = launcher.array(usable.view(np.uint8), wp.uint8)
    for channels in (1, 3):
        for places in (apart, random.uniform(0, 1, (9, 40, 2)), 0.05 * np.indices((9, 40)).T.swapaxes(0, 1)):
            seen = launcher.empty((channels, 9, 40), wp.float32)
            inputs = [launcher.array(picture[:channels], wp.float32), launcher.array(places, wp.vec2), there]
            launcher.launch(kernel, 9, [*inputs, seen])
            assert not seen.numpy()[:, ~usable].any()
            assert seen.numpy()[:, usable].all()
            yield seen.numpy()


FIELD = (2, 11, 37)
"""Planes, height and width of the fields that places are followed through."""


def fields(launcher):
    """A field, a second one, and places of two rows: far beyond the field's edges, side by side within it, and farther
    than an integer holds."""
    random = np.random.default_rng(0)
    smooth, other = (launcher.array(random.uniform(-0.2, 0.2, FIELD), wp.float32) for _ in range(2))
    rows = (2, FIELD[2], 2)
    for places in (random.uniform(-40, 40, rows), 0.1 * random.random(rows), random.choice([-3e9, 0.3, 3e9], rows)):
        yield smooth, other, places


def taken_back(launcher, shoot, back, width):
    """Two rows of places, one frame back."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(field: wp.array3d(dtype=wp.float32), away: wp.array2d(dtype=wp.vec2)):
        back(wp.tid(), field, 4, away)

    for field, _, places in fields(launcher):
        away = launcher.array(places, wp.vec2)
        launcher.launch(kernel, 2, [field, away])
        assert np.abs(away.numpy() - places).std() > 0.01
        yield away.numpy()


def taken_ahead(launcher, shoot, ahead, width):
    """Two rows of places, one frame ahead, from guesses; none is lost where the field is smooth."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        field: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
        moved: wp.array2d(dtype=wp.vec2),
        usable: wp.array2d(dtype=wp.uint8),
    ):
        ahead(wp.tid(), field, 4, away, moved, 1e-3, usable)

    for field, _, places in fields(launcher):
        away, moved = launcher.array(places, wp.vec2), launcher.array(0 * places + 0.1, wp.vec2)
        usable = launcher.array(np.ones(places.shape[:2], np.uint8), wp.uint8)
        launcher.launch(kernel, 2, [field, away, moved, usable])
        assert usable.numpy().all()
        assert np.allclose(away.numpy() - moved.numpy(), places, atol=1e-5)
        yield away.numpy()


def glued_back(launcher, shoot, back, width):
    """Two rows of pixels, whose surface is in a later frame."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        field: wp.array3d(dtype=wp.float32), later: wp.array3d(dtype=wp.float32), away: wp.array2d(dtype=wp.vec2)
    ):
        back(wp.tid(), field, later, away)

    field, later, _ = next(fields(launcher))
    away = launcher.empty((2, FIELD[2]), wp.vec2)
    launcher.launch(kernel, 2, [field, later, away])
    yield away.numpy()


def glued_ahead(launcher, shoot, ahead, width):
    """The same of an earlier frame."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        motion: wp.array2d(dtype=wp.vec2), earlier: wp.array3d(dtype=wp.float32), away: wp.array2d(dtype=wp.vec2)
    ):
        ahead(wp.tid(), motion, earlier, away)

    for _, earlier, places in fields(launcher):
        away = launcher.empty((2, FIELD[2]), wp.vec2)
        launcher.launch(kernel, 2, [launcher.array(places, wp.vec2), earlier, away])
        yield away.numpy()


def landed(launcher, shoot, land, width):
    """Two rows, most of which land, some of them beside the picture, on what is not inner, or much smaller."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(inner: wp.array2d(dtype=wp.uint8), away: wp.array2d(dtype=wp.vec2), usable: wp.array2d(dtype=wp.uint8)):
        land(wp.tid(), inner, 3, away, 0.5, usable)

    random = np.random.default_rng(0)
    inner = launcher.array((random.random((9, 50)) < 0.8).view(np.uint8), wp.uint8)
    for spread in (0.05, 0.5, 5.0):
        away = launcher.array(random.uniform(-spread, spread, (2, 50, 2)), wp.vec2)
        usable = launcher.array((random.random((2, 50)) < 0.9).view(np.uint8), wp.uint8)
        launcher.launch(kernel, 2, [inner, away, usable])
        assert not usable.numpy().all()
        assert usable.numpy().any() or spread > 1
        yield usable.numpy()


def surfaces():
    """A motion field of 9 rows in which surfaces meet, some of it unknown far away, and where they are shown."""
    random = np.random.default_rng(0)
    motion = np.where(random.random((9, 50, 1)) < 0.9, (1.3, -0.6), (-2.0, 3.0)) + random.normal(0, 0.1, (9, 50, 2))
    motion[4, :3] = (1e30, np.nan), (-1e30, 0), (0, 1e6)
    return motion.astype(np.float32), (random.random((9, 50)) < 0.9).view(np.uint8)


def marked(launcher, shoot, mark, width):
    """Every row, at the edges of the picture too."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(motion: wp.array2d(dtype=wp.vec2), whole: wp.array2d(dtype=wp.uint8), found: wp.array2d(dtype=wp.uint8)):
        mark(wp.tid(), motion, 0.25, whole, found)

    motion, whole = surfaces()
    found = launcher.empty(whole.shape, wp.uint8)
    launcher.launch(kernel, len(whole), [launcher.array(motion, wp.vec2), launcher.array(whole, wp.uint8), found])
    assert 0.1 < found.numpy().mean() < whole.mean() - 0.1
    yield found.numpy()


def claimed(launcher, shoot, claim, width):
    """Every row; some places are claimed by several pixels and some by none."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        motion: wp.array2d(dtype=wp.vec2),
        shown: wp.array2d(dtype=wp.uint8),
        least: wp.array2d(dtype=wp.vec2),
        most: wp.array2d(dtype=wp.vec2),
    ):
        claim(wp.tid(), motion, shown, least, most)

    motion, shown = surfaces()
    least, most = (launcher.filled((9, 50), wp.vec2, limit) for limit in (np.inf, -np.inf))
    launcher.launch(kernel, 9, [launcher.array(motion, wp.vec2), launcher.array(shown, wp.uint8), least, most])
    assert (most.numpy() - least.numpy() > 2).any()
    assert np.isinf(least.numpy()).any()
    yield from (least.numpy(), most.numpy())


def settled(launcher, shoot, settle, width):
    """Every row, where claims agree, where they differ, and where there are none."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        least: wp.array2d(dtype=wp.vec2),
        most: wp.array2d(dtype=wp.vec2),
        motion: wp.array2d(dtype=wp.vec2),
        covered: wp.array2d(dtype=wp.uint8),
        owner: wp.array2d(dtype=wp.vec2),
    ):
        settle(wp.tid(), least, most, motion, covered, 0.3, owner)

    motion, covered = surfaces()
    least = np.where(np.roll(motion, 3, axis=1)[..., :1] < 0, np.float32(np.inf), motion[::-1])
    most = np.where(np.isinf(least), np.float32(-np.inf), least + np.float32([0.2, 0.1]) * (1 + covered[..., None]))
    owner = launcher.empty(covered.shape, wp.vec2)
    limits = [launcher.array(limit, wp.vec2) for limit in (least, most)]
    launcher.launch(kernel, 9, [*limits, launcher.array(motion, wp.vec2), launcher.array(covered, wp.uint8), owner])
    assert np.isnan(owner.numpy()[covered == 0]).all()
    yield from (np.isnan(owner.numpy()), np.nan_to_num(owner.numpy()))


def compared(launcher, shoot, compare, width):
    """Every pixel of a frame, with surfaces that are alike, that are not, and that are unknown, past all edges."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        frame: wp.array3d(dtype=wp.float32),
        before: wp.array3d(dtype=wp.float32),
        motion: wp.array2d(dtype=wp.vec2),
        owner: wp.array2d(dtype=wp.vec2),
        found: wp.array2d(dtype=wp.vec4),
    ):
        row, column = wp.tid()
        found[row, column] = compare(frame, before, motion[row, column], owner, 0.3, row, column)

    random = np.random.default_rng(0)
    frames = [launcher.array(random.random((3, 12, 30), np.float32), wp.float32) for _ in range(2)]
    moved = np.where(random.random((12, 30, 1)) < 0.8, (1.3, -0.6), (-2.0, 3.0)).astype(np.float32)
    owner = np.where(random.random((12, 30, 1)) < 0.1, np.float32(np.nan), moved)
    found = launcher.empty((12, 30), wp.vec4)
    fields = [launcher.array(each, wp.vec2) for each in (moved, owner)]
    launcher.launch(kernel, (12, 30), [*frames, *fields, found])
    assert 0.2 < found.numpy()[..., 0].mean() < 0.9
    yield found.numpy()


def waves(launcher, shoot, sum_waves, width):
    """Three waves, seen at places up to 100 px away."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        across: wp.array2d(dtype=wp.float32),
        along: wp.array2d(dtype=wp.float32),
        frequency: wp.array(dtype=wp.vec2),
        away: wp.array2d(dtype=wp.vec2),
        values: wp.array2d(dtype=wp.float32),
    ):
        sum_waves(wp.tid(), across, along, frequency, 0.5, away, values)

    random = np.random.default_rng(0)
    turns = [launcher.array(random.random(shape, np.float32), wp.float32) for shape in ((3, 50), (3, 4))]
    places = launcher.array(random.uniform(-100, 100, (4, 50, 2)), wp.vec2)
    values = launcher.empty((4, 50), wp.float32)
    launcher.launch(kernel, 4, [*turns, launcher.array(random.uniform(-0.1, 0.1, (3, 2)), wp.vec2), places, values])
    yield values.numpy()


RUNS = {
    ("first", "source", "values", "scratch"): filtered,
    ("line", "field", "top", "away"): taken_back,
    ("line", "field", "top", "away", "moved", "lost", "usable"): taken_ahead,
    ("line", "field", "later", "away"): glued_back,
    ("line", "motion", "earlier", "away"): glued_ahead,
    ("line", "picture", "away", "usable", "top", "seen"): unwarped,
    ("line", "inner", "top", "away", "shortest", "usable"): landed,
    ("row", "motion", "bend", "whole", "smooth"): marked,
    ("row", "motion", "shown", "least", "most"): claimed,
    ("row", "least", "most", "motion", "covered", "alike", "owner"): settled,
    ("frame", "before", "moved", "owner", "alike", "row", "column"): compared,
    ("row", "across", "along", "frequency", "amplitude", "away", "values"): waves,
}
"""Parameters of a form -> what runs it."""
