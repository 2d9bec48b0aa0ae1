"""Every kernel under Warp's debug mode, the only one that checks bounds; native code, which it cannot see into, between
guards."""

import json
import subprocess
import sys

import numpy as np
import pytest
import warp as wp

from metrics.kernels.launch import Strip
from metrics.kernels.making import made_once
from sequences import load
from swimlab.render.catalogue import techniques
from swimlab.render.geometry import describe_geometry
from swimlab.render.kernels.packet import PLACES, locate_before, rows_of
from swimlab.render.kernels.structs import LANES, TEXELS, Chain, Grid, Planes
from swimlab.render.kernels.texture_filter import FINEST, ISOTROPIC, anisotropic_to
from swimlab.render.technique import shading
from swimlab.render.texture import MipChain
from swimlab.render.triangles import visibility

TSL = {"size": 64}
CASES = {
    **{name: (name, TSL if name == "tsl" else {}) for name in techniques()},
    "tsl, needed texels": ("tsl", TSL | {"texels": "needed", "inputs": "lean"}),
    "tsl, fitted targets": ("tsl", {"size": 128, "sizes": "fitted", "coarser": 1, "inputs": "vmf"}),
    "tsl, light that is kept": ("tsl", TSL | {"texels": "needed", "reuse": 4, "tolerance": 0.3}),
    "taa, bilinear, variance": ("taa", {"history": "bilinear", "clamp": "variance", "preroll": 3}),
    "taa, no clamp": ("taa", {"clamp": "none", "preroll": 3}),
    "reference, gaussian": ("reference", {"filter": "gaussian"}),
    "reference, mitchell": ("reference", {"filter": "mitchell"}),
}
"""Technique and settings: among them they start every kernel."""

SCRIPT = """
import json
import sys
import numpy as np
import warp as wp

wp.config.mode = "debug"

from sequences import load
from sequences.asphalt import make
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.geometry import describe_geometry
from swimlab.render.inputs import Maps
from swimlab.render.kernels.packet import each_lane, plain_packet
from swimlab.render.kernels.shading import in_local_frame
from swimlab.render.kernels.texture_filter import TextureFilter
from metrics.kernels.launch import Launcher
from swimlab.render.material import Material
from swimlab.render.shot import Shot

cases = json.loads(sys.argv[2])
sequence = load("road-drive").with_changes(size=(16, 9))
pictures = {}
# Two threads in kernels built for debugging crash Warp 1.19; bounds are the same for one.
with Launcher(threads=1) as launcher:
    shot = Shot(sequence, 2, Material(launcher, Maps(*make(0, 64))), model_of(sequence), 16, launcher)

    def render(names):
        for label in names:
            name, given = cases[label]
            technique = techniques()[name]
            yield technique.render(shot, technique.settings(**given)).rgba

    pictures |= dict(zip(cases, render(cases)))
    pictures["depth"] = describe_geometry(shot).depth
    # The plain forms, in place of the native ones.
    TextureFilter.fill = lambda self, width, device: each_lane(self.plain, width)
    Shot.shade_packet = lambda self, inputs, width: plain_packet(
        inputs.reflect or in_local_frame(self.model.evaluate, width), width
    )
    plain = json.loads(sys.argv[3])
    pictures |= dict(zip([f"plain {name}" for name in plain], render(plain)))
np.savez(sys.argv[1], **pictures)
"""
PLAIN = ["pixel-bilinear", "pixel-trilinear", "pixel-aniso", "lean"]


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("debug")
    result = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(folder / "pictures.npz"), json.dumps(CASES), json.dumps(PLAIN)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert "out of bounds" not in (result.stdout + result.stderr).lower()
    assert "assert" not in (result.stdout + result.stderr).lower()
    with np.load(folder / "pictures.npz") as pictures:
        yield dict(pictures)


@pytest.mark.parametrize("case", [*CASES, "depth"])
def test_bounds_hold_and_debug_agrees_with_release(checked, shoot, render, tolerance, case):
    shot = shoot(load("road-drive").with_changes(size=(16, 9)), 2)
    if case == "depth":
        expected = describe_geometry(shot).depth
    else:
        name, given = CASES[case]
        expected = render(shot, name, **given).rgba
    assert expected.any()
    assert np.abs(checked[case] - expected).max() <= tolerance("debug against release") * expected.max()


@pytest.mark.parametrize("name", PLAIN)
def test_bounds_of_the_forms_that_native_code_stands_for_hold(checked, tolerance, name):
    native, plain = checked[name], checked[f"plain {name}"]
    assert np.abs(native - plain).max() <= tolerance("native against plain") * native.max()


GUARD = 64
"""Texels, or values, before and behind what native code may touch."""
SENTINEL = -7.5


@made_once
def guarded_filling(fill, width):
    """A kernel that fills packets of `count` lanes whose rows lie between guards, and shows all of them."""
    texel_type = TEXELS[width]
    floats = rows_of(width) * LANES

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        count: wp.int32,
        given: wp.array2d(dtype=wp.float64),
        out: wp.array2d(dtype=wp.float32),
    ):
        packet = wp.tid()
        places = wp.zeros(shape=(PLACES,), dtype=wp.float64)
        for k in range(PLACES):
            places[k] = given[packet, k]
        fill(texels, chain, places, count, out[packet])

    return kernel, floats


