"""three.js in a headless Chromium: its vectors are what they are said to be, and its builds rank as they must."""

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from swimlab.runs.frames import read_channels

HOME = Path(__file__).parents[2] / "reports" / "engines" / "threejs"
FRAMES = 4

pytestmark = [
    pytest.mark.may_skip("three.js comes from npm, which not every machine has; `make test` asks it where it is"),
    pytest.mark.skipif(shutil.which("chromium") is None, reason="chromium is not installed"),
    pytest.mark.skipif(
        not (HOME / "node_modules" / "three").is_dir(),
        reason="three.js is not installed: npm install --prefix reports/engines/threejs",
    ),
]


@pytest.fixture(scope="module")
def gallery(example, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("gallery")
    example("threejs").main(["-o", str(folder), "--size", "160x90", "--frames", str(FRAMES)])
    return folder


def test_the_shot_file_names_what_is_written(gallery):
    shot = tomllib.loads((gallery / "shot.toml").read_text(encoding="utf-8"))
    inputs = [shot["reference"], shot["motion"], shot["depth"], *shot["builds"].values()]
    assert {path.name for path in gallery.iterdir() if path.is_dir()} == {
        Path(given["frames"]).parent.name for given in inputs
    } | {"run"}
    for given in inputs:
        assert len(list((gallery / given["frames"]).parent.glob("*.exr"))) == FRAMES


def test_builds_rank_as_they_must(gallery, entries):
    found = {build: entry["scores"] for build, entry in entries(gallery).items()}
    assert set(found) == {"aliased", "filtered", "supersampled"}
    for name in ("budget.flicker", "edges.flicker", "frame.mse"):
        assert max(found, key=lambda build: found[build][name]) == "aliased", name
        assert found["aliased"][name] > 2 * max(found["filtered"][name], found["supersampled"][name])


def test_vectors_are_verified_as_three_js_has_them(gallery, entries):
    assert {entry["motion_check"]["verdict"] for entry in entries(gallery).values()} == {"verified"}


def test_the_run_has_a_report(gallery):
    assert "threejs-gallery" in (gallery / "run" / "report.html").read_text(encoding="utf-8")


def test_depth_of_the_floor_is_that_of_a_plane(gallery, tolerance):
    """Along a column of pixels, 1/depth of a plane is linear."""
    depth = read_channels(gallery / "depth" / "0000.exr", ("Z",))[-20:, -1, 0].astype(float)
    assert np.abs(np.diff(1 / depth, 2)).max() * depth.max() < tolerance("depth")
