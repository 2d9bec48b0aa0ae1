"""Texture-space lighting."""

import numpy as np
import pytest
import warp as wp
from oracle import Oracle
from pydantic import ValidationError

from sequences import load
from swimlab.render.atlas import Tiles
from swimlab.render.charts import charts_of
from swimlab.render.kernels.packet import PLACES
from swimlab.render.kernels.texture_space import NEVER, Atlas, marking, pages_of
from swimlab.render.kernels.tile_table import TILE_LEVEL
from swimlab.render.layout import Layout, equal_widths
from swimlab.render.techniques import tsl

SHORT = load("road-shift").with_changes(
    size=(96, 54),
    scene={"road": {"width": 8.0, "segment": 8.0, "length": 21.3}},
    camera={"height": 2.0, "pitch": -14.0, "distance": 3.3},
)


def matte(albedo):
    """Maps [h, w, 8] of an albedo [h, w, 3] with flat normals and no highlight."""
    rest = np.broadcast_to([0.0, 0.0, 1.0, 0.0, 0.0], (*albedo.shape[:2], 5))
    return np.concatenate([albedo, rest], axis=2).astype(np.float32)


LEAN_TSL = [
    {"size": 16},
    {"size": 16, "inputs": "vmf"},
    {"size": 64},
    {"size": 256},
    {"size": 256, "texels": "visible"},
    {"size": 256, "texels": "needed"},
    {"size": 256, "sizes": "fitted"},
    {"size": 256, "sizes": "fitted", "texels": "needed", "coarser": 1, "inputs": "vmf"},
]


@pytest.mark.parametrize("given", LEAN_TSL)
@pytest.mark.parametrize("view", ["ahead", "sideways", "behind"])
def test_a_uniform_road_is_uniform_to_its_last_pixel(shoot, render, pack_maps, tolerance, given, view):
    """The first and last segments are cut: without the division by alpha their ends would fade to black."""
    turned = {"ahead": {}, "sideways": {"yaw": 70.0}, "behind": {"yaw": 180.0, "pitch": -10.0}}[view]
    sequence = SHORT.with_changes(camera=SHORT.camera.model_dump() | turned)
    colour = np.array([0.3, 0.5, 0.7])
    shot = shoot(sequence, 0, pack_maps(matte(np.broadcast_to(colour, (64, 64, 3)))))
    rgba = render(shot, "tsl", **given).rgba
    hit = Oracle(sequence, np.zeros((1, 1, 8)), 0).surface(*Oracle(sequence, None, 0).centres())[0]
    assert np.array_equal(rgba[..., 3] == 1, hit)
    assert hit.any(axis=1).sum() > 10
    sun = sequence.scene.sun
    exact = colour * np.sin(np.radians(sun.elevation)) * sun.diffuse
    assert rgba[hit][:, :3] == pytest.approx(np.broadcast_to(exact, (hit.sum(), 3)), rel=tolerance("constant light"))


@pytest.mark.parametrize("given", LEAN_TSL)
@pytest.mark.parametrize("name", ["road-sliver", "road-hills"])
def test_narrow_charts_leave_no_fringe(shoot, render, pack_maps, tolerance, given, name):
    """Wires are charts of a texel and less, hills lose the triangles that face away: no pixel is left dark or bright.

    All there is to light is a constant highlight-free white under a sun from straight above a flat normal.
    """
    sequence = load(name).with_changes(size=(96, 54))
    scene = sequence.scene.model_dump() | {"sun": {"elevation": 90.0, "diffuse": 1.0}}
    flat = sequence.with_changes(scene=scene)
    shot = shoot(flat, 3, pack_maps(matte(np.ones((64, 64, 3)))))
    rgba, exact = (render(shot, each, **(given if each == "tsl" else {})).rgba for each in ("tsl", "pixel-point"))
    assert np.array_equal(rgba[..., 3], exact[..., 3])
    assert exact[..., :3].max() > 0.9
    # Hills shade with their slope: between texels of a coarse target it changes.
    limit = tolerance("constant light" if name == "road-sliver" else "light on a coarse target of hills")
    assert np.abs(rgba - exact).max() <= limit


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


def test_only_segments_in_sight_are_lit(shoot, render, maps):
    sequence = SHORT.with_changes(camera={"pitch": -30.0, "yaw": 20.0, "distance": 100.0})
    oracle = Oracle(sequence, maps, 0)
    hit, _, uv, _, _ = oracle.surface(*oracle.centres())
    in_sight = np.unique(np.floor(uv[..., 1][hit])).tolist()
    assert tsl.planned_alone(shoot(sequence), tsl.TslSettings(size=16))[0].segments.tolist() == in_sight
    assert len(in_sight) < 4
    whole = 16 * 16 * len(in_sight)
    assert 0.5 * whole < render(shoot(sequence), "tsl", size=16).shaded <= whole


