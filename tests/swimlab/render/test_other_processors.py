"""Native forms assume no instruction set: built for a plain x86-64 processor they give the same pictures."""

import platform
import subprocess
import sys

import numpy as np
import pytest

NAMES = ("pixel-aniso", "lean", "vmf", "tsl", "reference")
RENDER = """
import sys
import numpy as np
import warp as wp
flags = sys.argv[2]
wp.config.cpu_compiler_flags = wp.config.cpu_compiler_flags.replace("-march=native", flags)
from metrics.kernels.launch import Launcher
from sequences import load
from swimlab.render.catalogue import model_of, techniques
from swimlab.render.material import load_material
from swimlab.render.shot import Shot
sequence = load("road-drive").with_changes(size=(96, 54))
with Launcher() as launcher:
    shot = Shot(sequence, 3, load_material(sequence, launcher), model_of(sequence), 16, launcher)
    pictures = {}
    for name in sys.argv[3].split(","):
        technique = techniques()[name]
        settings = technique.settings(**({"size": 128} if name == "tsl" else {}))
        pictures[name] = technique.render(shot, settings).rgba
np.savez(sys.argv[1], **pictures)
"""


def rendered(folder, flags):
    """Pictures by technique, by kernels that are built with these flags, which Warp's cache tells apart."""
    script, file = folder / "render.py", folder / f"{flags[-6:]}.npz"
    script.write_text(RENDER, encoding="utf-8")
    words = [sys.executable, str(script), str(file), flags, ",".join(NAMES)]
    subprocess.run(words, check=True, capture_output=True)
    with np.load(file) as pictures:
        return dict(pictures)


@pytest.mark.may_skip("the plain vectors that it compares with are those of x86-64")
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="compares builds for x86-64 processors")
def test_the_widest_vectors_and_the_plainest_agree(tmp_path, tolerance):
    native, plain = (rendered(tmp_path, flags) for flags in ("-march=native", "-target-cpu x86-64-v2"))
    for name in NAMES:
        rms = np.sqrt(np.mean((native[name] - plain[name]) ** 2) / np.mean(native[name] ** 2))
        assert rms <= tolerance("another processor"), name
