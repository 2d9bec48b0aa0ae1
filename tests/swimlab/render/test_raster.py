"""The rasteriser: who owns which sample."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from oracle import Oracle
from probe import see

from metrics.kernels.launch import Strip
from sequences import load
from swimlab.render.kernels.structs import Grid
from swimlab.render.mesh import Mesh
from swimlab.render.triangles import set_up, visibility

SIDE = 12
half_pixels = st.integers(-4, 2 * SIDE + 4)
flat_vertex = st.tuples(half_pixels, half_pixels, st.just(2))
deep_vertex = st.tuples(half_pixels, half_pixels, st.sampled_from([-4, -2, -1, 1, 2, 3, 8]))
fractions = st.floats(-2.0, SIDE + 2.0, allow_subnormal=False)
any_vertex = st.tuples(fractions, fractions, st.floats(0.25, 4.0) | st.floats(-4.0, -0.25))
often = settings(derandomize=True, max_examples=150)


def grid_of(width=SIDE, height=SIDE, origin=(0.0, 0.0)):
    grid = Grid()
    grid.origin, grid.pitch, grid.width, grid.height = origin, (1.0, 1.0), width, height
    return grid


def drawn(launcher, points, triangles, *, grid=None, strip=None):
    """Index of the triangle seen at each sample; points [N, 3] in homogeneous px."""
    points, triangles = np.asarray(points, np.float64), np.asarray(triangles, np.int32)
    mesh = Mesh(
        positions=points,
        uv=np.zeros((len(points), 2)),
        slope=np.zeros(len(points)),
        triangles=triangles,
        segments=np.zeros(len(triangles), np.int64),
        loose=np.zeros(len(triangles), bool),
    )
    ready = set_up(launcher, points, mesh)
    grid = grid or grid_of()
    return visibility(launcher, ready, grid, strip or Strip(0, grid.height)).numpy()


def samples():
    """The grid's samples in half pixels, homogeneous."""
    j, i = np.mgrid[:SIDE, :SIDE]
    return np.stack([2 * i + 1, 2 * j + 1, np.full_like(i, 2)], axis=-1)


def exactly_inside(a, b, c):
    """Where samples lie against a triangle of half-pixel integers: 1 inside, 0 on its border, -1 outside; and 1/w."""
    a, b, c = (np.array(corner, np.int64) for corner in (a, b, c))
    sample = samples()
    determinant = int(a @ np.cross(b, c))
    edges = [sample @ np.cross(*pair) * np.sign(determinant) for pair in ((b, c), (c, a), (a, b))]
    return np.sign(np.min(edges, axis=0)), sum(edges) / max(abs(determinant), 1)


def side(a, c, point):
    return np.sign(np.dot(np.array(a, np.int64), np.cross(np.array(c, np.int64), np.array(point, np.int64))))


def check_quad(launcher, a, b, c, d):
    """Triangles abc and acd on two sides of ac: what lies within the quad is covered once, what lies outside never."""
    assume(side(a, c, b) * side(a, c, d) < 0)
    points = np.array([a, b, c, d]) / 2
    covered = [drawn(launcher, points, [each]) >= 0 for each in ((0, 1, 2), (0, 2, 3))]
    (first, near_first), (second, near_second) = exactly_inside(a, b, c), exactly_inside(a, c, d)
    in_front = (near_first < 99) & (near_second < 99)
    times = np.sum(covered, axis=0)
    assert times.max() <= 1
    # On the shared edge, its ends apart: on the border of both, and of nothing else.
    on_edge = (first == 0) & (second == 0)
    for end in (a, c):
        on_edge &= np.any(np.cross(samples(), np.array(end)) != 0, axis=-1)
    assert (times[((first > 0) | (second > 0) | on_edge) & in_front] == 1).all()
    assert (times[(first < 0) & (second < 0)] == 0).all()


@often
@given(a=flat_vertex, b=flat_vertex, c=flat_vertex, d=flat_vertex)
@example(a=(1, 1, 2), b=(9, 1, 2), c=(9, 9, 2), d=(1, 9, 2))
@example(a=(5, 1, 2), b=(11, 7, 2), c=(5, 13, 2), d=(1, 7, 2))
def test_a_shared_edge_has_one_owner(launcher, a, b, c, d):
    check_quad(launcher, a, b, c, d)


@often
@given(a=deep_vertex, b=deep_vertex, c=deep_vertex, d=deep_vertex)
@example(a=(2, 2, 2), b=(9, 1, -2), c=(9, 9, 1), d=(-3, 9, 3))
def test_a_shared_edge_has_one_owner_behind_the_eye_too(launcher, a, b, c, d):
    check_quad(launcher, a, b, c, d)