@pytest.mark.parametrize("most", [20, 1000])
@pytest.mark.parametrize("texels", ["all", "visible"])
def test_charts_that_come_and_go_keep_their_targets(shoot, render, monkeypatch, texels, most):
    """Far charts are narrower than a pixel. Those out of sight are not lit, and change nothing."""
    monkeypatch.setattr(tsl, "MOST_TILES", 4 * most)
    sequence, settings = load("road-shift").with_changes(size=(96, 54)), tsl.TslSettings(size=64, texels=texels)
    renderer, idle = tsl.TECHNIQUE.begin(), []
    plan = tsl.Plan(shoot(sequence).launcher, settings, most)
    for frame in range(8):
        shot = shoot(sequence, frame)
        plan.tiles(shot)
        targets, in_sight = plan.screen.segments.tolist(), tsl.planned_alone(shot, settings)[0].segments.tolist()
        assert set(in_sight) <= set(targets)
        assert len(targets) <= max(most, len(in_sight))
        idle.append(len(targets) - len(in_sight))
        kept, plain = renderer(shot, settings), tsl.render(shot, settings)
        assert kept.rgba.tobytes() == plain.rgba.tobytes()
        assert kept.shaded == plain.shaded
    assert max(idle) > 0


@pytest.mark.parametrize("name", ["road-shift", "road-drive", "road-posts", "road-sliver"])
@pytest.mark.parametrize("coarser", [-1, 0, 2])
def test_targets_fit_what_is_read_of_them(shoot, name, coarser):
    """Each is the smallest in which no footprint is magnified, down to 16 texels, and by some levels smaller."""
    settings, whole = tsl.TslSettings(size=4096, sizes="fitted", coarser=coarser), tsl.TslSettings(size=4096)
    sequence = load(name).with_changes(size=(96, 54))
    plan = tsl.Plan(shoot(sequence).launcher, settings)
    for frame in (0, 1, 5):
        shot = shoot(sequence, frame)
        tiles, (screen, exact) = plan.tiles(shot), tsl.planned_alone(shot, whole)
        finest = dict(zip(screen.segments.tolist(), exact.finest.host.tolist(), strict=True))
        for segment, width in zip(tiles.segments.tolist(), tiles.layout.widths.tolist(), strict=True):
            level = min(max(finest.get(segment, NEVER) + coarser, 0), 16)
            assert width == max(16, 4096 >> level)
        assert np.array_equal(tiles.layout.shapes, tiles.shapes.host)
        charts = charts_of(shot)
        extent = (charts.high - charts.low)[np.searchsorted(charts.segments, tiles.segments)]
        for each in (
            tiles,
            Tiles(shot.launcher, Layout(tiles.segments, equal_widths(len(tiles.segments), 4096))),
            tiles,
        ):
            narrow = np.any(extent * each.layout.widths[:, None] < 1, axis=1)
            assert np.array_equal(charts.drawn(each).widened, narrow)
    assert charts.are_wide == (name in {"road-shift", "road-drive"})


def test_road_out_of_sight_costs_nothing(shoot):
    """However many charts lie ahead, those that no pixel's centre sees have no target."""
    tables = []
    for length in (300.0, 30000.0):
        sequence = SHORT.with_changes(scene={"road": {"length": length}}, camera={"pitch": -30.0})
        shot = shoot(sequence)
        _, tiles = tsl.planned_alone(shot, tsl.TslSettings(size=256))
        assert len(np.unique(shot.mesh.segments)) > length / 8
        tables.append(tiles.table.host.shape)
    assert tables[0] == tables[1]
    assert tables[0][1] < 10 * 65


