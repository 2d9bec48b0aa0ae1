import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sequences import Camera, Road, View


@settings(derandomize=True)
@given(yaw=st.floats(-360, 360), pitch=st.floats(-90, 90))
def test_basis_is_a_rotation_without_roll(yaw, pitch, tolerance):
    basis = Camera(yaw=yaw, pitch=pitch).basis()
    assert basis.dtype == np.float64
    assert basis @ basis.T == pytest.approx(np.eye(3), abs=tolerance("rotation"))
    assert np.linalg.det(basis) == pytest.approx(1, abs=tolerance("rotation"))
    assert basis[0, 2] == 0
    assert basis[1, 2] <= 0


@pytest.mark.parametrize(
    ("yaw", "pitch", "right", "down", "forward"),
    [
        (0, 0, (1, 0, 0), (0, 0, -1), (0, 1, 0)),
        (90, 0, (0, -1, 0), (0, 0, -1), (1, 0, 0)),
        (-90, 0, (0, 1, 0), (0, 0, -1), (-1, 0, 0)),
        (0, 90, (1, 0, 0), (0, 1, 0), (0, 0, 1)),
        (0, -90, (1, 0, 0), (0, -1, 0), (0, 0, -1)),
        (90, -90, (0, -1, 0), (-1, 0, 0), (0, 0, -1)),
        (0, 30, (1, 0, 0), (0, 0.5, -math.sqrt(0.75)), (0, math.sqrt(0.75), 0.5)),
        (30, 0, (math.sqrt(0.75), -0.5, 0), (0, 0, -1), (0.5, math.sqrt(0.75), 0)),
    ],
)
def test_yaw_is_to_the_right_and_pitch_up(yaw, pitch, right, down, forward, tolerance):
    basis = Camera(yaw=yaw, pitch=pitch).basis()
    assert basis == pytest.approx(np.array((right, down, forward), dtype=float), abs=tolerance("rotation"))


def test_a_road_point_lands_where_similar_triangles_say(tolerance):
    """Level camera, height 1.3: the road 10 m ahead and 2 m right is at f (2/10, 1.3/10) from the middle."""
    camera = Camera(pitch=0.0, height=1.3)
    right, down, forward = camera.basis() @ (np.array((2.0, 10.0, 0.0)) - camera.eye(Road()))
    focal = camera.focal(360)
    assert (focal * right / forward, focal * down / forward) == pytest.approx(
        (focal * 0.2, focal * 0.13), rel=tolerance("closed form")
    )


def test_the_field_of_view_spans_the_height(tolerance):
    assert Camera(fov=90.0).focal(360) == pytest.approx(180, rel=tolerance("closed form"))
    assert Camera(fov=50.0).focal(360) == pytest.approx(386.0112457, rel=1e-9)


def test_the_eye_stands_above_the_road_below_it(tolerance):
    hills = Road(profile="hills", amplitude=2.0, wavelength=40.0)
    camera = Camera(height=1.5, lateral=-0.5, distance=10.0)
    assert camera.eye(hills) == pytest.approx(np.array((-0.5, 10.0, 3.5)), rel=tolerance("closed form"))
    assert camera.eye(Road()).tolist() == [-0.5, 10.0, 1.5]


def test_a_view_is_plain_frozen_data():
    view = View(2, 3, origin=(0.0, 0.0), pitch=(1.0, 1.0), camera=Camera())
    assert view == View(2, 3, origin=(0.0, 0.0), pitch=(1.0, 1.0), camera=Camera())
    with pytest.raises(AttributeError):
        view.width = 4  # type: ignore[misc]