@often
@given(a=any_vertex, b=any_vertex, c=any_vertex, d=any_vertex)
def test_no_rounding_covers_a_sample_twice(launcher, a, b, c, d):
    points = np.array([a, b, c, d])
    determinants = [np.linalg.det(points[list(each)]) for each in ((0, 1, 2), (0, 2, 3))]
    assume(min(np.abs(determinants)) > 1e-6)
    assume(determinants[0] * determinants[1] > 0)
    # A sample right on the shared edge, wherever that lies.
    middle = points[0] + points[2]
    assume(abs(middle[2]) > 0.1)
    grid = grid_of(origin=tuple(middle[:2] / middle[2] - SIDE / 2 - 0.5))
    covered = [drawn(launcher, points, [each], grid=grid) >= 0 for each in ((0, 1, 2), (0, 2, 3))]
    assert not (covered[0] & covered[1]).any()


@often
@given(
    centre=st.tuples(st.integers(4, 7), st.integers(4, 7)),
    spokes=st.lists(st.integers(1, 10), min_size=5, max_size=12),
    swapped=st.booleans(),
)
def test_a_fan_about_a_sample_has_no_hole(launcher, centre, spokes, swapped):
    hub = np.array([2 * centre[0] + 1, 2 * centre[1] + 1, 2])
    angles = 2 * np.pi * np.arange(len(spokes)) / len(spokes)
    rim = [
        hub + np.array([round(length * np.cos(angle)), round(length * np.sin(angle)), 0])
        for length, angle in zip(spokes, angles, strict=True)
    ]
    rim = [each for each in rim if (each != hub).any()]
    ends = list(zip(rim, rim[1:] + rim[:1], strict=True))
    turn = [np.cross(p - hub, q - hub)[2] for p, q in ends]
    assume(min(turn) > 0)
    order = (0, 2, 1) if swapped else (0, 1, 2)
    times = sum((drawn(launcher, np.array([hub, p, q]) / 2, [order]) >= 0).astype(int) for p, q in ends)
    assert times.max() == 1
    assert times[centre[1], centre[0]] == 1
    inside = np.max([exactly_inside(hub, p, q)[0] for p, q in ends], axis=0)
    assert (times[inside > 0] == 1).all()
    assert (times[inside < 0] == 0).all()


@pytest.mark.parametrize("triangles", [((0, 1, 2), (0, 2, 3)), ((0, 1, 3), (1, 2, 3)), ((2, 1, 0), (0, 3, 2))])
def test_top_and_left_edges_belong_to_the_inside(launcher, triangles):
    corners = [(2.5, 1.5, 1), (6.5, 1.5, 1), (6.5, 4.5, 1), (2.5, 4.5, 1)]
    seen = drawn(launcher, corners, triangles) >= 0
    expected = np.zeros((SIDE, SIDE), bool)
    expected[1:4, 2:6] = True
    assert np.array_equal(seen, expected)


def plane(inverse_depth, corners):
    """Vertices at screen places whose 1/w follows a function of the place."""
    return [(x / inverse_depth(x, y), y / inverse_depth(x, y), 1 / inverse_depth(x, y)) for x, y in corners]


def test_the_near_plane_cuts_sample_by_sample(launcher):
    corners = [(-1, 0.1), (20, 0.1), (20, 30), (-1, 30)]
    seen = drawn(launcher, plane(lambda x, y: 9 * y, corners), [(0, 1, 2), (0, 2, 3)]) >= 0
    # 1/w = 9 y is 100, the inverse of 1 cm, at y = 11.1.
    assert seen[:11].all()
    assert not seen[11:].any()


def test_what_lies_behind_the_eye_is_not_seen(launcher):
    behind = [(-x, -y, -1) for x, y in [(-20, -20), (40, -20), (-20, 40)]]
    assert not (drawn(launcher, behind, [(0, 1, 2)]) >= 0).any()


@pytest.mark.parametrize("first", [0, 1])
def test_the_nearer_surface_is_seen(launcher, first):
    big = [(-20, -20), (60, -20), (-20, 60)]
    far, near = plane(lambda x, y: 0.5, big), plane(lambda x, y: 1.0, [(3, 3), (30, 3), (3, 30)])
    triangles = [(0, 1, 2), (3, 4, 5)]
    seen = drawn(launcher, far + near, triangles if first == 0 else triangles[::-1])
    covered = drawn(launcher, near, [(0, 1, 2)]) >= 0
    assert covered.any()
    assert not covered.all()
    assert np.array_equal(seen == (1 if first == 0 else 0), covered)


