"""Temporal accumulation: the recursion in closed form, what it follows, and that its memory changes no bit."""

import numpy as np
import pytest

from sequences import load
from swimlab.render.catalogue import techniques
from swimlab.render.inputs import Maps
from swimlab.render.material import Material
from swimlab.render.plan import Plan
from swimlab.render.run import render_run
from swimlab.render.techniques import taa
from swimlab.runs.frames import frame_path, read_frame

SIZE = (48, 27)
STILL = load("road-shift").with_changes(size=SIZE, motion={"kind": "shift", "velocity": [0, 0]})
SHIFT = load("road-shift").with_changes(size=SIZE)
TURNED = {"pitch": -30.0, "yaw": 20.0}
PREROLL = 6


def rms(error):
    return np.sqrt(np.mean(np.square(error, dtype=np.float64)))


def sampled(shoot, render, offset, **given):
    """pixel-aniso with all samples moved by `offset` px."""
    moved = STILL.with_changes(motion={"kind": "shift", "velocity": [-offset[0], -offset[1]]}, **given)
    return render(shoot(moved, 1), "pixel-aniso").rgba.astype(np.float64)


def recursion(frames, blend):
    mean = frames[0]
    for frame in frames[1:]:
        mean = mean + blend * (frame - mean)
    return mean


@pytest.mark.parametrize("history", ["bicubic", "bilinear"])
def test_a_still_scene_has_the_exponential_average_of_its_samples(shoot, render, tolerance, history):
    given = {"clamp": "none", "history": history, "preroll": PREROLL, "period": 4, "blend": 0.2}
    for frame in (0, 3):
        steps = range(-PREROLL, frame + 1)
        samples = [sampled(shoot, render, taa.jitters(4)[step % 4]) for step in steps]
        found = render(shoot(STILL, frame), "taa", **given).rgba
        assert np.abs(found - recursion(samples, 0.2)).max() <= tolerance("running mean") * found.max()


def test_a_still_scene_nears_the_mean_over_the_pixel(shoot, render):
    """The mean of what the samples see; a finer grid's samples have smaller footprints too."""
    shot, places = shoot(STILL), (np.arange(6) + 0.5) / 6 - 0.5
    mean = np.mean([sampled(shoot, render, (x, y)) for x in places for y in places], axis=0)
    single = rms(render(shot, "pixel-aniso").rgba - mean)
    errors = [rms(render(shot, "taa", clamp="none", preroll=n, blend=1 / 16).rgba - mean) for n in (0, 16, 48)]
    assert errors[-1] < 0.5 * single
    assert errors[2] < errors[1] < errors[0]


def test_a_sequence_that_resizes_accumulates_each_still_view(shoot, render):
    scale = STILL.with_changes(motion={"kind": "scale", "from": 1.0, "to": 0.5}, frames=2)
    given = {"preroll": 48, "blend": 1 / 16}
    first, small = (render(shoot(scale, frame), "taa", **given) for frame in (0, 1))
    assert first.rgba.tobytes() == render(shoot(STILL), "taa", **given).rgba.tobytes()
    assert small.rgba.shape == (14, 24, 4)
    covered = render(shoot(scale, 1), "supersample", samples=256).rgba[..., 3]
    single = render(shoot(scale, 1), "pixel-aniso").rgba[..., 3]
    assert rms(small.rgba[..., 3] - covered) < 0.5 * rms(single - covered)


@pytest.mark.parametrize("clamp", ["box", "variance", "none"])
@pytest.mark.parametrize(
    ("name", "size"), [("road-shift", SIZE), ("road-drive", SIZE), ("road-turn", SIZE), ("road-scale", (96, 54))]
)
def test_a_constant_colour_stays_constant(shoot, render, pack_maps, tolerance, name, size, clamp):
    """Diffuse light on a flat road: its colour is one, be it read, clamped or only partly covered."""
    maps = np.zeros((4, 4, 8), np.float32)
    maps[...] = (0.2, 0.5, 0.3, 0, 0, 1, 0, 1)
    sequence = load(name).with_changes(size=size, camera=TURNED)
    rgba = render(shoot(sequence, 2, pack_maps(maps)), "taa", clamp=clamp, preroll=4).rgba
    colour = np.array([0.2, 0.5, 0.3]) * sequence.scene.sun.direction[2] * sequence.scene.sun.diffuse
    assert np.abs(rgba[..., :3] - rgba[..., 3:] * colour).max() <= tolerance("constant light")
    assert (rgba[..., 3] == 1).sum() > 200
    assert ((rgba[..., 3] > 0) & (rgba[..., 3] < 1)).sum() > 10


@pytest.fixture
def waves(pack_maps):
    """A matt road of broad waves, far below what a pixel near the eye resolves."""
    v, u = (np.mgrid[:64, :64] + 0.5) / 64 * 2 * np.pi
    maps = np.zeros((64, 64, 8), np.float32)
    maps[..., :3] = (0.5 + 0.2 * np.sin(5 * u) + 0.2 * np.cos(4 * v))[..., None]
    maps[..., 5] = 1
    return pack_maps(maps)


