"""Light that `tsl` keeps from frame to frame: what was rendered before moves no bit, and nothing is lit in vain."""

import sys
from contextlib import suppress
from typing import Literal

import numpy as np
import pytest

from metrics.kernels.launch import Launcher
from sequences import View, load
from sequences.motion import Motion
from swimlab.render import atlas
from swimlab.render import target as screen
from swimlab.render.atlas import Pool, Shelf, Tiles
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.kernels.texture_space import NEVER
from swimlab.render.kernels.tile_table import ANEW, EPOCH, SHADE
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


class Halting(Motion):
    """A drive that halts and goes on."""

    kind: Literal["halting"] = "halting"

    def view(self, sequence, t):
        moved = (0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.4, 1.8, 1.0, 1.0)[min(max(t, 0), 11)]
        turned = sequence.camera.yaw + 4.0 * (t % 3)
        camera = sequence.camera.model_copy(update={"distance": moved, "yaw": turned})
        return View(*sequence.size, (0.0, 0.0), (1.0, 1.0), camera)


@pytest.mark.parametrize("texels", ["all", "visible", "needed"])
def test_an_eye_that_halts_changes_no_bit(shoot, render, texels):
    """What was lit before it halted is told from what was lit since, however the clip is cut."""
    sequence = small("road-drive").model_copy(update={"motion": Halting()})
    given = {"size": 128, "texels": texels, "reuse": 4, "tolerance": 1.0}
    exact = [render(shoot(sequence, frame), "tsl", **given).rgba.tobytes() for frame in range(14)]
    for frames in (range(14), (11, 7, 8, 9, 10, 11, 12), (9, 2, 3, 6, 10, 13)):
        pictures = clip(shoot, sequence, frames, **given)
        assert [picture.rgba.tobytes() for picture in pictures] == [exact[frame] for frame in frames]


def test_light_of_another_frame_is_held(shoot, monkeypatch):
    """What is lit anew is lit as of now, so whatever is not of now must be there."""
    sequence, old = small("road-drive", motion=FAST), 0
    done = Tiles.hold

    def held(tiles):
        nonlocal old
        table = tiles.table.host[:, : tiles.layout.entries]
        older = (table[EPOCH] != table[EPOCH].max()) & (table[SHADE] != NEVER)
        assert (table[ANEW][older] == NEVER).all()
        old += older.sum()
        return done(tiles)

    monkeypatch.setattr(Tiles, "hold", held)
    for changes in ({}, {"texels": "visible", "sizes": "fitted"}, {"texels": "all", "size": 64}):
        clip(shoot, sequence, (3, 4, 5, 8, 9), **NEEDED | changes, reuse=3, tolerance=0.3)
    assert old > 0


def test_a_jump_lights_only_what_its_frame_needs(shoot, monkeypatch):
    """All frames whose light may be kept, or those since the last; none where the light is the same."""
    lit, begun = [], []
    done = tsl.Targets._light

    def light(targets, shot, **more):
        lit.append(shot.frame)
        if targets._held is targets._nothing:
            begun.append(shot.frame)
        return done(targets, shot, **more)

    monkeypatch.setattr(tsl.Targets, "_light", light)
    clip(shoot, small("road-drive", motion=FAST), (20, 21, 23, 30, 29), reuse=4, **NEEDED)
    assert lit == [17, 18, 19, 20, 21, 22, 23, 27, 28, 29, 30, 26, 27, 28, 29]
    assert begun == [17, 27, 26]
    lit.clear()
    pictures = clip(shoot, small("road-shift"), (20, 22, 22, 3), reuse=4, **NEEDED)
    assert lit == [20, 22, 22, 3]
    assert pictures[2].shaded == 0
    assert 0 < 4 * pictures[1].shaded < pictures[0].shaded


def test_frames_that_fail_on_the_way_to_another_spoil_none(shoot, render, monkeypatch):
    """As by Ctrl-C in the midst of those that a frame begins with."""
    sequence, given = small("road-drive", motion=FAST), NEEDED | {"reuse": 5, "tolerance": 0.3}
    shot, technique, done = shoot(sequence), techniques()["tsl"], tsl.Targets._light
    settings = technique.settings(**given)
    exact = {frame: render(shot.at(frame), "tsl", **given).rgba.tobytes() for frame in range(15, 22)}
    for failing in range(15, 21):
        renderer = technique.begin()

        def light(targets, shot, failing=failing, **more):
            if shot.frame == failing:
                raise KeyboardInterrupt
            return done(targets, shot, **more)

        with monkeypatch.context() as patch:
            patch.setattr(tsl.Targets, "_light", light)
            with suppress(KeyboardInterrupt):
                renderer(shot.at(20), settings)
        for frame in range(failing, 22):
            assert renderer(shot.at(frame), settings).rgba.tobytes() == exact[frame]


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


class Glancing(Motion):
    """A drive in which the eye looks away from the road in every fourth frame."""

    kind: Literal["glancing"] = "glancing"

    def view(self, sequence, t):
        camera = sequence.camera.model_copy(update={"distance": 0.2 * t, "pitch": 80.0 if t % 4 == 3 else -8.0})
        return View(*sequence.size, (0.0, 0.0), (1.0, 1.0), camera)


def test_a_driving_eye_that_looks_away_for_a_frame_changes_no_bit(shoot, render):
    sequence = small("road-drive").model_copy(update={"motion": Glancing()})
    given = NEEDED | {"reuse": 2, "tolerance": 1e9}
    pictures = clip(shoot, sequence, range(9), **given)
    for frame, picture in enumerate(pictures):
        assert picture.rgba.tobytes() == render(shoot(sequence, frame), "tsl", **given).rgba.tobytes()
    assert [bool(picture.rgba.any()) for picture in pictures] == [frame % 4 != 3 for frame in range(9)]


def test_after_too_many_texels_there_is_room_again(shoot, monkeypatch):
    technique, sequence = techniques()["tsl"], small("road-shift")
    renderer, settings = technique.begin(), technique.settings(size=256, reuse=6)
    before = renderer(shoot(sequence, 0), settings).rgba
    with monkeypatch.context() as patch:
        patch.setattr(atlas, "MOST_ADDRESSED", 1000)
        with pytest.raises(RunError, match="choose less"):
            renderer(shoot(sequence, 3), settings)
    assert renderer(shoot(sequence, 0), settings).rgba.tobytes() == before.tobytes()
