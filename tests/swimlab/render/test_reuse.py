"""Light that `tsl` keeps from frame to frame: when it is made anew, and that what was rendered before moves no bit."""

import sys
from contextlib import suppress

import numpy as np
import pytest
from made_tiles import tiles_of

from metrics.kernels.launch import Launcher
from sequences import load
from swimlab.render import atlas
from swimlab.render import target as screen
from swimlab.render.atlas import Held, Pool, Shelf, Tiles
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.kernels.tile_table import EPOCH, KEEP, SHADE
from swimlab.render.layout import Layout
from swimlab.render.reuse import Epochs
from swimlab.render.shot import Shot
from swimlab.render.target import Lighting, Relighting, Screen, Ways
from swimlab.render.techniques import tsl
from swimlab.runs.record import RunError

SIZE = (96, 54)
NEEDED = {"size": 256, "texels": "needed", "inputs": "vmf"}
FAST = {"kind": "drive", "speed": 60.0}


def clip(shoot, sequence, frames, **settings):
    """Pictures of some frames in that order, by one renderer."""
    technique = techniques()["tsl"]
    renderer, chosen = technique.begin(), technique.settings(**settings)
    return [renderer(shoot(sequence, frame), chosen) for frame in frames]


def small(name, **changes):
    return load(name).with_changes(size=SIZE, **changes)


@pytest.mark.parametrize("given", [{"reuse": 1, "tolerance": 9.0}, {"reuse": 4, "tolerance": 0.0}])
@pytest.mark.parametrize("texels", ["all", "visible", "needed"])
def test_without_tolerance_the_light_is_of_now(shoot, render, given, texels):
    settings = NEEDED | {"texels": texels, "size": 128}
    sequence = small("road-drive")
    for frame, picture in enumerate(clip(shoot, sequence, range(3), **settings, **given)):
        plain = render(shoot(sequence, frame), "tsl", **settings)
        assert picture.rgba.tobytes() == plain.rgba.tobytes()
        assert picture.shaded == plain.shaded


@pytest.mark.parametrize("texels", ["all", "visible", "needed"])
def test_a_still_view_in_still_light_shades_each_texel_once(shoot, render, texels):
    sequence = small("road-shift", motion={"kind": "shift", "velocity": [0, 0]})
    settings = NEEDED | {"texels": texels, "size": 128}
    pictures = clip(shoot, sequence, range(4), reuse=2, **settings)
    plain = render(shoot(sequence), "tsl", **settings)
    assert [picture.shaded for picture in pictures] == [plain.shaded, 0, 0, 0]
    assert {picture.rgba.tobytes() for picture in pictures} == {plain.rgba.tobytes()}


@pytest.mark.parametrize("name", ["road-shift", "road-turn"])
def test_where_only_the_camera_turns_the_light_is_exact(shoot, render, name):
    """Light depends on the eye, not on where the camera looks: what is kept is right, and only new tiles are shaded."""
    sequence = small(name)
    pictures = clip(shoot, sequence, range(3), reuse=8, **NEEDED)
    plain = [render(shoot(sequence, frame), "tsl", **NEEDED) for frame in range(3)]
    assert [each.rgba.tobytes() for each in pictures] == [each.rgba.tobytes() for each in plain]
    assert pictures[2].shaded < plain[2].shaded / 4


@pytest.mark.parametrize(
    ("name", "changes", "settings"),
    [
        ("road-drive", {"motion": FAST}, {}),
        ("road-drive", {"motion": FAST}, {"sizes": "fitted", "texels": "visible"}),
        ("road-sun", {}, {}),
        ("road-hills", {"motion": FAST}, {}),
        ("road-sliver", {"motion": FAST}, {}),
    ],
)
def test_what_was_rendered_before_changes_no_bit(shoot, render, name, changes, settings):
    sequence = small(name, **changes)
    given = NEEDED | {"reuse": 3, "tolerance": 0.3} | settings
    frames = (0, 1, 2, 5, 5, 1, 2)
    differs = False
    for frame, kept in zip(frames, clip(shoot, sequence, frames, **given), strict=True):
        assert kept.rgba.tobytes() == render(shoot(sequence, frame), "tsl", **given).rgba.tobytes()
        differs |= not np.array_equal(kept.rgba, render(shoot(sequence, frame), "tsl", **NEEDED | settings).rgba)
    assert differs  # light was kept


