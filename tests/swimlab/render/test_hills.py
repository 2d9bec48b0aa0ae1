"""A road over hills: what hides what, and how it is lit."""

import numpy as np
import pytest
from oracle import unit

from sequences import load
from swimlab.render.geometry import describe_geometry
from swimlab.render.mesh import ROWS_PER_WAVE

ROAD = {"width": 8.0, "segment": 8.0, "length": 120.0, "profile": "hills", "amplitude": 1.2, "wavelength": 20.0}
HILLS = load("road-shift").with_changes(
    size=(96, 54), scene={"road": ROAD}, camera={"distance": 4.3, "height": 1.3, "pitch": -4.0}
)


@pytest.fixture(scope="module")
def seen():
    """Where the rays of the middle column first meet the polyline that the mesh is: [H] y ahead of the eye, depth."""
    road, camera = HILLS.scene.road, HILLS.camera
    height = HILLS.size[1]
    rows = int(np.ceil(road.segment / road.wavelength * ROWS_PER_WAVE))
    y = np.arange(int(camera.distance / road.segment) * rows, 100 * rows) * road.segment / rows
    y = np.concatenate([[camera.distance], y[(y > camera.distance) & (y < camera.distance + road.length)]])
    y = np.concatenate([y, [camera.distance + road.length]])
    ground = 1.2 * np.sin(2 * np.pi * y / 20.0)
    eye = 1.2 * np.sin(2 * np.pi * camera.distance / 20.0) + camera.height
    focal = height / 2 / np.tan(np.radians(camera.fov) / 2)
    up = (height / 2 - (np.arange(height) + 0.5)) / focal
    pitch = np.radians(camera.pitch)
    climb = (np.sin(pitch) + up * np.cos(pitch)) / (np.cos(pitch) - up * np.sin(pitch))
    above = eye + climb[:, None] * (y - camera.distance) - ground
    falls = (above[:, :-1] > 0) & (above[:, 1:] <= 0)
    first = falls.argmax(axis=1)
    row = np.arange(height)
    part = above[row, first] / (above[row, first] - above[row, first + 1])
    ahead = y[first] + part * (y[first + 1] - y[first]) - camera.distance
    ahead = np.where(falls.any(axis=1), ahead, np.nan)
    depth = ahead * np.cos(pitch) + climb * ahead * np.sin(pitch)
    return ahead, depth, y, part, first


def test_the_nearer_crest_hides_what_is_behind_it(shoot, seen, tolerance):
    ahead, depth, *_ = seen
    geometry = describe_geometry(shoot(HILLS))
    middle = HILLS.size[0] // 2
    found = geometry.depth[:, middle]
    expected = np.nan_to_num(depth)
    assert found == pytest.approx(expected, rel=tolerance("depth"), abs=0)
    hit = ahead[np.isfinite(ahead)]
    # Something is hidden: from one row to the next the view leaps over a whole valley.
    assert np.abs(np.diff(hit)).max() > 8
    assert geometry.coverage[:, middle].max() == 1


def test_hills_are_lit_by_their_slope(shoot, render, seen, pack_maps, tolerance):
    ahead, _, y, part, first = seen
    flat = np.broadcast_to([0.2, 0.3, 0.4, 0.0, 0.0, 1.0, 0.1, 12.0], (16, 16, 8)).astype(np.float32)
    rgba = render(shoot(HILLS, 0, pack_maps(flat)), "pixel-bilinear").rgba
    middle = HILLS.size[0] // 2
    road, camera, sun = HILLS.scene.road, HILLS.camera, HILLS.scene.sun
    hit = np.isfinite(ahead)
    slopes = 1.2 * 2 * np.pi / 20 * np.cos(2 * np.pi * y / 20.0)
    # Attributes are linear along a chord.
    slope = (slopes[first] + part * (slopes[first + 1] - slopes[first]))[hit]
    normal = unit(np.stack([np.zeros_like(slope), -slope, np.ones_like(slope)], axis=-1))
    heights = 1.2 * np.sin(2 * np.pi * y / 20.0)
    ground = (heights[first] + part * (heights[first + 1] - heights[first]))[hit]
    focal = HILLS.size[1] / 2 / np.tan(np.radians(camera.fov) / 2)
    eye = float(road.height_at(camera.distance)) + camera.height
    depth = seen[1][hit]
    position = np.stack([0.5 / focal * depth, ahead[hit], ground - eye], axis=-1)
    light, view = sun.direction, unit(-position)
    half = unit(light + view)
    specular = np.clip((normal * half).sum(axis=1), 0, 1) ** 12 * 12 * 0.1
    lambert = np.clip(normal @ light, 0, 1) * sun.diffuse
    exact = lambert[:, None] * [0.2, 0.3, 0.4] + specular[:, None]
    assert np.ptp(lambert) > 0.1
    found = rgba[hit, middle, :3]
    assert found == pytest.approx(
        exact, rel=tolerance("agreement with the oracle"), abs=tolerance("radiance in float32")
    )


def test_every_segment_of_a_hilly_road_is_pasted(shoot, render, tolerance, pack_maps):
    flat = np.broadcast_to([0.2, 0.3, 0.4, 0.0, 0.0, 1.0, 0.0, 0.0], (16, 16, 8)).astype(np.float32)
    shot = shoot(HILLS, 0, pack_maps(flat))
    lit, direct = (render(shot, name, **given).rgba for name, given in (("tsl", {"size": 256}), ("pixel-bilinear", {})))
    assert np.array_equal(lit[..., 3], direct[..., 3])
    covered = direct[..., 3] == 1
    # The light varies over a texel and a pixel: a few per cent at the crests, nothing like a missing segment.
    error = np.sqrt(np.mean((lit - direct)[covered] ** 2) / np.mean(direct[covered] ** 2))
    assert error < tolerance("light within a pixel")