@pytest.mark.parametrize("name", ["road-shift", "road-drive"])
def test_the_history_follows_the_surface(shoot, render, waves, name):
    """Against the same average of the same samples with no motion followed."""
    given = {"size": (96, 54), "camera": {"pitch": -60.0, "height": 3.0}}
    sequence = load(name).with_changes(**given)
    near = (slice(6, -6), slice(6, -6))

    def picture(technique, frame, **settings):
        return render(shoot(sequence, frame, waves), technique, **settings).rgba[near]

    reference = picture("supersample", 4, samples=64)
    followed = picture("taa", 4, clamp="none", preroll=8)
    left_behind = recursion([picture("taa", frame, blend=1.0, preroll=8) for frame in range(-8, 5)], 0.1)
    blurred = picture("taa", 4, clamp="none", preroll=8, history="bilinear")
    assert rms(followed - reference) < 0.15 * rms(left_behind - reference)
    assert rms(followed - reference) < 0.7 * rms(blurred - reference)


def test_the_clamp_forgets_light_that_has_gone(shoot, render):
    """Under a sun that sweeps fast the history is of another light, which the true motion knows nothing of."""
    shot = shoot(STILL.with_changes(motion={"kind": "sun", "azimuth_speed": 600.0}))
    now = render(shot, "supersample", samples=64).rgba
    box, variance, none = (rms(render(shot, "taa", clamp=clamp).rgba - now) for clamp in ("box", "variance", "none"))
    assert variance < box < none


@pytest.mark.parametrize("name", ["road-shift", "road-hills"])
def test_memory_changes_no_bit(shoot, render, name):
    sequence = load(name).with_changes(size=SIZE)
    technique = techniques()["taa"]
    renderer, settings = technique.begin(), technique.settings(preroll=3)
    for frame in (0, 1, 2, 5, 5, 1, 2):
        kept = renderer(shoot(sequence, frame), settings)
        alone = render(shoot(sequence, frame), "taa", preroll=3)
        assert kept.rgba.tobytes() == alone.rgba.tobytes()
        assert kept.shaded == alone.shaded


def test_a_picture_stays_as_it_was_handed_out(shoot, render):
    renderer, settings = techniques()["taa"].begin(), taa.TaaSettings(preroll=0)
    pictures = [renderer(shoot(SHIFT, frame), settings).rgba for frame in range(5)]
    for frame, picture in enumerate(pictures):
        assert picture.tobytes() == render(shoot(SHIFT, frame), "taa", preroll=0).rgba.tobytes()


def test_a_frame_after_the_one_before_costs_one(shoot, monkeypatch):
    steps, advance = [], taa.Recursion.advance

    def counted(recursion, shot, before, step):
        steps.append(step)
        advance(recursion, shot, before, step)

    monkeypatch.setattr(taa.Recursion, "advance", counted)
    renderer, settings = techniques()["taa"].begin(), taa.TaaSettings(preroll=2)
    for frame in (1, 2, 4, 3):
        renderer(shoot(SHIFT, frame), settings)
    assert steps == [-2, -1, 0, 1, 2, 3, 4, -2, -1, 0, 1, 2, 3]


def test_a_resumed_run_has_the_bits_of_one_go(monkeypatch, tmp_path, maps):
    def small(sequence, launcher, *, twisted):
        return Material(launcher, Maps(maps[..., :3], maps[..., 3:6], maps[..., 6:8]))

    monkeypatch.setattr("swimlab.render.renderer.load_material", small)
    sequence = SHIFT.with_changes(frames=5, techniques={"taa": {"preroll": 3}}, size=(24, 70))
    frames = range(5)

    def run(threads, *parts):
        folder = tmp_path / str(threads)
        for part in parts:
            render_run(Plan(sequence, ("taa",), part, samples=4, half=False), folder, threads=threads)
        return [read_frame(frame_path(folder, "taa", frame)).tobytes() for frame in frames]

    whole = run(4, tuple(frames))
    assert len(set(whole)) == 5
    for threads in (1, 2, 3):
        assert run(threads, (3,), (0, 1), tuple(frames)) == whole


def test_jitters_are_haltons_points_about_the_middle(tolerance):
    assert [taa.halton(n, 2) for n in range(1, 5)] == [1 / 2, 1 / 4, 3 / 4, 1 / 8]
    assert [taa.halton(n, 3) for n in range(1, 4)] == pytest.approx([1 / 3, 2 / 3, 1 / 9])
    assert taa.jitters(1) == [(0, 0)]
    for period in (8, 16, 23):
        points = np.array(taa.jitters(period))
        assert len({tuple(point) for point in points}) == period
        assert np.abs(points.mean(axis=0)).max() <= tolerance("closed form")
        assert np.ptp(points, axis=0).max() < 1
        assert points.std(axis=0) == pytest.approx(12**-0.5, rel=0.15)