def test_any_number_of_threads_gives_the_same_bits(material):
    sequence = small("road-drive", motion=FAST)
    found = []
    for threads in (1, 3):
        with Launcher(threads=threads) as launcher:

            def shoot(sequence, frame, launcher=launcher):
                return Shot(sequence, frame, material, model_of(sequence), 16, launcher)

            pictures = clip(shoot, sequence, range(4), reuse=3, tolerance=0.3, **NEEDED)
            found.append([(picture.rgba.tobytes(), picture.shaded) for picture in pictures])
    assert found[0] == found[1]


def test_less_is_shaded_and_more_is_late_the_more_is_tolerated(shoot, render):
    sequence = small("road-drive", motion=FAST)
    plain = render(shoot(sequence, 4), "tsl", **NEEDED)
    late, shaded = [], []
    for tolerance in (0.0, 0.1, 0.4, 9.0):
        picture = clip(shoot, sequence, range(5), reuse=8, tolerance=tolerance, **NEEDED)[-1]
        late.append(np.sqrt(np.mean((picture.rgba - plain.rgba) ** 2)))
        shaded.append(picture.shaded)
    assert late[0] == 0
    assert np.all(np.diff(late) > 0)
    assert np.all(np.diff(shaded) < 0)


def ages(shoot, sequence, frames, reuse, tolerance, segments=(2, 3)):
    """How old the light of each tile of two targets is, [frames, tiles], where all are read from the first frame on."""
    first = shoot(sequence, frames[0])
    tiles = tiles_of(first.launcher, Layout(np.array(segments), np.full(len(segments), 256, np.int32)))
    epochs, last, found = Epochs(reuse, tolerance), Held.nothing(first.launcher), []
    for frame in frames:
        epochs.look(first.at(frame))
        table = tiles.table.host
        table[[SHADE, KEEP]], table[EPOCH] = 0, frame
        epochs.finding(tiles, last)()
        found.append(frame - np.concatenate([table[EPOCH, tiles.layout.of(k)] for k in range(len(segments))]))
        last = tiles.hold()
    return np.array(found)


def test_tiles_take_turns(shoot):
    """Where everything is tolerated a tile is renewed every N frames, and in each frame as many are."""
    found = ages(shoot, small("road-drive"), range(12), 4, 1e9)
    assert (found[0] == 0).all()
    of_frames = found[4:]
    assert set(np.unique(of_frames)) == {0, 1, 2, 3}
    assert ((of_frames == 0).sum(axis=1) == of_frames.shape[1] / 4).all()
    assert ((of_frames == 0).sum(axis=0) == 2).all()
    assert np.array_equal(found[1:], np.where(found[1:] == 0, 0, found[:-1] + 1))


@pytest.mark.parametrize(("name", "changes"), [("road-sun", {}), ("road-drive", {"motion": FAST})])
def test_light_is_kept_while_the_lobe_allows(shoot, maps, name, changes):
    """Tile by tile, frame by frame, and no longer than between two turns."""
    sequence, frames, tolerance = small(name, **changes), range(10, 24), 0.5
    road, index = sequence.scene.road, (np.arange(8) + 0.5) / 8
    v, u = np.meshgrid(np.concatenate([2 + index, 3 + index]), index, indexing="ij")
    places = np.stack([(u - 0.5) * road.width, v * road.segment, 0 * u], axis=-1).reshape(-1, 3)

    def half(t):
        view = sequence.view(t).camera.eye(road) - places
        total = view / np.linalg.norm(view, axis=1, keepdims=True) + sequence.sun(t).direction
        return total / np.linalg.norm(total, axis=1, keepdims=True)

    steepness = np.sqrt(maps[..., 7].max() / np.e)
    turns = [frame - ages(shoot, sequence, range(frame - 7, frame + 1), 8, 1e9)[-1] for frame in frames]
    epoch = np.full(len(places), frames[0])
    for t, turn, age in zip(frames, turns, ages(shoot, sequence, frames, 8, tolerance), strict=True):
        then = np.array([half(e)[k] for k, e in enumerate(epoch)])
        changed = (epoch < turn) | (steepness * np.linalg.norm(half(t) - then, axis=1) > tolerance)
        epoch[changed] = t
        assert np.array_equal(age, t - epoch)
    assert len(np.unique(epoch)) > 2