def test_all_tiles_of_the_largest_target_are_told_apart(launcher):
    """Down to its last rows and columns, of which both forms note the same tiles."""
    size, tiles, px, count = 8192, 256, 1 / 8192, 40
    rng = np.random.default_rng(3)
    # Long footprints at level 0, whose first probe lies at the border between the last tiles.
    across, down = px * rng.uniform([20, -60], [60, -20], (count, 2)).T
    places = np.zeros((count, 6, PLACES // 6))
    places[:, 0, 0] = 255 / 256 + across * 15 / 32
    places[:, 1, 0] = 1 - px * rng.uniform(0, 32, count) + down * 15 / 32
    places[:, 2, 0], places[:, 3, 0] = across, down
    places[:, 4, 0], places[:, 5, 0] = 0.5 * px, 0.5 * px
    atlas = Atlas()
    atlas.shapes, atlas.table = launcher.array([[size, 14, TILE_LEVEL, 1]], wp.vec4i), launcher.zeros(1, wp.int32)

    def noted(kernel, place):
        need = launcher.filled(1 + tiles**2, wp.int32, NEVER)
        launcher.launch(kernel, 1, [atlas, launcher.array(place.ravel(), wp.float64), need])
        return np.flatnonzero(need.numpy() != NEVER).tolist()

    native, plain = (marks_of(form) for form in (marking(16).native, marking(16).plain))
    found = [noted(native, place) for place in places]
    assert found == [noted(plain, place) for place in places]
    assert max(map(len, found)) >= 4


def marks_of(mark):
    """The kernel that marks what one footprint reads of a target."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(atlas: Atlas, places: wp.array(dtype=wp.float64), need: wp.array(dtype=wp.int32)):
        mark(pages_of(atlas, 0), places, 1, need)

    return kernel


@pytest.mark.parametrize("size", [16, 32, 256, 1024])
@pytest.mark.parametrize("anisotropy", [1, 16])
def test_visible_tiles_give_the_decks_image(shoot, render, size, anisotropy):
    """To the bit: what is not shaded is not read."""
    shot = shoot(SHORT.with_changes(camera={"pitch": -12.0, "yaw": 50.0, "distance": 3.3}))
    everything = render(shot, "tsl", size=size, anisotropy=anisotropy)
    visible = render(shot, "tsl", size=size, anisotropy=anisotropy, texels="visible")
    assert np.array_equal(visible.rgba, everything.rgba)
    assert visible.shaded <= everything.shaded
    if size >= 256:
        assert visible.shaded < 0.8 * everything.shaded


@pytest.mark.parametrize("inputs", ["box", "toksvig", "vmf", "clean", "lean"])
def test_fewer_texels_cost_little_error(shoot, render, tolerance, inputs):
    """Texels at the level that footprints need: many fewer, and an error near that of all with the same inputs."""
    shot = shoot(SHORT.with_changes(scene={}), samples=256)
    reference = render(shot, "reference").rgba
    covered = reference[..., 3] == 1
    full = render(shot, "tsl", size=256)
    needed = render(shot, "tsl", size=256, inputs=inputs, texels="needed")
    fitted = render(shot, "tsl", size=256, inputs=inputs, sizes="fitted")
    errors = [np.sqrt(np.mean((picture.rgba - reference)[covered] ** 2)) for picture in (full, needed, fitted)]
    assert needed.shaded < full.shaded / 4
    assert fitted.shaded < full.shaded / 2
    assert errors[1] < tolerance("error of needed texels") * errors[0]
    assert errors[2] < tolerance("error of needed texels") * errors[0]


def test_what_is_shaded_is_counted(shoot, render):
    """A whole segment of a flat road has all of its target's texels; the cut ones have their share."""
    sequence = SHORT.with_changes(
        scene={"road": {"segment": 8.0, "length": 24.0}}, camera={"pitch": -14.0, "distance": 0.0}
    )
    assert render(shoot(sequence), "tsl", size=64).shaded == 3 * 64 * 64
    shorter = sequence.with_changes(scene={"road": {"segment": 8.0, "length": 20.0}})
    assert render(shoot(shorter), "tsl", size=64).shaded == 2.5 * 64 * 64


def test_a_view_without_road_is_empty(shoot, render):
    sequence = SHORT.with_changes(camera={"pitch": 60.0})
    assert not render(shoot(sequence), "tsl", size=16).rgba.any()


def test_finer_targets_come_nearer_to_the_truth(shoot, render):
    shot = shoot(SHORT, samples=64)
    reference = render(shot, "reference").rgba
    covered = reference[..., 3] == 1
    errors = [
        np.sqrt(np.mean((render(shot, "tsl", size=size).rgba - reference)[covered] ** 2)) for size in (16, 64, 256)
    ]
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
        ({"inputs": "mean"}, "'box', 'toksvig', 'vmf', 'clean' or 'lean'"),
        ({"texels": "few"}, "'all', 'visible' or 'needed'"),
        ({"sizes": "auto"}, "'fixed' or 'fitted'"),
        ({"coarser": 9}, "less than or equal to 4"),
        ({"reuse": 0}, "greater than or equal to 1"),
        ({"reuse": 65}, "less than or equal to 64"),
        ({"tolerance": -0.1}, "greater than or equal to 0"),
    ],
)
def test_settings_are_checked(given, message):
    with pytest.raises(ValidationError, match=message):
        tsl.TslSettings(**given)
