"""Vertex lighting."""

from math import log2

import numpy as np
import pytest
from oracle import Oracle, trilinear
from pydantic import ValidationError

from metrics.kernels.launch import Strip
from sequences import load
from swimlab.render.mesh import scene_mesh
from swimlab.render.techniques.vertex import VertexSettings, Vertices, vertices_of
from swimlab.render.triangles import on_screen, screen_projection, set_up, visibility

ROAD = {"length": 40.0, "segment": 8.0}
NEAR = load("road-shift").with_changes(
    size=(96, 54), scene={"road": ROAD}, camera={"height": 2.0, "pitch": -14.0, "distance": 3.3, "yaw": 3.0}
)


def cut(sequence, quads):
    """The mesh of a sequence's road in so many quads a segment."""
    road = sequence.scene.road.model_dump() | {"tessellation": quads}
    scene = sequence.with_changes(scene=sequence.scene.model_dump() | {"road": road}).scene
    return scene_mesh(scene, sequence.camera)


def colours(shot, quads, lod):
    """Radiance at the vertices."""
    found, shade = vertices_of(shot, quads).to_shade(shot, lod)
    shot.launcher.start(shade)
    return found.numpy()


@pytest.mark.parametrize("quads", [(16, 16), (4, 32)])
def test_a_vertex_has_the_colour_of_its_place(shoot, maps, tolerance, quads):
    """Inputs from the maps' chain at log2 of the longer edge, in texels; shaded in double precision."""
    shot, mesh = shoot(NEAR), cut(NEAR, quads)
    lod = log2(64 / min(quads))
    found = colours(shot, quads, lod)
    oracle = Oracle(NEAR, maps, 0)
    texels = trilinear(oracle.chain(), mesh.uv, np.full(len(mesh.uv), lod))
    exact = oracle.shade(texels, mesh.positions)
    assert np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2)) <= tolerance("agreement with the oracle")


@pytest.mark.parametrize("which", [0.2, 0.5, 0.8])
def test_a_pixel_upon_a_vertex_has_its_colour(shoot, render, tolerance, which):
    """The picture is slid until a pixel's centre lies on the vertex."""
    quads = (16, 16)
    mesh = cut(NEAR, quads)
    x, y, depth = NEAR.camera.basis() @ mesh.positions.T
    focal = NEAR.camera.focal(54)
    place = np.stack([48 + focal * x / depth, 27 + focal * y / depth], axis=1)
    inner = (depth > 0) & (place > 2).all(axis=1) & (place < (94, 52)).all(axis=1) & (np.abs(mesh.uv[:, 0] - 0.5) < 0.5)
    vertex = np.flatnonzero(inner)[int(which * inner.sum())]
    column, row = np.floor(place[vertex]).astype(int)
    velocity = (column + 0.5 - place[vertex, 0], row + 0.5 - place[vertex, 1])
    slid = NEAR.with_changes(motion={"kind": "shift", "velocity": velocity})
    picture = render(shoot(slid, 1), "vertex", quads=quads).rgba
    shot = shoot(NEAR)
    colour = colours(shot, quads, log2(64 / 16))[vertex]
    assert picture[row, column] == pytest.approx([*colour, 1.0], rel=tolerance("linear light"))


def test_it_becomes_pixel_shading_as_vertices_grow_dense(shoot, render, pack_maps, tolerance):
    """On uniform maps: the error of linear interpolation falls with the square of the spacing."""
    glossy = np.broadcast_to([0.2, 0.3, 0.4, 0.0, 0.0, 1.0, 0.1, 12.0], (16, 16, 8)).astype(np.float32)
    shot = shoot(NEAR, 0, pack_maps(glossy))
    exact = render(shot, "pixel-bilinear").rgba
    covered = exact[..., 3] == 1
    errors = []
    for quads in (8, 16, 32, 64):
        rgba = render(shot, "vertex", quads=(quads, quads)).rgba
        assert np.array_equal(rgba[..., 3], exact[..., 3])
        errors.append(np.sqrt(np.mean((rgba - exact)[covered] ** 2) / np.mean(exact[covered] ** 2)))
    assert errors[-1] <= tolerance("interpolated light")
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert ratios == pytest.approx(4.0, rel=tolerance("second order"))


def test_its_look_does_not_change_with_the_size_of_the_frame(shoot, render):
    """The deck: vertices are the lowest frequency of evaluation, "not the case for low resolution"."""
    full = load("road-scale").with_changes(size=(160, 90), frames=4)
    drift = {}
    for name in ("vertex", "pixel-aniso"):
        first, last = (render(shoot(full, frame), name).rgba for frame in (0, 3))
        means = [image[image[..., 3] == 1][:, :3].mean() for image in (first, last)]
        drift[name] = abs(means[1] / means[0] - 1)
    assert drift["vertex"] < drift["pixel-aniso"] / 2


def test_every_vertex_is_counted_once(shoot, render):
    assert render(shoot(NEAR), "vertex", quads=(3, 5)).shaded == len(cut(NEAR, (3, 5)).positions)


@pytest.mark.parametrize("quads", [(0, 16), (16, 257), (16,), (1.5, 2)])
def test_quads_are_checked(quads):
    with pytest.raises(ValidationError, match="quads"):
        VertexSettings(quads=quads)


@pytest.mark.parametrize("name", ["road-shift", "road-hills", "road-posts"])
@pytest.mark.parametrize("cut_into", [(1, 1), (16, 16)])
def test_triangles_that_no_sample_sees_need_not_be_set_up(launcher, shoot, name, cut_into):
    """The picture by them and without them sees the same place of the surface everywhere."""
    shot = shoot(load(name).with_changes(size=(64, 36)), 1)
    mesh, grid, whole = cut(shot.sequence, cut_into), shot.grid(), Strip(0, 36)
    projection = screen_projection(shot.view.camera, 36, 64)
    vertices = Vertices.of(launcher, mesh, projection)
    few = np.flatnonzero(vertices.sampled(launcher, grid))
    assert len(few) < len(mesh.triangles)
    both = on_screen(launcher, mesh, projection), set_up(launcher, mesh.positions @ projection.T, mesh, few)
    seen, found = (visibility(launcher, each, grid, whole).numpy() for each in both)
    assert np.array_equal(seen >= 0, found >= 0)
    hit = seen >= 0
    assert np.array_equal(seen[hit], few[found[hit]])
    assert not np.isin(few, np.flatnonzero(~mesh.facing)).any()


def test_a_still_eye_keeps_its_mesh_and_another_does_not(shoot):
    still, driven = (shoot(load(name).with_changes(size=(64, 36)), 0) for name in ("road-shift", "road-drive"))
    assert still.at(3).triangles is still.triangles
    assert vertices_of(still.at(3), (4, 4)) is vertices_of(still, (4, 4))
    assert vertices_of(still, (4, 8)) is not vertices_of(still, (4, 4))
    assert vertices_of(driven.at(3), (4, 4)) is not vertices_of(driven, (4, 4))
    assert still.at(3).view.origin != still.view.origin
    assert driven.at(3).mesh is not driven.mesh
    assert np.array_equal(driven.at(3).mesh.positions, shoot(driven.sequence, 3).mesh.positions)
