"""Blender's Cycles: multi-layer files are read as they are, vectors are verified, and builds rank as they must."""

import shutil

import pytest

pytestmark = [
    pytest.mark.may_skip("Blender is half a gigabyte, which CI does not install"),
    pytest.mark.skipif(shutil.which("blender") is None, reason="blender is not installed"),
]


@pytest.fixture(scope="module")
def found(example, entries, tmp_path_factory):
    """Of scores.json, by build."""
    folder = tmp_path_factory.mktemp("gallery")
    example("blender").main(["-o", str(folder), "--size", "128x72", "--frames", "3"])
    return entries(folder)


def test_one_sample_is_worse_than_four(found):
    worse, better = (found[build]["scores"] for build in ("aliased", "four-samples"))
    for name in ("budget.flicker", "edges.flicker", "frame.mse"):
        assert worse[name] > 2 * better[name], name


def test_the_vector_pass_is_verified(found):
    assert {entry["motion_check"]["verdict"] for entry in found.values()} == {"verified"}
