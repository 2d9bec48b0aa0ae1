"""Of which frame the light of a tile is that `tsl` keeps."""

from typing import Literal

import numpy as np
import pytest
from made_tiles import tiles_of

from sequences import View, load
from sequences.motion import Motion
from swimlab.render.atlas import Held
from swimlab.render.kernels.tile_table import EPOCH, KEEP, SHADE
from swimlab.render.layout import Layout
from swimlab.render.reuse import Epochs, Roads, rows_of

FAST = {"kind": "drive", "speed": 60.0}


def small(name, **changes):
    return load(name).with_changes(size=(96, 54), **changes)


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
    epochs, first = Epochs(8, 1e9), tiles.layout.of(0).start
    epochs.look(shot.at(0))
    tiles.table.host[[SHADE, KEEP]], tiles.table.host[EPOCH] = [[1], [2]], 0
    last = tiles.hold()
    table = tiles.table.host
    table[[SHADE, KEEP]], table[EPOCH] = [[1], [2]], 1
    their_turn, coarser, finer, wanted, less = first + 1, first + 2, first + 3, first + 4, first + 5
    table[SHADE, coarser], table[SHADE, finer], table[KEEP, wanted], table[KEEP, less] = 2, 0, 1, 3
    epochs.look(shot)
    epochs.finding(tiles, last)()
    assert table[EPOCH, first : first + 8].tolist() == [0, 1, 1, 1, 1, 0, 0, 0]
    assert table[EPOCH, their_turn] == 1
    assert table[KEEP, first : first + 8].tolist() == [2, 2, 2, 2, 1, 2, 2, 2]


def test_cut_segments_are_lit_anew(shoot):
    """The road ends in the last segment, which a driving eye uncovers: its light is never kept."""
    sequence = small("road-drive", scene={"road": {"length": 20.0}})
    inside, last = np.split(ages(shoot, sequence, range(8), 4, 1e9, segments=(1, 2)), 2, axis=1)
    assert inside[-1].max() == 3
    assert last.max() == 0


def test_light_of_a_segment_that_was_cut_is_made_anew_once_it_is_whole(shoot):
    """The road ends 20 m before the eye, which moves by 1 m a frame: it has all of segment 3 from frame 12 on."""
    sequence = small("road-drive", scene={"road": {"length": 20.0}}, motion=FAST)
    found = ages(shoot, sequence, range(10, 15), 8, 1e9, segments=(3,)).max(axis=1)
    assert found.tolist() == [0, 0, 0, 1, 2]


def test_light_that_is_of_a_whole_segment_is_kept_when_it_is_cut(shoot):
    """The eye drives backwards, and the road's end cuts segment 3 from frame 9 on."""
    motion = {"kind": "drive", "speed": -60.0}
    sequence = small("road-drive", scene={"road": {"length": 20.0}}, camera={"distance": 20.0}, motion=motion)
    assert ages(shoot, sequence, range(13), 64, 1e9, segments=(3,)).max(axis=1).tolist() == list(range(13))


def test_segments_are_whole_that_reach_both_ends_and_face_the_eye(shoot):
    mesh = shoot(small("road-hills", motion=FAST), 5).mesh
    whole, turned = set(), 0
    for segment in np.unique(mesh.segments):
        mine = mesh.segments == segment
        v, facing = mesh.uv[mesh.triangles[mine], 1], mesh.facing[mine].all()
        ends = v.min() == 0 and v.max() == 1
        turned += ends and not facing
        if ends and facing:
            whole.add(int(segment))
    found = Roads.of(mesh)
    assert found.segments.tolist() == np.unique(mesh.segments).tolist()
    assert found.whole.tolist() == sorted(whole)
    assert 0 < len(whole) < len(found.segments)
    assert turned > 0


def test_rows_follow_targets_of_the_same_size(shoot):
    """Where a target was there with as many tiles, each of its rows is known by the first of its entries then."""
    road = small("road-drive").scene.road
    now = Layout(np.array([2, 3, 5]), np.array([64, 32, 64], np.int32))
    last = Layout(np.array([1, 2, 3, 5]), np.array([64, 32, 32, 64], np.int32))
    rows = rows_of(now, last, road)
    first = last.of(2).start, last.of(3).start
    assert rows.before.tolist() == [-1, -1, first[0], first[1], first[1] + 2]
    assert rows.targets.tolist() == [[0, 1, 2, 0], [0, 3, 2, 1], [1, 6, 1, 0], [2, 8, 2, 0], [2, 10, 2, 1]]


@pytest.mark.parametrize("change", [{"azimuth": 10.0}, {"diffuse": 0.4}])
def test_light_changes_with_the_sun_itself(shoot, monkeypatch, change):
    """Also where nothing shines; a tile is lit anew when the sun has changed by more than the tolerance."""
    steps = [0.0, 0.0, 1.0, 1.0, 1.0]

    class Changing(Motion):
        kind: Literal["changing"] = "changing"

        def view(self, sequence, t):
            return View(*sequence.size, (0.0, 0.0), (1.0, 1.0), sequence.camera)

        def sun(self, sequence, t):
            sun = sequence.scene.sun
            values = {key: getattr(sun, key) + steps[max(t, 0)] * by for key, by in change.items()}
            return sun.model_copy(update=values)

    sequence = small("road-drive").model_copy(update={"motion": Changing()})
    monkeypatch.setitem(vars(shoot(sequence).material), "highest_power", 0.0)
    suns = [sequence.sun(t) for t in (0, 2)]
    by = np.linalg.norm([*(suns[1].direction - suns[0].direction), suns[1].diffuse - suns[0].diffuse])
    for tolerance, renewed in ((0.99 * by, True), (1.01 * by, False)):
        found = ages(shoot, sequence, range(5), 64, tolerance)
        assert np.all(found[2] == 0) == renewed
        assert found[4].max() == (2 if renewed else 3)


def test_wires_have_no_light_of_the_road(shoot):
    """An eye that drives backwards finds them under numbers that were the road's."""
    scene = {"road": {"length": 40.0, "segment": 8.0}, "wires": {"count": 8, "width": 0.3, "height": 0.8}}
    changes = {"fps": 10.0, "motion": {"kind": "drive", "speed": -240.0}, "camera": {"distance": 800.0}}
    sequence, frame, reuse = small("road-sliver", scene=scene, **changes), 8, 4
    now, before = (shoot(sequence, t).mesh for t in (frame, frame - 1))
    wires = np.unique(now.segments[now.loose])
    assert np.isin(wires, before.segments[~before.loose]).any()
    assert ages(shoot, sequence, range(frame - 3, frame + 1), reuse, 1e9, segments=wires)[-1].max() == 0
