"""Hills that hide one another, against rays cast at the sine itself in double precision."""

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, map_coordinates

from metrics.kernels.launch import Strip
from sequences import load
from swimlab.render.atlas import Tiles
from swimlab.render.charts import Charts
from swimlab.render.geometry import describe_geometry
from swimlab.render.kernels.structs import Grid
from swimlab.render.layout import Layout
from swimlab.render.triangles import Triangles, visibility

STEP = 0.1
"""Metres between the places of a ray that are looked at before its root is refined: 1/200 of a wave."""
# Cut so finely that its chords are off the sine by 2e-5 m.
ROAD = {"length": 100.0, "profile": "hills", "amplitude": 1.2, "wavelength": 20.0, "tessellation": (1, 256)}
CAMERA = {"distance": 3.3, "height": 1.3, "pitch": -5.0, "yaw": 4.0, "lateral": 0.4}
HILLS = load("road-hills").with_changes(size=(96, 54), scene={"road": ROAD}, camera=CAMERA)


def cast(sequence, frame, x, y, *, hidden=False):
    """Depth (m, NaN for none) and place in the world [..., 2] where rays through (x, y) first come down on the road.

    hidden: where they come down last instead, as if nothing were in between.
    """
    view, road = sequence.view(frame), sequence.scene.road
    camera, (width, height) = view.camera, sequence.size
    focal = camera.focal(height)
    ray = np.stack([(x - width / 2) / focal, (y - height / 2) / focal, np.ones_like(x)], axis=-1) @ camera.basis()
    eye = camera.eye(road)
    ahead = np.arange(0.0, road.length + STEP / 2, STEP)
    depth, place = np.full(x.shape, np.nan), np.full((*x.shape, 2), np.nan)

    def above(way, along):
        return eye[2] + way[:, 2] * along - road.height_at(eye[1] + way[:, 1] * along)

    for row in np.ndindex(x.shape[:-1]):
        way = ray[row]
        along = ahead / way[:, 1:2]
        clear = eye[2] + way[:, 2:] * along - road.height_at(eye[1] + ahead)
        over = np.abs(eye[0] + way[:, :1] * along) <= road.width / 2
        lands = (clear[:, :-1] > 0) & (clear[:, 1:] <= 0) & (over[:, 1:] | over[:, :-1])
        index = lands.shape[1] - 1 - lands[:, ::-1].argmax(axis=1) if hidden else lands.argmax(axis=1)
        column = np.arange(len(way))
        low, high = along[column, index], along[column, index + 1]
        for _ in range(50):
            middle = (low + high) / 2
            low, high = np.where(above(way, middle) > 0, middle, low), np.where(above(way, middle) > 0, high, middle)
        found = lands.any(axis=1) & (np.abs(eye[0] + way[:, 0] * low) <= road.width / 2)
        depth[row] = np.where(found, low, np.nan)
        place[row] = np.where(found[:, None], eye[:2] + way[:, :2] * low[:, None], np.nan)
    return depth, place


def centres(sequence, n=1):
    """Image-plane places of the centres of n x n cells a pixel, [H n, W n]."""
    width, height = sequence.size
    y, x = (np.mgrid[: height * n, : width * n] + 0.5) / n
    return x, y


def test_the_nearer_of_two_hills_hides_the_further(shoot, tolerance):
    geometry = describe_geometry(shoot(HILLS, 2))
    x, y = centres(HILLS)
    depth, _ = cast(HILLS, 2, x, y)
    last, _ = cast(HILLS, 2, x, y, hidden=True)
    hit = np.isfinite(depth)
    hiding = hit & (last > depth + 10)
    assert hiding.sum() > 50
    assert np.mean((geometry.depth > 0) == hit) >= tolerance("equal pixels")
    both = hit & (geometry.depth > 0)
    wrong = np.abs(geometry.depth / np.where(both, depth, 1.0) - 1) > tolerance("depth of chords")
    assert wrong[both].mean() <= 1 - tolerance("equal pixels")
    assert wrong[both & hiding].mean() < 0.05


