"""Texture-space lighting."""

import numpy as np
import pytest
from oracle import Oracle
from pydantic import ValidationError

from sequences import load
from swimlab.techniques import tsl

SHORT = load("road-shift").with_changes(
    size=(96, 54),
    scene={"road": {"width": 8.0, "segment": 8.0, "length": 21.3}},
    camera={"height": 2.0, "pitch": -14.0, "distance": 3.3},
)


def matte(albedo):
    """Maps [h, w, 8] of an albedo [h, w, 3] with flat normals and no highlight."""
    rest = np.broadcast_to([0.0, 0.0, 1.0, 0.0, 0.0], (*albedo.shape[:2], 5))
    return np.concatenate([albedo, rest], axis=2).astype(np.float32)


@pytest.mark.parametrize("size", [16, 64, 256])
@pytest.mark.parametrize("view", ["ahead", "sideways", "behind"])
def test_a_uniform_road_is_uniform_to_its_last_pixel(shoot, render, pack_maps, tolerance, size, view):
    """The first and last segments are cut: without the division by alpha their ends would fade to black."""
    turned = {"ahead": {}, "sideways": {"yaw": 70.0}, "behind": {"yaw": 180.0, "pitch": -10.0}}[view]
    sequence = SHORT.with_changes(camera=SHORT.camera.model_dump() | turned)
    colour = np.array([0.3, 0.5, 0.7])
    shot = shoot(sequence, 0, pack_maps(matte(np.broadcast_to(colour, (64, 64, 3)))))
    rgba = render(shot, "tsl", size=size).rgba
    hit = Oracle(sequence, np.zeros((1, 1, 8)), 0).surface(*Oracle(sequence, None, 0).centres())[0]
    assert np.array_equal(rgba[..., 3] == 1, hit)
    assert hit.any(axis=1).sum() > 10
    sun = sequence.scene.sun
    exact = colour * np.sin(np.radians(sun.elevation)) * sun.diffuse
    assert rgba[hit][:, :3] == pytest.approx(np.broadcast_to(exact, (hit.sum(), 3)), rel=tolerance("constant light"))


def test_linear_light_needs_no_order(shoot, render, pack_maps, maps, tolerance):
    """Diffuse and flat: shading is linear, so that filtering its inputs is filtering its result."""
    chain = pack_maps(matte(maps[..., :3]))
    sequence = SHORT.with_changes(camera=SHORT.camera.model_dump() | {"distance": 0.0})
    shot = shoot(sequence, 0, chain)
    lit, filtered = (render(shot, name, **given).rgba for name, given in (("tsl", {"size": 64}), ("pixel-aniso", {})))
    oracle = Oracle(sequence, maps, 0)
    hit, _, uv, dx, dy = oracle.surface(*oracle.centres())
    # Away from the borders of segments, where targets are clamped and maps repeat.
    reach = np.linalg.norm(dx, axis=-1) + np.linalg.norm(dy, axis=-1) + 1 / 16
    place = np.abs(uv - np.floor(uv) - 0.5).max(axis=-1)
    inner = hit & (place + reach < 0.5)
    assert inner.sum() > 500
    assert lit[inner] == pytest.approx(filtered[inner], rel=tolerance("linear light"))


def test_only_segments_in_sight_are_lit(shoot, render, maps, monkeypatch):
    lit = []
    in_texture = tsl.in_texture

    def counted(launcher, mesh, segment):
        lit.append(segment)
        return in_texture(launcher, mesh, segment)

    monkeypatch.setattr(tsl, "in_texture", counted)
    sequence = SHORT.with_changes(camera={"pitch": -30.0, "yaw": 20.0, "distance": 100.0})
    render(shoot(sequence), "tsl", size=16)
    oracle = Oracle(sequence, maps, 0)
    hit, _, uv, _, _ = oracle.surface(*oracle.centres())
    assert sorted(lit) == np.unique(np.floor(uv[..., 1][hit])).tolist()
    assert len(lit) < 4


def test_a_view_without_road_is_empty(shoot, render):
    sequence = SHORT.with_changes(camera={"pitch": 60.0})
    assert not render(shoot(sequence), "tsl", size=16).rgba.any()


def test_finer_targets_come_nearer_to_the_truth(shoot, render):
    shot = shoot(SHORT, samples=64)
    truth = render(shot, "reference").rgba
    covered = truth[..., 3] == 1
    errors = [np.sqrt(np.mean((render(shot, "tsl", size=size).rgba - truth)[covered] ** 2)) for size in (16, 64, 256)]
    assert errors[0] > errors[1] > errors[2]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"size": 100}, "power of two, as 64 or 128"),
        ({"size": 8}, "greater than or equal to 16"),
        ({"size": 16384}, "less than or equal to 8192"),
        ({"size": 64.5}, "integer"),
        ({"anisotropy": 0}, "greater than or equal to 1"),
        ({"anisotropy": 65}, "less than or equal to 64"),
        ({"sise": 64}, "Extra inputs"),
    ],
)
def test_settings_are_checked(given, message):
    with pytest.raises(ValidationError, match=message):
        tsl.TslSettings(**given)
