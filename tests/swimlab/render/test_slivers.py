"""Wires: triangles thinner than a pixel, drawn or not."""

from dataclasses import replace

import numpy as np
import pytest
from oracle import Oracle
from pydantic import ValidationError

from metrics.kernels.launch import Strip
from sequences import load
from swimlab.render.geometry import describe_geometry
from swimlab.render.techniques.pixel_aniso import PixelAnisoSettings
from swimlab.render.triangles import screen_projection, visibility

WIRED = load("road-sliver").with_changes(size=(128, 72))
BARE = WIRED.with_changes(scene=WIRED.scene.model_dump() | {"wires": None})


def seen(shot):
    return visibility(shot.launcher, shot.triangles, shot.grid(), Strip(0, shot.view.height)).numpy()


def test_every_pixel_of_the_road_stays_covered(shoot):
    with_wires, without = (describe_geometry(shoot(each)).coverage for each in (WIRED, BARE))
    assert (without == 1).any()
    assert (with_wires[without == 1] == 1).all()


def test_wires_are_seen_where_they_are(shoot, maps, tolerance):
    """A ray meets a wire where it passes the plane of the wires within half a width of a wire's middle."""
    wires = {"count": 3, "width": 0.4, "height": 0.25}
    sequence = WIRED.with_changes(scene=WIRED.scene.model_dump() | {"wires": wires})
    shot = shoot(sequence, 1)
    # The oracle's road is the plane of the wires if the eye is lower by their height.
    camera = sequence.camera.model_dump() | {"height": sequence.camera.height - 0.25}
    oracle = Oracle(sequence.with_changes(camera=camera), maps, 1)
    hit, _, uv, _, _ = oracle.surface(*oracle.centres())
    x = (uv[..., 0] - 0.5) * 8.0
    middles = np.array([-8 / 3, 0.0, 8 / 3])
    expected = hit & (np.abs(x[..., None] - middles).min(axis=-1) < 0.2)
    index = seen(shot)
    found = (index >= 0) & shot.mesh.loose[index]
    assert expected.sum() > 200
    assert np.mean(found == expected) >= tolerance("equal pixels")


def altitudes(shot):
    """Least altitude (px) of each triangle of the wires that lies before the eye: twice its area over a side."""
    projection = screen_projection(shot.view.camera, shot.sequence.size[1], shot.sequence.size[0])
    corners = (shot.mesh.positions @ projection.T)[shot.mesh.triangles[shot.mesh.loose]]
    corners = corners[(corners[..., 2] > 0.01).all(axis=1)]
    a, b, c = np.moveaxis(corners[..., :2] / corners[..., 2:], 1, 0)
    sides = [np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))]
    half = sum(sides) / 2
    heron = np.sqrt(np.maximum(half * (half - sides[0]) * (half - sides[1]) * (half - sides[2]), 0))
    return 2 * heron / np.max(sides, axis=0)


@pytest.mark.parametrize("thinnest", [0.3, 0.5, 2.0])
def test_slivers_under_the_thinnest_are_left_out_and_counted(shoot, thinnest):
    wide = {"count": 4, "width": 0.1, "height": 0.1}
    sequence = WIRED.with_changes(scene=WIRED.scene.model_dump() | {"wires": wide})
    shot = replace(shoot(sequence), thinnest=thinnest)
    thin = altitudes(shot) < thinnest
    assert 0 < thin.sum() < thin.size
    assert shot.triangles.slivers == thin.sum()
    assert shoot(sequence).triangles.slivers == 0
    # The road has no hole, thin as its own triangles are at the horizon.
    bare = shoot(sequence.with_changes(scene=BARE.scene.model_dump()))
    assert ((seen(shot) >= 0) >= (seen(bare) >= 0)).all()
    assert (seen(shot) != seen(shoot(sequence))).any()


def test_a_pixel_of_a_smaller_frame_is_the_measure(shoot):
    halved = WIRED.with_changes(motion={"kind": "scale", "from": 0.5, "to": 0.5})
    shot = replace(shoot(halved), thinnest=0.5)
    assert shot.triangles.slivers == replace(shoot(WIRED), thinnest=1.0).triangles.slivers > 0


def test_without_slivers_the_road_alone_is_drawn(shoot, render):
    bare, wired = (render(shoot(each), "pixel-aniso").rgba for each in (BARE, WIRED))
    assert (wired != bare).any()
    assert np.array_equal(render(shoot(WIRED), "pixel-aniso", thinnest=64.0).rgba, bare)


def test_the_reference_draws_all(shoot, render):
    bare, wired = (render(shoot(each), "reference").rgba for each in (BARE, WIRED))
    brighter = wired[..., :3].sum(axis=-1) > 1.05 * bare[..., :3].sum(axis=-1)
    # Wires are under a pixel wide from here on, yet lighten what they cross.
    assert brighter[:45].any(axis=1).sum() > 10


@pytest.mark.parametrize("size", [64, 256])
def test_wires_have_targets_of_their_own(shoot, render, pack_maps, tolerance, size):
    """On uniform maps road and wires are lit the same, and no chart's border shows in texture-space lighting."""
    matte = np.broadcast_to([0.3, 0.5, 0.7, 0.0, 0.0, 1.0, 0.0, 0.0], (64, 64, 8)).astype(np.float32)
    shot = shoot(WIRED, 0, pack_maps(matte))
    rgba = render(shot, "tsl", size=size).rgba
    covered = rgba[..., 3] == 1
    assert shot.mesh.loose[seen(shot)][covered].any()
    sun = WIRED.scene.sun
    exact = np.array([0.3, 0.5, 0.7]) * np.sin(np.radians(sun.elevation)) * sun.diffuse
    assert rgba[covered][:, :3] == pytest.approx(
        np.broadcast_to(exact, (covered.sum(), 3)), rel=tolerance("constant light")
    )


@pytest.mark.parametrize("thinnest", [-1.0, 65.0, "1"])
def test_the_thinnest_is_checked(thinnest):
    with pytest.raises(ValidationError, match="thinnest"):
        PixelAnisoSettings.model_validate({"thinnest": thinnest}, strict=True)
