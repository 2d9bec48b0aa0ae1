"""OpenGL on the CPU by Mesa: vectors and depth in closed form, and builds rank as they must."""

import importlib.util
from ctypes.util import find_library
from pathlib import Path

import numpy as np
import pytest

from swimlab.runs.frames import read_channels

SIZE = (160, 90)

pytestmark = [
    pytest.mark.may_skip("moderngl and a driver of OpenGL are not among what the tests install"),
    pytest.mark.skipif(importlib.util.find_spec("moderngl") is None, reason="moderngl is not installed"),
    pytest.mark.skipif(find_library("EGL") is None, reason="libEGL, by which moderngl draws, is not installed"),
]


@pytest.fixture(scope="module")
def drawn(example, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("gallery")
    example("opengl").main(["-o", str(folder), "--size", "{}x{}".format(*SIZE), "--frames", "3"])
    return folder


def test_builds_rank_as_they_must(drawn, entries):
    found = entries(drawn)
    assert {entry["motion_check"]["verdict"] for entry in found.values()} == {"verified"}
    for name in ("budget.flicker", "edges.flicker", "frame.mse"):
        assert max(found, key=lambda build: found[build]["scores"][name]) == "aliased", name


def test_motion_and_depth_of_the_floor_are_those_of_the_camera(drawn, example, tolerance):
    """The points of the floor that frame 2 sees, taken to where frame 1 had them."""
    gallery = example("opengl").gallery
    depth = read_channels(drawn / "depth" / "0002.exr", ("Z",))[-10:, -10:, 0].astype(float)
    stored = read_channels(drawn / "motion" / "0002.exr", ("R", "G"))[-10:, -10:].astype(float)
    width, height = SIZE
    x = (np.arange(width - 10, width) + 0.5) / width * 2 - 1
    y = 1 - (np.arange(height - 10, height) + 0.5) / height * 2
    now = np.stack(np.meshgrid(x, y), axis=-1)
    focal = gallery.lens(SIZE).diagonal()[:2]
    seen = np.concatenate([now / focal * depth[..., None], -depth[..., None], np.ones((10, 10, 1))], axis=-1)
    world = seen @ np.linalg.inv(gallery.camera(2)[1]).T
    assert np.abs(world[..., 1]).max() < tolerance("depth") * depth.max()
    clip = world @ (gallery.lens(SIZE) @ gallery.camera(1)[1]).T
    px = np.array([width, height]) / 2
    assert np.abs((now - clip[..., :2] / clip[..., 3:] - stored) * px).max() < tolerance("motion from float32 depth")
