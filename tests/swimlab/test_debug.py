"""Every kernel under Warp's debug mode, the only one that checks bounds."""

import os
import subprocess
import sys

import numpy as np
import pytest

from sequences import load
from swimlab.catalogue import techniques
from swimlab.geometry import describe_geometry

SCRIPT = """
import sys
import numpy as np
import warp as wp

wp.config.mode = "debug"

from sequences import load
from sequences.asphalt import make
from swimlab.catalogue import model_of, techniques
from swimlab.geometry import describe_geometry
from swimlab.launch import Launcher
from swimlab.inputs import Maps
from swimlab.material import Material
from swimlab.shot import Shot

sequence = load("road-drive").with_changes(size=(16, 9))
pictures = {}
with Launcher(threads=2) as launcher:
    shot = Shot(sequence, 2, Material(launcher, Maps(*make(0, 64))), model_of(sequence), 16, launcher)
    for name, technique in techniques().items():
        given = {"size": 32} if name == "tsl" else {}
        pictures[name] = technique.render(shot, technique.settings(**given)).rgba
    pictures["depth"] = describe_geometry(shot).depth
np.savez(sys.argv[1], **pictures)
"""


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("debug")
    result = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(folder / "pictures.npz")],
        env=os.environ | {"WARP_CACHE_PATH": str(folder / "cache")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert "out of bounds" not in (result.stdout + result.stderr).lower()
    assert "assert" not in (result.stdout + result.stderr).lower()
    with np.load(folder / "pictures.npz") as pictures:
        yield dict(pictures)


@pytest.mark.parametrize("name", [*techniques(), "depth"])
def test_bounds_hold_and_debug_agrees_with_release(checked, shoot, render, tolerance, name):
    shot = shoot(load("road-drive").with_changes(size=(16, 9)), 2)
    if name == "depth":
        expected = describe_geometry(shot).depth
    else:
        expected = render(shot, name, **({"size": 32} if name == "tsl" else {})).rgba
    assert expected.any()
    assert np.abs(checked[name] - expected).max() <= tolerance("debug against release") * expected.max()