def test_light_of_other_levels_is_not_kept(shoot):
    """Nor where finer ones are wanted than its own; that of coarser ones is a part of it."""
    shot = shoot(small("road-drive"), 1)
    tiles = tiles_of(shot.launcher, Layout(np.array([2]), np.array([256], np.int32)))
    epochs, (one, two, three) = Epochs(8, 1e9), range(1, 4)
    epochs.look(shot.at(0))
    tiles.table.host[[SHADE, KEEP]], tiles.table.host[EPOCH] = [[1], [2]], 0
    last = tiles.hold()
    table = tiles.table.host
    table[[SHADE, KEEP]], table[EPOCH] = [[1], [2]], 1
    table[SHADE, one], table[KEEP, two], table[KEEP, three] = 0, 1, 3
    epochs.look(shot)
    epochs.finding(tiles, last)()
    at = tiles.layout.of(0).start
    assert at == one
    assert table[EPOCH, 1:6].tolist() == [1, 1, 0, 0, 0]
    assert table[KEEP, 1:6].tolist() == [2, 1, 2, 2, 2]


def test_cut_segments_are_lit_anew(shoot):
    """The road ends in the last segment, which a driving eye uncovers: its light is never kept."""
    sequence = small("road-drive", scene={"road": {"length": 20.0}})
    inside, last = np.split(ages(shoot, sequence, range(8), 4, 1e9, segments=(1, 2)), 2, axis=1)
    assert inside[-1].max() == 3
    assert last.max() == 0


def test_wires_have_no_light_of_the_road(shoot):
    """An eye that drives backwards finds them under numbers that were the road's."""
    scene = {"road": {"length": 40.0, "segment": 8.0}, "wires": {"count": 8, "width": 0.3, "height": 0.8}}
    changes = {"fps": 10.0, "motion": {"kind": "drive", "speed": -240.0}, "camera": {"distance": 800.0}}
    sequence, frame, reuse = small("road-sliver", scene=scene, **changes), 8, 4
    now, before = (shoot(sequence, t).mesh for t in (frame, frame - 1))
    wires = np.unique(now.segments[now.loose])
    assert np.isin(wires, before.segments[~before.loose]).any()
    assert ages(shoot, sequence, range(frame - 3, frame + 1), reuse, 1e9, segments=wires)[-1].max() == 0


FAILING = [
    (screen, "placed"),
    (Screen, "_assign"),
    (Screen, "marking"),
    (Epochs, "look"),
    (Epochs, "finding"),
    (Launcher, "on_host"),
    (Lighting, "light"),
    (Pool, "placing"),
    (Tiles, "hold"),
    (Tiles, "show"),
    (Relighting, "__init__"),
    (Relighting, "__call__"),
    (tsl, "pasting"),
    (Tiles, "shaded"),
    (Lighting, "__init__"),
    (Ways, "of"),
    (tsl, "to_image"),
]


