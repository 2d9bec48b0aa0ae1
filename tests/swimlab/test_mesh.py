"""The road's mesh."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sequences import Camera, Road, load
from swimlab.mesh import road_mesh

profiles = st.one_of(
    st.just({}),
    st.fixed_dictionaries({"profile": st.just("hills"), "amplitude": st.floats(0, 3), "wavelength": st.floats(5, 200)}),
)


@settings(derandomize=True, deadline=None)
@given(
    profile=profiles,
    width=st.floats(0.5, 30),
    segment=st.floats(0.5, 50),
    segments=st.floats(0.1, 12),
    distance=st.floats(-1e7, 1e7),
    lateral=st.floats(-10, 10),
)
def test_the_road_lies_as_it_is_described(profile, width, segment, segments, distance, lateral, tolerance):
    road = Road(width=width, segment=segment, length=segment * segments, **profile)
    camera = Camera(distance=distance, lateral=lateral, height=1.3)
    mesh = road_mesh(road, camera)
    near = tolerance("road in double") * max(1.0, abs(distance) * 1e-7)
    x, ahead, up = mesh.positions.T

    # From one segment behind the eye to exactly the length ahead, without gaps.
    assert ahead.min() == pytest.approx(-road.segment, abs=near)
    assert ahead.max() == pytest.approx(road.length, abs=near)
    corners = mesh.positions[mesh.triangles]
    sides = corners[:, 1:, :2] - corners[:, :1, :2]
    areas = (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
    assert areas.min() >= -near * width
    assert areas.sum() == pytest.approx(width * (road.segment + road.length), rel=tolerance("road in double"))
    middles = np.sort(ahead[mesh.triangles].reshape(-1, 6).mean(axis=1))
    assert np.diff(middles).max(initial=0) <= road.segment + near

    # Every vertex is where its uv say, on the profile, seen from the eye.
    assert np.unique(x) == pytest.approx([-width / 2 - lateral, width / 2 - lateral], abs=near)
    assert x == pytest.approx((mesh.uv[:, 0] - 0.5) * width - lateral, abs=near)
    owner = np.empty(len(ahead))
    owner[mesh.triangles] = mesh.segments[:, None]
    assert (owner + mesh.uv[:, 1]) * segment - distance == pytest.approx(ahead, abs=near)
    assert mesh.uv.min() >= 0
    assert mesh.uv.max() <= 1
    y = ahead + distance
    eye = float(road.height_at(distance)) + 1.3
    steep = 1 + float(np.abs(road.slope_at(np.linspace(0, profile.get("wavelength", 1.0), 5))).max())
    assert up + eye == pytest.approx(road.height_at(y), abs=near * steep)
    bend = steep * 2 * np.pi / profile.get("wavelength", 1e9)
    assert mesh.slope == pytest.approx(road.slope_at(y), abs=near * (1 + bend))


def test_a_flat_segment_is_one_quad_of_its_own():
    mesh = road_mesh(Road(segment=8.0, length=24.0), Camera(distance=16.0))
    assert sorted(set(mesh.segments.tolist())) == [1, 2, 3, 4]
    assert len(mesh.triangles) == 8
    assert len(np.unique(mesh.triangles)) == 16
    assert mesh.uv[np.unique(mesh.triangles[mesh.segments == 2])].tolist() == [[0, 0], [1, 0], [0, 1], [1, 1]]


@pytest.mark.parametrize("far", [24.0, 8e6, 1e7])
@pytest.mark.parametrize("technique", ["pixel-bilinear", "pixel-aniso", "tsl"])
def test_the_road_repeats_for_ever(shoot, render, technique, far, tolerance):
    """The same picture some whole segments further on."""
    given = {"size": 64} if technique == "tsl" else {}
    road = load("road-shift").with_changes(size=(64, 36))
    pictures = [
        render(shoot(road.with_changes(camera={"distance": distance})), technique, **given).rgba
        for distance in (2.3, 2.3 + far)
    ]
    assert pictures[0][..., 3].any()
    assert np.array_equal(pictures[0][..., 3], pictures[1][..., 3])
    limit = tolerance("picture far from the origin") * pictures[0].max()
    assert np.abs(pictures[1] - pictures[0]).max() <= limit
