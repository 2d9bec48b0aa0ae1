"""Blender's Cycles: multi-layer files are read as they are, vectors are verified, and builds rank as they must."""

import json
import shutil

import pytest

pytestmark = pytest.mark.skipif(shutil.which("blender") is None, reason="blender is not installed")


@pytest.fixture(scope="module")
def entries(example, tmp_path_factory):
    """Of scores.json, by build."""
    folder = tmp_path_factory.mktemp("gallery")
    example("blender").main(["-o", str(folder), "--size", "128x72", "--frames", "3"])

    def entry(build):
        return json.loads((folder / "scores" / build / "scores.json").read_text(encoding="utf-8"))["sequences"][0]

    return {build: entry(build) for build in ("aliased", "four-samples")}


def test_one_sample_is_worse_than_four(entries):
    worse, better = (entries[build]["scores"] for build in ("aliased", "four-samples"))
    for name in ("budget.flicker", "edges.flicker", "frame.mse"):
        assert worse[name] > 2 * better[name], name


def test_the_vector_pass_is_verified(entries):
    assert {entry["motion_check"]["verdict"] for entry in entries.values()} == {"verified"}