@pytest.mark.parametrize("filtered", [FINEST, ISOTROPIC, anisotropic_to(16)])
@pytest.mark.parametrize("width", [4, 8, 9, 10])
@pytest.mark.parametrize("clamps", [False, True])
def test_native_filters_stay_within_their_chain_and_packet(launcher, filtered, width, clamps):
    """Texels beside the chain are NaN; floats beside the packet keep what they hold."""
    random = np.random.default_rng(0)
    dtype = TEXELS[width]
    chain = MipChain.allocate(launcher, width=16, height=8, dtype=dtype, clamps=clamps)
    chain.texels.fill_(1.0)
    texels = np.full((len(chain.texels) + 2 * GUARD, width), np.nan, np.float32)
    texels[GUARD:-GUARD] = 1.0
    chain.shape.offsets = launcher.array(chain.shape.offsets.numpy() + GUARD, wp.int32)
    packets, count = 32, LANES - 3
    uv = np.concatenate(
        [random.uniform(-3, 3, (packets // 2, 2, LANES)), random.uniform(-1e6, 1e6, (packets // 2, 2, LANES))]
    )
    spread = 10.0 ** random.uniform(-9, 9, (packets, 4, LANES)) * random.choice([-1, 0, 1], (packets, 4, LANES))
    given = launcher.array(np.concatenate([uv, spread], axis=1).reshape(packets, PLACES), wp.float64)
    kernel, floats = guarded_filling(filtered.fill(width, "cpu"), width)
    out = wp.full((packets, floats + GUARD), SENTINEL, dtype=wp.float32, device="cpu")
    launcher.launch(kernel, packets, [launcher.array(texels, dtype), chain.shape, count, given, out])
    found = out.numpy()
    rows = found[:, : width * LANES].reshape(packets, width, LANES)
    assert np.abs(rows[..., :count] - 1).max() < 1e-5
    assert (rows[..., count:] == SENTINEL).all()
    assert (found[:, width * LANES :] == SENTINEL).all()


locate = locate_before(8).native


@wp.kernel(enable_backward=False)
def guarded_location(
    grid: Grid,
    planes: wp.array(dtype=Planes),
    count: wp.int32,
    places: wp.array2d(dtype=wp.float64),
    lanes: wp.array2d(dtype=wp.float32),
):
    triangle = wp.tid()
    locate(planes[triangle], grid, 3, 5, count, places[triangle], lanes[triangle])


def test_native_locating_stays_within_its_packet(shoot, launcher):
    shot = shoot(load("road-hills"))
    planes, count = shot.triangles.planes, LANES - 3
    places = wp.full((len(planes), PLACES + GUARD), SENTINEL, dtype=wp.float64, device="cpu")
    lanes = wp.full((len(planes), rows_of(8) * LANES + GUARD), SENTINEL, dtype=wp.float32, device="cpu")
    launcher.launch(guarded_location, len(planes), [shot.grid(), planes, count, places, lanes])
    for found, first, last in ((places.numpy(), 0, 6), (lanes.numpy(), 8, 12)):
        assert (found[:, last * LANES :] == SENTINEL).all()
        rows = found[:, : last * LANES].reshape(len(found), last, LANES)
        assert (rows[:, :first] == SENTINEL).all()
        assert (rows[..., count:] == SENTINEL).all()
        assert (rows[:, first:, :count] != SENTINEL).any(axis=(1, 2)).all()


@pytest.mark.parametrize("n", [1, 3])
def test_gathering_stays_within_its_rows_of_the_picture(shoot, launcher, n):
    """A picture that is a part of a larger one, as targets' tiles are."""
    shot = shoot(load("road-drive").with_changes(size=(90, 20)))
    whole = [wp.full((30, 110), wp.vec4(SENTINEL), dtype=wp.vec4, device="cpu") for _ in range(2)]
    picture, error = (each[4:24, 7:97] for each in whole)
    for part in (picture, error):
        part.fill_(0.0)
    grid, strip = shot.grid(n), Strip(6, 9)
    shade = shading(shot, FINEST, n)
    shaded = launcher.zeros(20, wp.int32)
    visible = visibility(launcher, shot.triangles, grid, strip, n)
    shade(grid, shot.triangles, visible, strip, picture, error, shaded)
    for each in whole:
        inside = np.zeros((30, 110), bool)
        inside[4:24, 7:97] = True
        assert (each.numpy()[~inside] == SENTINEL).all()
    rows = picture.numpy()
    assert not rows[:6].any()
    assert not rows[15:].any()
    assert np.array_equal(rows[..., 3] > 0, rows[..., :3].any(axis=2))
    assert rows[6:15, :, 3].any()
    assert shaded.numpy().sum() == np.sum(visible.numpy() >= 0)
