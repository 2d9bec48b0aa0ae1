"""Coverage, exact motion and depth."""

import numpy as np
import pytest
from oracle import Oracle
from scipy.ndimage import map_coordinates

from sequences import load
from swimlab.render.geometry import describe_geometry

SHIFT = load("road-shift").with_changes(size=(128, 72))
VIEWS = {
    "shift": (SHIFT, 2),
    "first frame": (SHIFT, 0),
    "scale": (load("road-scale").with_changes(size=(128, 72), frames=9), 2),
    "drive": (load("road-drive").with_changes(size=(128, 72)), 4),
    "turned drive": (
        load("road-drive").with_changes(size=(128, 72), camera={"yaw": 30.0, "lateral": -1.5, "distance": 77.7}),
        1,
    ),
    "turn": (load("road-turn").with_changes(size=(128, 72)), 4),
    "tessellated": (
        load("road-turn").with_changes(size=(128, 72), scene={"road": {"tessellation": (3, 5)}}, camera={"yaw": 12.0}),
        7,
    ),
}


def eye(oracle):
    camera = oracle.sequence.view(oracle.frame).camera
    return np.array([camera.lateral, camera.distance, camera.height])


def world(oracle, i, j):
    """Place in the world, [..., 3], of grid places (i, j) of a frame, on the plane of the road."""
    view = oracle.sequence.view(oracle.frame)
    x, y = view.origin[0] + i * view.pitch[0], view.origin[1] + j * view.pitch[1]
    return oracle.surface(x, y)[1] + eye(oracle)


def test_shift_moves_everything_by_its_velocity(shoot, tolerance):
    geometry = describe_geometry(shoot(SHIFT, 5))
    hit = geometry.depth > 0
    assert hit.any()
    assert np.abs(geometry.motion[hit] - SHIFT.motion.velocity).max() <= tolerance("motion")
    assert not geometry.motion[~hit].any()


@pytest.mark.parametrize("name", VIEWS)
def test_motion_leads_back_to_the_same_place(shoot, maps, tolerance, name):
    sequence, frame = VIEWS[name]
    geometry = describe_geometry(shoot(sequence, frame))
    now, before = Oracle(sequence, maps, frame), Oracle(sequence, maps, frame - 1)
    j, i = np.mgrid[: geometry.depth.shape[0], : geometry.depth.shape[1]] + 0.5
    hit = geometry.depth > 0
    motion = geometry.motion.astype(np.float64)
    place = world(now, i, j)
    was = world(before, i - motion[..., 0], j - motion[..., 1])
    near = hit & (geometry.depth < 30)
    assert near.sum() > 0.3 * hit.sum()
    assert np.abs(was - place)[near].max() <= tolerance("place under motion")


@pytest.mark.parametrize("name", VIEWS)
def test_warping_a_pattern_on_the_road_leaves_interpolation_error_only(shoot, maps, tolerance, name):
    sequence, frame = VIEWS[name]
    geometry = describe_geometry(shoot(sequence, frame))
    now, before = Oracle(sequence, maps, frame), Oracle(sequence, maps, frame - 1)

    def painted(oracle, x, y):
        place = world(oracle, x, y)
        return np.cos(2 * np.pi * place[..., 0] / 8.0 + 0.3) * np.sin(2 * np.pi * place[..., 1] / 8.0)

    view = sequence.view(frame - 1)
    row, column = np.mgrid[: view.height, : view.width] + 0.5
    previous = np.nan_to_num(painted(before, column, row))
    j, i = np.mgrid[: geometry.depth.shape[0], : geometry.depth.shape[1]] + 0.5
    was = np.stack([j - geometry.motion[..., 1], i - geometry.motion[..., 0]])
    # Array index k holds the place k + 1/2; the spline wants some rows about it.
    warped = map_coordinates(previous, was - 0.5, order=3, mode="nearest")
    within = (was > 4).all(axis=0) & (was[0] < view.height - 4) & (was[1] < view.width - 4)
    near = (geometry.depth > 0) & (geometry.depth < 7) & within
    assert near.sum() > 500
    assert np.abs(warped - painted(now, i, j))[near].max() <= tolerance("cubic interpolation")


def test_hills_move_with_the_eye_above_them(shoot, tolerance):
    """The eye rises and sinks with the road: depth places a pixel in the world, the frame before sees it elsewhere."""
    road = {"length": 100.0, "profile": "hills", "amplitude": 1.5, "wavelength": 30.0}
    sequence = load("road-drive").with_changes(
        size=(96, 54), scene={"road": road}, camera={"yaw": 5.0}, motion={"kind": "drive", "speed": 60.0}
    )
    geometry = describe_geometry(shoot(sequence, 3))
    j, i = np.mgrid[:54, :96] + 0.5
    focal = 27 / np.tan(np.radians(sequence.camera.fov) / 2)
    depth = geometry.depth.astype(np.float64)
    hit = depth > 0
    basis = sequence.camera.basis()
    position = np.stack([(i - 48) / focal * depth, (j - 27) / focal * depth, depth], axis=-1) @ basis
    moved = np.array([0.0, 1.0, 1.5 * (np.sin(2 * np.pi * 3 / 30) - np.sin(2 * np.pi * 2 / 30))])
    was = (position + moved) @ basis.T
    motion = np.stack([i - 48 - focal * was[..., 0] / was[..., 2], j - 27 - focal * was[..., 1] / was[..., 2]], axis=-1)
    in_front = hit & (was[..., 2] > 1)
    assert in_front.sum() > 500
    assert np.abs(geometry.motion - motion)[in_front].max() <= tolerance("motion from float32 depth")
    assert np.abs(moved[2]) > 0.1


@pytest.mark.parametrize("name", VIEWS)
def test_depth_is_along_the_camera_axis(shoot, maps, tolerance, name):
    sequence, frame = VIEWS[name]
    geometry = describe_geometry(shoot(sequence, frame))
    oracle = Oracle(sequence, maps, frame)
    hit, position, *_ = oracle.surface(*oracle.centres())
    camera = sequence.view(frame).camera
    yaw, pitch = np.radians(camera.yaw), np.radians(camera.pitch)
    exact = position @ [np.sin(yaw) * np.cos(pitch), np.cos(yaw) * np.cos(pitch), np.sin(pitch)]
    assert np.array_equal(geometry.depth > 0, hit)
    assert np.abs(geometry.depth / exact - 1)[hit].max() <= tolerance("depth")
    assert not geometry.depth[~hit].any()


def test_coverage_is_the_area(shoot, maps, tolerance):
    sequence = SHIFT.with_changes(size=(48, 27), camera={"yaw": 20.0, "pitch": -12.0})
    geometry = describe_geometry(shoot(sequence, 1))
    oracle, n = Oracle(sequence, maps, 1), 48
    j, i = (np.mgrid[: 27 * n, : 48 * n] + 0.5) / n
    view = sequence.view(1)
    hit = oracle.surface(view.origin[0] + i, view.origin[1] + j)[0]
    area = hit.reshape(27, n, 48, n).mean(axis=(1, 3))
    edge = (area > 0) & (area < 1)
    assert edge.sum() > 30
    error = geometry.coverage - area
    assert np.abs(error).max() <= tolerance("coverage")
    assert np.sqrt(np.mean(error[edge] ** 2)) <= tolerance("coverage on the whole")
    assert (geometry.coverage[area == 1] == 1).all()
    assert (geometry.coverage[area == 0] == 0).all()
