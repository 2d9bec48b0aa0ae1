"""Light that `tsl` keeps from frame to frame: when it is made anew, and that what was rendered before moves no bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from metrics.kernels.launch import Launcher
from sequences import load
from swimlab.render.atlas import Layout, Pool
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.kernels.tiles import MOST_TEXELS
from swimlab.render.reuse import UNKNOWN, Epochs
from swimlab.render.shot import Shot

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


def ages(shoot, sequence, frame, reuse, tolerance, segments=(2, 3)):
    """How old the light of each tile of two targets is."""
    layout = Layout(segments, np.full(len(segments), 256))
    epochs = Epochs(reuse, tolerance)
    epochs.look(shoot(sequence, frame))
    found = epochs.epochs(layout, layout.is_tile, np.full(layout.entries, UNKNOWN))
    return frame - found[layout.is_tile]


def test_tiles_take_turns(shoot):
    """Where everything is tolerated a tile is renewed every N frames, and in each frame as many are."""
    sequence = small("road-drive")
    of_frames = np.array([ages(shoot, sequence, frame, 4, 1e9) for frame in range(4, 12)])
    assert set(np.unique(of_frames)) == {0, 1, 2, 3}
    assert ((of_frames == 0).sum(axis=1) == of_frames.shape[1] / 4).all()
    assert ((of_frames == 0).sum(axis=0) == 2).all()
    assert np.array_equal(of_frames[1:], np.where(of_frames[1:] == 0, 0, of_frames[:-1] + 1))


@pytest.mark.parametrize(("name", "changes"), [("road-sun", {}), ("road-drive", {"motion": FAST})])
def test_light_is_kept_while_the_lobe_allows(shoot, maps, name, changes):
    """Tile by tile, frame by frame, from the frame in which its turn was."""
    sequence = small(name, **changes)
    road, frame, tolerance = sequence.scene.road, 20, 0.5
    index = (np.arange(8) + 0.5) / 8
    v, u = np.meshgrid(np.concatenate([2 + index, 3 + index]), index, indexing="ij")
    places = np.stack([(u - 0.5) * road.width, v * road.segment, 0 * u], axis=-1).reshape(-1, 3)

    def half(t):
        view = sequence.view(t).camera.eye(road) - places
        total = view / np.linalg.norm(view, axis=1, keepdims=True) + sequence.sun(t).direction
        return total / np.linalg.norm(total, axis=1, keepdims=True)

    steepness = np.sqrt(maps[..., 7].max() / np.e)
    epoch = frame - ages(shoot, sequence, frame, 8, 1e9)
    for t in range(frame - 7, frame + 1):
        then = np.array([half(e)[k] for k, e in enumerate(epoch)])
        changed = (epoch < t) & (steepness * np.linalg.norm(half(t) - then, axis=1) > tolerance)
        epoch[changed] = t
    assert np.array_equal(ages(shoot, sequence, frame, 8, tolerance), frame - epoch)
    assert len(np.unique(epoch)) > 2


def test_cut_segments_are_lit_anew(shoot):
    """The road ends in the last segment, which a driving eye uncovers: its light is never kept."""
    sequence = small("road-drive", scene={"road": {"length": 20.0}})
    inside, last = np.split(ages(shoot, sequence, 8, 4, 1e9, segments=(1, 2)), 2)
    assert inside.max() == 3
    assert last.max() == 0


@settings(derandomize=True, max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_blocks_that_are_held_never_overlap(launcher, seed):
    """Whatever was given back before; and all lie within the pool, beyond the texels that are nobody's."""
    rng, pool = np.random.default_rng(seed), Pool(launcher)
    held = np.zeros((0, 2), np.int64)
    for _ in range(12):
        sizes = rng.choice([1, 4, 20, 84, 340], rng.integers(0, 30))
        held = np.concatenate([held, np.stack([pool.take(sizes), sizes], axis=1)])
        lost = rng.random(len(held)) < 0.5
        pool.give(*held[lost].T)
        held = held[~lost]
        start, size = held[np.argsort(held[:, 0])].T
        assert (start[1:] >= (start + size)[:-1]).all()
        assert (start >= MOST_TEXELS).all()
        assert (start + size <= len(pool.texels)).all()
