"""Posts and rails: what stands on the road, hides it and shows it again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from metrics import measure
from metrics.kernels.launch import Strip
from sequences import Camera, Posts, Road, Scene, load
from swimlab.render.geometry import describe_geometry
from swimlab.render.mesh import UPRIGHT, scene_mesh
from swimlab.render.plan import make_plan
from swimlab.render.run import render_run
from swimlab.render.triangles import visibility
from swimlab.runs.clips import read_clip
from swimlab.runs.record import Record

SEQUENCE = load("road-posts").with_changes(size=(160, 90))
BARE = SEQUENCE.with_changes(scene=SEQUENCE.scene.model_dump() | {"posts": None})


@settings(derandomize=True)
@given(
    rows=st.lists(st.floats(-5, 5), min_size=1, max_size=4, unique=True),
    spacing=st.floats(0.5, 30),
    width=st.floats(0.01, 2),
    height=st.floats(0.1, 9),
    distance=st.floats(-1e6, 1e6),
)
def test_posts_stand_where_they_are_described(rows, spacing, width, height, distance, tolerance):
    posts = Posts(rows=rows, spacing=spacing, width=width, height=height, rail=0)
    road, camera = Road(length=40.0), Camera(distance=distance, lateral=0.7, height=1.3)
    mesh = scene_mesh(Scene(road=road, posts=posts), camera)
    near = tolerance("road in double") * max(1.0, abs(distance) * 1e-7)
    boards = mesh.positions[mesh.slope == UPRIGHT].reshape(-1, 4, 3)
    places = boards[:, 0, 1] + distance
    first, last = distance - road.segment, distance + road.length
    assert len(boards) % len(rows) == 0
    assert abs(len(boards) / len(rows) - (last - first) / spacing) <= 1
    assert np.abs(places / spacing - np.rint(places / spacing)).max(initial=0) * spacing < near
    assert np.isin(np.rint((boards[:, :, 0].mean(axis=1) + 0.7) / 1e-6), np.rint(np.array(rows) / 1e-6)).all()
    assert np.ptp(boards[..., 0], axis=1) == pytest.approx(np.full(len(boards), width), abs=near)
    assert boards[..., 2].min(axis=1) == pytest.approx(np.full(len(boards), -1.3), abs=near)
    assert np.ptp(boards[..., 2], axis=1) == pytest.approx(np.full(len(boards), height), abs=near)
    assert mesh.uv.min() >= 0
    assert mesh.uv.max() <= 1
    # Their faces are turned to who comes along, and each has a chart of its own.
    upright = mesh.slope[mesh.triangles[:, 0]] == UPRIGHT
    assert mesh.facing[upright & (mesh.positions[mesh.triangles[:, 0], 1] > 0)].all()
    assert len(np.unique(mesh.segments[upright])) == len(boards)
    assert not np.isin(mesh.segments[upright], mesh.segments[~upright]).any()


def test_rows_at_one_place_are_an_error():
    with pytest.raises(ValidationError, match="two rows stand at one place"):
        Posts(rows=(1.0, 2.0, 1.0))


def boards(shot):
    """Where a post is seen, [H, W]."""
    index = visibility(shot.launcher, shot.triangles, shot.grid(), Strip(0, shot.view.height)).numpy()
    upright = shot.mesh.slope[shot.mesh.triangles[:, 0]] == UPRIGHT
    return (index >= 0) & upright[index]


def test_a_post_is_seen_where_a_pinhole_shows_it(shoot, tolerance):
    shot = shoot(SEQUENCE, 3)
    camera, posts = shot.view.camera, SEQUENCE.scene.posts
    (height, width), focal = (90, 160), camera.focal(90)
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    pitch = np.radians(-8.0)
    ahead, up = np.cos(pitch) + np.sin(pitch) * y / focal, np.sin(pitch) - np.cos(pitch) * y / focal
    expected = np.zeros((height, width), dtype=bool)
    distance = np.inf
    for place in posts.spacing * np.arange(60):
        away = place - camera.distance
        if 0 < away < SEQUENCE.scene.road.length:
            right, above = x / focal * away / ahead, camera.height + up / ahead * away
            for row in posts.rows:
                expected |= (np.abs(right - row) < posts.width / 2) & (above > 0) & (above < posts.height)
            distance = min(distance, away)
    assert expected.sum() > 100
    # The rails, which hide parts of them, are left out.
    railless = SEQUENCE.with_changes(scene=SEQUENCE.scene.model_dump() | {"posts": posts.model_dump() | {"rail": 0}})
    assert np.mean(boards(shoot(railless, 3)) == expected) >= tolerance("equal pixels")


def test_posts_move_as_they_are_passed(shoot, tolerance):
    """The motion of a post is that of a point of its face: seen at depth z it was seen at depth z + speed before."""
    shot = shoot(SEQUENCE, 3)
    geometry, mine = describe_geometry(shot), boards(shot)
    step = SEQUENCE.motion.speed / SEQUENCE.fps
    focal, pitch = shot.view.camera.focal(90), np.radians(-8.0)
    row, column = np.nonzero(mine)
    depth = geometry.depth[row, column].astype(float)
    x, y = (column + 0.5 - 80) * depth / focal, (row + 0.5 - 45) * depth / focal
    # Ahead in the camera's axes: the road's y is the axis turned up by the pitch.
    before = depth + step * np.cos(pitch), y + step * np.sin(pitch)
    expected = np.stack([x / depth - x / before[0], y / depth - before[1] / before[0]], axis=1) * focal
    assert np.abs(geometry.motion[row, column] - expected).max() < tolerance("correspondence")


@pytest.mark.parametrize(("sequence", "least", "most"), [(SEQUENCE, 1.3, 9.0), (BARE, 0.5, 1.1)], ids=["posts", "bare"])
def test_a_history_leaves_ghosts_where_the_road_comes_into_view(sequence, least, most, tmp_path):
    """Of what is new, temporal anti-aliasing errs more than the frames that it blends, but only behind posts."""
    names = ("pixel-aniso", "taa", "reference")
    render_run(make_plan(sequence.with_changes(size=(320, 180)), names, frames="0-7", samples=36), tmp_path)
    frames, record = list(range(8)), Record.read(tmp_path)
    clips = {name: read_clip(tmp_path, record, name, frames) for name in names}
    found = {name: measure(clips[name], clips["reference"], names=["edges", "new"]) for name in names[:2]}
    # Of the first frame all is new that tiles do not reach.
    wrong = [np.mean([row.get("new_mse", 0.0) for row in found[name].frames[1:]]) for name in ("taa", "pixel-aniso")]
    assert least < wrong[0] / wrong[1] < most
    assert all(measured.scores["edges.flicker"] > 0 for measured in found.values())
