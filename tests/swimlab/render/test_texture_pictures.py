"""`render --targets`: texture space as pictures."""

import cv2
import numpy as np
import pytest

from swimlab.render.texture_pictures import write_targets
from swimlab.runs.frames import COLOUR, read_channels

FLAT = """
version = 1
name = "flat"
frames = 2
size = [64, 36]
[scene.road]
length = 20.0
[camera]
pitch = -14.0
height = 2.0
[techniques.tsl]
size = 64
"""


@pytest.fixture
def flat(tmp_path):
    (tmp_path / "flat.toml").write_text(FLAT, encoding="utf-8")
    return tmp_path / "flat.toml"


def test_every_segment_in_sight_is_written_for_every_frame(swimlab, flat, tmp_path):
    run = tmp_path / "run"
    code, _, err = swimlab("render", str(flat), "-t", "tsl", "-o", str(run), "--targets", "-q")
    assert code == 0, err
    for frame in ("0000", "0001"):
        names = sorted(path.name for path in (run / "targets" / frame).iterdir())
        assert names == [f"{segment:04d}.{kind}" for segment in range(3) for kind in ("exr", "png")]
    light = read_channels(run / "targets" / "0000" / "0001.exr", COLOUR)
    assert light.shape == (64, 64, 4)
    assert (light[..., 3] == 1).all()
    assert light[..., :3].min() > 0
    # The road ends in the middle of the third segment: the rest of its target stays clear.
    cut = read_channels(run / "targets" / "0000" / "0002.exr", COLOUR)
    assert (cut[:32, :, 3] == 1).all()
    assert not cut[32:].any()


def test_the_picture_has_normals_at_the_left_and_light_at_the_right(shoot, pack_maps, tolerance, tmp_path, flat):
    from sequences import load

    maps = np.zeros((64, 64, 8), np.float32)
    maps[..., :3] = 0.25
    maps[..., 3:6] = (0.6, 0.0, 0.8)
    sequence = load(flat).with_changes(scene={"sun": {"elevation": 90.0, "diffuse": 1.0}})
    write_targets(tmp_path, shoot(sequence, 0, pack_maps(maps)), {})
    picture = cv2.imread(str(tmp_path / "targets" / "0000" / "0001.png"))[..., ::-1] / 255
    half = tolerance("half a code")
    assert picture[:, :64] == pytest.approx(np.broadcast_to([0.8, 0.5, 0.9], (64, 64, 3)), abs=half)
    assert picture[:, 64:] == pytest.approx(np.full((64, 64, 3), np.sqrt(0.25 * 0.8)), abs=half)


def test_tiles_are_shown_at_the_level_they_were_shaded_at(shoot, swimlab, tmp_path, flat):
    flat.write_text(FLAT + 'texels = "needed"\n', encoding="utf-8")
    code, _, err = swimlab("render", str(flat), "-t", "tsl", "-o", str(tmp_path / "run"), "--targets", "-q")
    assert code == 0, err
    far = read_channels(tmp_path / "run" / "targets" / "0000" / "0002.exr", COLOUR)
    # Tiles of 32 texels: at a coarse level two neighbours are one texel.
    assert np.array_equal(far[0:2, 0::2], far[0:2, 1::2])


def test_targets_are_those_of_tsl(swimlab, flat, tmp_path):
    code, _, err = swimlab("render", str(flat), "-t", "vmf", "-o", str(tmp_path / "run"), "--targets", "-q")
    assert code == 2
    assert "--targets: writes the targets of tsl; add it to --techniques" in err
    assert not (tmp_path / "run").exists()