def test_coverage_is_that_of_rays(shoot, tolerance):
    small = HILLS.with_changes(size=(32, 18))
    geometry = describe_geometry(shoot(small, 2))
    depth, _ = cast(small, 2, *centres(small, 8))
    area = np.isfinite(depth).reshape(18, 8, 32, 8).mean(axis=(1, 3))
    assert ((area > 0) & (area < 1)).sum() > 20
    error = np.abs(geometry.coverage - area)
    assert error.max() <= tolerance("coverage")
    assert np.sqrt(np.mean(error**2)) <= tolerance("coverage on the whole")


def test_warping_along_the_motion_over_hills_leaves_interpolation_error_only(shoot, tolerance):
    # Down into a valley: no crest is near.
    sequence, frame = HILLS.with_changes(size=(128, 72), camera=CAMERA | {"distance": 9.0}), 4
    geometry = describe_geometry(shoot(sequence, frame))
    x, y = centres(sequence)

    def painted(frame):
        place = cast(sequence, frame, x, y)[1]
        return np.cos(2 * np.pi * place[..., 0] / 8.0 + 0.3) * np.sin(2 * np.pi * place[..., 1] / 8.0)

    before, now = painted(frame - 1), painted(frame)
    was = np.stack([y - geometry.motion[..., 1], x - geometry.motion[..., 0]])
    warped = map_coordinates(np.nan_to_num(before), was - 0.5, order=3, mode="nearest")
    # A spline feels the road's edges some pixels away.
    inner = binary_erosion(np.isfinite(before), iterations=6)
    seen = map_coordinates(inner.astype(float), was - 0.5, order=0) > 0.5
    near = (geometry.depth > 0) & (geometry.depth < 7) & seen
    assert near.sum() > 500
    assert np.abs(warped - now)[near].max() <= tolerance("cubic interpolation")


def test_back_faces_are_drawn_neither_on_the_screen_nor_into_targets(shoot):
    """Whether the eye lies above a chord of the road says whether that chord's quad is drawn; a target has the rest."""
    cut, size = 16, 64
    road = ROAD | {"tessellation": (1, cut)}
    sequence = HILLS.with_changes(scene={"road": road})
    shot = shoot(sequence, 0)
    scene, eye = sequence.scene.road, sequence.camera.eye(sequence.scene.road)
    charts = Charts.of(shot.launcher, shot.mesh)
    drawn_charts = charts.drawn(Tiles(shot.launcher, Layout(np.arange(2, 12), np.full(10, size, np.int32))))
    away = 0
    for place, segment in enumerate(range(2, 12)):
        y = (segment + np.arange(cut + 1) / cut) * scene.segment
        z = scene.height_at(y)
        faces = eye[2] > z[:-1] + (z[1:] - z[:-1]) / (y[1:] - y[:-1]) * (eye[1] - y[:-1])
        first, stop = np.asarray(drawn_charts.ranges)[place].tolist()
        ready = drawn_charts.triangles
        triangles = Triangles(*(each[first:stop] for each in (ready.edges, ready.planes, ready.bounds)))
        grid = Grid()
        grid.pitch, grid.width, grid.height = (1 / size, 1 / size), size, size
        drawn = visibility(shot.launcher, triangles, grid, Strip(0, size)).numpy() >= 0
        assert np.array_equal(drawn, np.repeat(faces, size // cut)[:, None] & np.ones(size, bool))
        assert stop - first == 2 * np.sum(faces)
        away += 2 * np.sum(~faces)
    assert 0 < away <= shot.triangles.back_faces
    seen = visibility(shot.launcher, shot.triangles, shot.grid(), Strip(0, 54)).numpy()
    assert shot.mesh.facing[seen[seen >= 0]].all()
    assert shot.triangles.back_faces == np.sum(~shot.mesh.facing)


def test_a_flat_road_has_no_back_faces(shoot):
    assert shoot(load("road-shift")).triangles.back_faces == 0


@pytest.mark.parametrize("technique", ["pixel-bilinear", "tsl", "vertex"])
def test_a_wire_above_the_eye_is_not_seen(shoot, render, technique):
    """The eye sees its underside alone."""
    given = {"size": 64} if technique == "tsl" else {}
    bare = load("road-shift").with_changes(size=(48, 27))
    wired = bare.with_changes(scene={"wires": {"count": 3, "width": 0.5, "height": 1.4}})
    pictures = [render(shoot(each), technique, **given).rgba for each in (bare, wired)]
    assert shoot(wired).triangles.back_faces == np.sum(shoot(wired).mesh.loose)
    assert np.array_equal(*pictures)
