"""Every kernel of the measures in Warp's debug mode, the only one that checks bounds, by its plain form."""

import subprocess
import sys

DEBUG = """
import numpy as np
import warp as wp

wp.config.mode = "debug"

from metrics import Clip, measure
from metrics.kernels.forms import Form

Form.on = lambda self, device: self.plain

height, width, count = 41, 67, 4
random = np.random.default_rng(0)
frames = random.random((2, count, height, width, 3), np.float32)
# Motion reaches far beyond the picture, and places with it.
motion = random.uniform(-0.05, 0.05, (count, height, width, 2)).astype(np.float32)
motion[:, :, 50:] = random.uniform(-12, 12, (count, height, 17, 2))
motion[1, 0, 0] = 1e9
motion[2, 5, 60] = -3e4
covered = np.ones((count, height, width), np.float32)
covered[:, :, :3] = random.random((count, height, 3))
test = Clip(frames[0].__getitem__, count, motion=motion.__getitem__, coverage=covered.__getitem__)
found = measure(test, Clip(frames[1].__getitem__, count), threads=1)
assert found.scores["measured.fraction"] > 0 and found.scores["edges.fraction"] > 0
assert all(np.isfinite(value) for value in found.scores.values())
"""


def test_kernels_stay_in_their_bounds(tmp_path):
    (tmp_path / "debug.py").write_text(DEBUG, encoding="utf-8")
    words = [sys.executable, str(tmp_path / "debug.py")]
    done = subprocess.run(words, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
