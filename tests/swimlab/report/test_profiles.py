"""Temporal profiles against a picture that moves by whole pixels."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from report_runs import FRAMES, SIZE, make_run

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


def test_a_moving_picture_is_constant_on_the_surface_and_slanted_on_the_screen(moving: Run) -> None:
    surface = profile(moving, "reference", ROW, (20, 120), [VELOCITY])[0]
    assert np.all(surface == surface[0])
    assert np.ptp(surface[0]) > 100
    level = profile(moving, "reference", ROW, (0, SIZE[0]), [(0, VELOCITY[1])])[0]
    for before, after in pairwise(level):
        np.testing.assert_array_equal(before[: -VELOCITY[0]], after[VELOCITY[0] :])


def test_the_row_is_where_errors_are_and_is_named(moving: Run) -> None:
    (figure,) = profiles(moving)
    assert f"Row {ROW}, columns 0 to {SIZE[0] - 1}, where errors are largest" in figure.sentence
    assert figure.svg.count("<image") == 4
    (still,) = profiles(replace(moving, uniform_velocity=None))
    assert still.svg.count("<image") == 2
    assert "not followed" in still.sentence


def test_outside_the_picture_is_grey(moving: Run) -> None:
    stacked = profile(moving, "reference", ROW, (0, 10), [(-1000, 0)])[0]
    assert [bool(np.all(row == 128)) for row in stacked] == [frame != FRAMES // 2 for frame in range(FRAMES)]