@pytest.mark.parametrize("begun", [False, True])
@pytest.mark.parametrize(("owner", "fails"), FAILING)
@pytest.mark.parametrize(
    ("name", "sizes"), [("road-drive", "fixed"), ("road-drive", "fitted"), ("road-shift", "fixed")]
)
def test_a_frame_that_fails_spoils_none_after_it(shoot, render, monkeypatch, name, sizes, owner, fails, begun):
    """As by Ctrl-C, before or after a part of it is done: what it gave back by then is not given back again."""
    monkeypatch.setattr(tsl, "MOST_TILES", 4 * 20)  # fewer targets than charts, so that they come and go
    sequence = small(name, motion=FAST) if name == "road-drive" else small(name)
    technique, given = techniques()["tsl"], {"size": 64, "texels": "needed", "reuse": 6, "sizes": sizes}
    renderer, settings = technique.begin(), technique.settings(**given)
    done = getattr(owner, fails)

    hits = 0

    def interrupted(*inputs, **more):
        nonlocal hits
        hits += 1
        if begun:
            done(*inputs, **more)
        raise KeyboardInterrupt

    shot = shoot(sequence)
    for frame in (0, 1, 2, 2, 3, 1, 5):
        for _ in range(2):
            picture = renderer(shot.at(frame), settings)
            assert picture.rgba.tobytes() == render(shoot(sequence, frame), "tsl", **given).rgba.tobytes()
            with monkeypatch.context() as patch:
                patch.setattr(owner, fails, interrupted)
                with suppress(KeyboardInterrupt):
                    renderer(shot.at(frame + 1), settings)
    assert hits > 2


@pytest.mark.parametrize("function", [Tiles.hold, Tiles.show, Shelf.take, Screen._assign, Pool.placing])
def test_an_interrupt_at_any_line_spoils_no_frame_after_it(shoot, render, function):
    """While what is kept from frame to frame is half changed."""
    given = {"size": 256, "texels": "needed", "reuse": 3, "sizes": "fitted"}
    lines = sorted({line for *_, line in function.__code__.co_lines() if line} - {function.__code__.co_firstlineno})
    technique, shot, stopped = techniques()["tsl"], shoot(small("road-drive", motion=FAST)), 0
    settings = technique.settings(**given)
    exact = [render(shot.at(frame), "tsl", **given).rgba.tobytes() for frame in range(6)]

    def at(line):
        def here(frame, event, _):
            if event == "line" and frame.f_lineno == line:
                sys.settrace(None)
                raise KeyboardInterrupt
            return here

        return lambda frame, *_: here if frame.f_code is function.__code__ else None

    tracing = sys.gettrace()
    for line in lines:
        renderer = technique.begin()
        for frame in range(2):
            renderer(shot.at(frame), settings)
        sys.settrace(at(line))
        try:
            renderer(shot.at(2), settings)
        except KeyboardInterrupt:
            stopped += 1
        finally:
            sys.settrace(tracing)
        for frame in (2, 3, 4, 5):
            assert renderer(shot.at(frame), settings).rgba.tobytes() == exact[frame]
    assert stopped > 1


@pytest.mark.parametrize("texels", ["all", "visible", "needed"])
def test_frames_without_road_spoil_none_after_them(shoot, render, texels):
    turning = {"camera": {"lateral": -25.0, "yaw": 70.0, "fov": 40.0}, "motion": {"kind": "turn", "speed": 3420.0}}
    sequence, given = small("road-turn", fps=18.0, **turning), {"size": 64, "texels": texels, "reuse": 4}
    pictures, empty = clip(shoot, sequence, range(8), **given), 0
    for frame, picture in enumerate(pictures):
        assert picture.rgba.tobytes() == render(shoot(sequence, frame), "tsl", **given).rgba.tobytes()
        empty += not picture.rgba.any()
    assert 0 < empty < 7


def test_after_too_many_texels_there_is_room_again(shoot, monkeypatch):
    technique, sequence = techniques()["tsl"], small("road-shift")
    renderer, settings = technique.begin(), technique.settings(size=256, reuse=6)
    before = renderer(shoot(sequence, 0), settings).rgba
    with monkeypatch.context() as patch:
        patch.setattr(atlas, "MOST_ADDRESSED", 1000)
        with pytest.raises(RunError, match="choose less"):
            renderer(shoot(sequence, 3), settings)
    assert renderer(shoot(sequence, 0), settings).rgba.tobytes() == before.tobytes()
