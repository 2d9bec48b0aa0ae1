"""The road's mesh."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sequences import Camera, Road, Scene, Wires, load
from sequences.asphalt import make
from swimlab.render.mesh import WIRE_U, scene_mesh

profiles = st.one_of(
    st.just({}),
    st.fixed_dictionaries({"profile": st.just("hills"), "amplitude": st.floats(0, 3), "wavelength": st.floats(5, 200)}),
)


@settings(derandomize=True)
@given(
    profile=profiles,
    width=st.floats(0.5, 30),
    segment=st.floats(0.5, 50),
    segments=st.floats(0.1, 12),
    distance=st.floats(-1e7, 1e7),
    lateral=st.floats(-10, 10),
    cut=st.one_of(st.none(), st.tuples(st.integers(1, 4), st.integers(1, 9))),
)
def test_the_road_lies_as_it_is_described(profile, width, segment, segments, distance, lateral, cut, tolerance):
    road = Road(width=width, segment=segment, length=segment * segments, tessellation=cut, **profile)
    camera = Camera(distance=distance, lateral=lateral, height=1.3)
    mesh = scene_mesh(Scene(road=road), camera)
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
    across = 1 if cut is None else cut[0]
    assert np.unique(x) == pytest.approx(np.linspace(-width / 2, width / 2, across + 1) - lateral, abs=near)
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
    mesh = scene_mesh(Scene(road=Road(segment=8.0, length=24.0)), Camera(distance=16.0))
    assert sorted(set(mesh.segments.tolist())) == [1, 2, 3, 4]
    assert len(mesh.triangles) == 8
    assert len(np.unique(mesh.triangles)) == 16
    assert mesh.uv[np.unique(mesh.triangles[mesh.segments == 2])].tolist() == [[0, 0], [1, 0], [0, 1], [1, 1]]


@pytest.mark.parametrize("cut", [(1, 7), (5, 1), (16, 16)])
@pytest.mark.parametrize("technique", ["pixel-aniso", "tsl", "reference"])
def test_a_flat_road_looks_the_same_however_it_is_cut(shoot, render, technique, cut, tolerance):
    given = {"size": 64} if technique == "tsl" else {}
    whole = load("road-shift").with_changes(size=(64, 36), camera={"yaw": 7.0, "distance": 2.3})
    road = whole.scene.road.model_dump() | {"tessellation": cut}
    pictures = [
        render(shoot(each), technique, **given).rgba for each in (whole, whole.with_changes(scene={"road": road}))
    ]
    assert pictures[0][..., 3].any()
    assert np.array_equal(pictures[0][..., 3], pictures[1][..., 3])
    limit = tolerance("picture far from the origin") * pictures[0].max()
    assert np.abs(pictures[1] - pictures[0]).max() <= limit


def test_wires_lie_over_the_road_in_charts_of_their_own(tolerance):
    near = tolerance("road in double")
    road = Road(length=24.0, profile="hills", amplitude=0.5, wavelength=20.0, tessellation=(3, 5))
    scene = Scene(road=road, wires=Wires(count=2, width=0.02, height=0.3))
    camera = Camera(distance=16.0, lateral=0.7)
    mesh, bare = scene_mesh(scene, camera), scene_mesh(Scene(road=road), camera)
    assert not bare.loose.any()
    assert mesh.triangles[~mesh.loose].tolist() == bare.triangles.tolist()
    assert mesh.segments[0] == mesh.segments.min()
    assert not set(mesh.segments[mesh.loose]) & set(mesh.segments[~mesh.loose])
    assert len(set(mesh.segments[mesh.loose])) == 2 * len(set(bare.segments))
    for chart in set(mesh.segments[mesh.loose].tolist()):
        mine = np.unique(mesh.triangles[mesh.segments == chart])
        x, ahead, up = mesh.positions[mine].T
        assert np.ptp(x) == pytest.approx(0.02, abs=near)
        assert abs(x.mean() + camera.lateral) == pytest.approx(2.0, abs=near)
        y = ahead + camera.distance
        assert up + camera.eye(road)[2] == pytest.approx(road.height_at(y) + 0.3, abs=near)
        assert mesh.slope[mine] == pytest.approx(road.slope_at(y), abs=near)
        assert np.unique(mesh.uv[mine, 0]) == pytest.approx(np.array(WIRE_U), abs=near)
        assert np.ptp(mesh.uv[mine, 1] * road.segment - y) < near


@pytest.mark.parametrize("size", [64, 128, 256, 512, 1024, 2048])
def test_the_wires_show_painted_texels(size):
    """A map or target of any of these sizes has a texel's centre within their band, and asphalt is painted there."""
    centres = (np.arange(size) + 0.5) / size
    within = (centres > WIRE_U[0]) & (centres < WIRE_U[1])
    assert within.any()
    if size == 64:
        albedo = make(0, size).albedo
        assert albedo[:, within].mean() > 2 * albedo.mean()


@settings(derandomize=True)
@given(
    amplitude=st.floats(0, 2),
    distance=st.floats(-40, 40),
    height=st.floats(0.05, 3),
    lift=st.floats(0.01, 4),
)
def test_what_faces_the_eye_has_it_above_its_plane(amplitude, distance, height, lift, tolerance):
    road = Road(length=40.0, profile="hills", amplitude=amplitude, wavelength=20.0)
    camera = Camera(distance=distance, height=height)
    mesh = scene_mesh(Scene(road=road, wires=Wires(count=1, height=lift)), camera)
    a, b, c = mesh.positions[mesh.triangles].swapaxes(0, 1)
    rise = np.where(b[:, 1] != a[:, 1], b[:, 2] - a[:, 2], c[:, 2] - a[:, 2])
    run = np.where(b[:, 1] != a[:, 1], b[:, 1] - a[:, 1], c[:, 1] - a[:, 1])
    above = -(a[:, 2] - a[:, 1] * rise / run)
    clear = np.abs(above) > tolerance("surface in double")
    assert np.array_equal(mesh.facing[clear], above[clear] > 0)


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
