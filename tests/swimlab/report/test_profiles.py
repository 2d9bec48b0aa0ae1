"""Temporal profiles: pictures that move by whole pixels, and surfaces that are followed through vectors."""

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from moving_wall import COUNT, moved, ndc, to_px, wall
from occluder import Occluder
from report_runs import FRAMES, SIZE, make_run

from swimlab.report.following import follow, same_surface
from swimlab.report.profiles import profile, profiles
from swimlab.report.recorded import Run, open_run
from swimlab.runs.frames import frame_path, write_frame

VELOCITY = (2, -1)
ROW = 40


@pytest.fixture
def moving(tmp_path: Path) -> Run:
    """Noise that moves by VELOCITY; the second technique is wrong in row ROW."""
    make_run(tmp_path, techniques=("wrong", "reference"))
    width, height = SIZE
    wide = np.random.default_rng(3).uniform(0, 1, (height + FRAMES, width + 2 * FRAMES, 4)).astype(np.float32)
    wide[..., 3] = 1
    for t in range(FRAMES):
        picture = wide[t : t + height, 2 * (FRAMES - t) :][:, :width].copy()
        write_frame(frame_path(tmp_path, "reference", t), picture, half=False, metadata={})
        picture[ROW, 60:90, :3] = t % 2
        write_frame(frame_path(tmp_path, "wrong", t), picture, half=False, metadata={})
    path = tmp_path / "run.json"
    record = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**record, "uniform_velocity": VELOCITY}), encoding="utf-8")
    return open_run(tmp_path)


def lines(y: float, columns: tuple[int, int], velocity: tuple[float, float] = (0, 0)) -> np.ndarray:
    """[frames, 2, n]: a row of the middle frame that moves by `velocity`."""
    x = np.arange(*columns, dtype=np.float64)
    steps = np.arange(FRAMES) - FRAMES // 2
    return np.stack([np.stack([np.full(len(x), y + t * velocity[1]), x + t * velocity[0]]) for t in steps])


def test_a_moving_picture_is_constant_on_the_surface_and_slanted_on_the_screen(moving: Run) -> None:
    frames = list(range(FRAMES))
    (surface,) = profile(moving, "reference", frames, [lines(ROW, (20, 120), VELOCITY)])
    assert np.all(surface == surface[0])
    assert np.ptp(surface[0]) > 100
    (level,) = profile(moving, "reference", frames, [lines(ROW, (0, SIZE[0]), (0, VELOCITY[1]))])
    for before, after in pairwise(level):
        np.testing.assert_array_equal(before[: -VELOCITY[0]], after[VELOCITY[0] :])


def test_the_row_is_where_errors_are_and_is_named(moving: Run) -> None:
    (figure,) = profiles(moving)
    assert f"Row {ROW}, columns 0 to {SIZE[0] - 1}, where errors are largest" in figure.sentence
    assert figure.svg.count("<image") == 4
    still = replace(moving, settings={**moving.settings, "motion": {"kind": "none"}})
    (figure,) = profiles(still)
    assert figure.svg.count("<image") == 2
    assert "the surface is not followed here, as no motion is given." in figure.sentence


def test_outside_the_picture_is_grey(moving: Run) -> None:
    (stacked,) = profile(moving, "reference", list(range(FRAMES)), [lines(ROW, (0, 10), (-1000, 0))])
    assert [bool(np.all(row == 128)) for row in stacked] == [frame != FRAMES // 2 for frame in range(FRAMES)]


def test_a_row_is_followed_through_vectors_as_the_camera_moves(tolerance: Callable[[str], float]) -> None:
    """Back and forth from the middle frame: the same points of the wall."""
    anchor, frames = COUNT // 2, list(range(COUNT))
    row = np.stack([np.full(40, 50.0), np.arange(40, 80, dtype=np.float64)])
    places = follow(row, anchor, frames, lambda t: moved(t).astype(np.float32))
    y, x = row.astype(int)
    points = wall(anchor)[y, x]
    for t in frames:
        exact = to_px(ndc(points, t)) - 0.5
        assert places[t] == pytest.approx(exact.T[::-1], abs=tolerance("followed place"))
    assert np.abs(places[0] - row).max() > 2


def test_what_is_hidden_meanwhile_comes_back() -> None:
    """The square passes over the row; before and after it the row is where it moved to."""
    scene = Occluder((0.5, 0.0), (4.0, 0.0), 150, half=12)
    frames = list(range(24))
    row = np.stack([np.full(20, 75.0), np.arange(90, 110, dtype=np.float64)])
    places = follow(row, 23, frames, lambda t: scene.motion(t).astype(np.float32))
    for t in frames:
        hidden = scene.hidden(t)[75, :, 0]
        x = row[1] + 0.5 * (t - 23)
        near = np.array([hidden[max(0, int(c) - 1) : int(c) + 3] for c in x])
        seen = np.isfinite(places[t, 1])
        assert seen[~near.any(axis=1)].all()
        assert not seen[near.all(axis=1)].any()
        np.testing.assert_allclose(places[t, 1, seen], x[seen])
    assert not np.isfinite(places[:, 1]).all()


def test_a_camera_that_shakes_loses_nothing() -> None:
    """The whole picture leaps by many pixels from one frame to the next; the surface is where it was taken."""
    steps = np.array([[0, 0], [3, -2], [-9, 4], [14, 0], [-6, -3]])
    row = np.stack([np.full(20, 75.0), np.arange(60, 80, dtype=np.float64)])
    places = follow(row, 2, list(range(5)), lambda t: np.full((150, 150, 2), steps[t], np.float32))
    away = steps.cumsum(axis=0) - steps[:3].sum(axis=0)
    np.testing.assert_allclose(places, row + away[:, ::-1, None])
    now, before = (np.full((40, 40, 2), step, np.float32) for step in steps[2:4])
    assert same_surface(now, before)[5:-5, 10:-10].all()


def test_a_surface_that_leaves_the_picture_is_lost() -> None:
    row = np.stack([np.full(4, 10.0), np.arange(4.0)])
    places = follow(row, 1, [3, 4, 5], lambda t: np.full((20, 20, 2), (3.0, 0.0), np.float32))
    assert np.isfinite(places[:, 1]).tolist() == [[False] * 3 + [True], [True] * 4, [True] * 4]
    assert places[2, 1].tolist() == [3.0, 4.0, 5.0, 6.0]