def test_surfaces_that_cut_through_each_other_part_where_their_depths_meet(launcher):
    big = [(-20.0, -20.0), (60.0, -20.0), (-20.0, 60.0)]
    rising, level = plane(lambda x, y: 1 + (x - 6) / 64, big), plane(lambda x, y: 1.0, big)
    seen = drawn(launcher, rising + level, [(0, 1, 2), (3, 4, 5)])
    assert (seen[:, 6:] == 0).all()
    assert (seen[:, :6] == 1).all()


def test_triangles_without_area_cover_nothing(launcher):
    points = [(1.5, 1.5, 1), (9.5, 9.5, 1), (5.5, 5.5, 1), (1.5, 1.5, 1)]
    assert (drawn(launcher, points, [(0, 1, 2), (0, 3, 1), (0, 0, 0)]) == -1).all()


def test_strips_are_the_rows_of_the_whole(launcher):
    points = [(1.0, 0.0, 1), (11.0, 3.0, 1), (4.0, 12.0, 1)]
    whole = drawn(launcher, points, [(0, 1, 2)])
    parts = [drawn(launcher, points, [(0, 1, 2)], strip=strip) for strip in (Strip(0, 5), Strip(5, 1), Strip(6, 6))]
    assert np.array_equal(np.concatenate(parts), whole)


def moved(velocity, **changes):
    base = load("road-shift").with_changes(size=(64, 36), **changes)
    return base.with_changes(motion={"kind": "shift", "velocity": velocity})


@pytest.mark.parametrize("velocity", [(1 / 1024, 0.0), (0.0, -1 / 1024), (23 / 32, 19 / 32)])
def test_a_shift_moves_the_samples_by_exactly_that(shoot, maps, tolerance, velocity):
    sequence = moved(velocity)
    shot = shoot(sequence, 1)
    seen = see(shot.launcher, shot.triangles, shot.grid())
    j, i = np.mgrid[:36, :64]
    hit, position, uv, _, _ = Oracle(sequence, maps, 0).surface(i + 0.5 - velocity[0], j + 0.5 - velocity[1])
    assert np.array_equal(seen.hit, hit)
    assert hit.any()
    span = np.abs(position[hit])
    assert np.abs(seen.position[hit] - position[hit]).max() <= tolerance("surface in double") * span.max()
    assert (
        np.abs((seen.uv - uv)[hit] - np.round((seen.uv - uv)[hit])).max() <= tolerance("surface in double") * span.max()
    )


@pytest.mark.parametrize("technique", ["pixel-bilinear", "pixel-aniso", "tsl"])
def test_a_shift_by_whole_pixels_gives_the_same_bits(shoot, render, technique):
    settings = {"size": 64} if technique == "tsl" else {}
    sequence = moved((3.0, 2.0))
    before, after = (render(shoot(sequence, frame), technique, **settings).rgba for frame in (0, 1))
    assert before[..., 3].any()
    assert np.array_equal(after[2:, 3:], before[:-2, :-3])


def places(launcher, grid):
    """Where the samples of a grid lie: what a surface says whose uv are the pixels themselves."""
    corners = np.array([(-64.0, -64.0, 1.0), (192.0, -64.0, 1.0), (-64.0, 192.0, 1.0)])
    only = np.zeros(1, np.int64)
    triangle = Mesh(corners, corners[:, :2], np.zeros(3), np.array([[0, 1, 2]], np.int32), only, loose=only > 0)
    return see(launcher, set_up(launcher, corners, triangle, only), grid).uv


def test_the_jitter_stays_in_its_cell_and_is_fixed_by_seed_and_pixel(launcher, tolerance):
    def jitter(seed, origin):
        grid = grid_of(48, 48, origin)
        grid.jittered, grid.seed = 1, seed
        j, i = np.mgrid[:48, :48]
        return places(launcher, grid) - np.stack([i, j], axis=-1) - origin

    jitters = jitter(0, (0.0, 0.0))
    assert jitters.min() >= -tolerance("surface in double")
    assert jitters.max() <= 1 + tolerance("surface in double")
    assert np.abs(jitters.mean(axis=(0, 1)) - 0.5).max() < tolerance("mean of uniform numbers")
    flat = np.concatenate([jitters, jitter(1, (0.0, 0.0))], axis=2).reshape(-1, 4)
    assert np.abs(np.corrcoef(flat.T) - np.eye(4)).max() < tolerance("correlation of random numbers")
    assert np.abs(jitter(0, (-7.71875, 3.59375)) - jitters).max() <= tolerance("surface in double")
