"""`swimlab info` on frames whose values cannot be measured."""

import json

import numpy as np
import pytest

from swimlab.runs.frames import write_channels


def write(folder, pixels, channels, bad=None):
    """Three frames; the middle one has a bad value."""
    for t in range(3):
        frame = np.full((16, 20, len(channels)), pixels, np.float32)
        if bad is not None and t == 1:
            frame[5, 7, -1] = bad
        write_channels(folder / f"f.{t:04d}.exr", frame, channels, half=False, metadata={})


@pytest.mark.parametrize(
    ("bad", "words"), [(np.nan, "1 NaN or infinite values"), (np.inf, "1 NaN or"), (3e12, "values of up to 3e+12")]
)
@pytest.mark.parametrize("channels", [("R", "G", "B"), ("Y",), ("beauty.R", "beauty.G", "beauty.B")], ids=str)
def test_values_that_measuring_refuses_are_bad_frames(swimlab, tmp_path, bad, words, channels):
    write(tmp_path, 0.5, channels, bad)
    code, out, _ = swimlab("info", "f.####.exr")
    assert code == 2
    assert "bad frame   f.0001.exr: holds 1 " in out
    assert words in out
    assert "at pixel x 7, y 5" in out
    code, out, _ = swimlab("info", "f.####.exr", "--json")
    assert code == 2
    assert len(json.loads(out)["bad frames"]) == 1
    code, _, err = swimlab("measure", "--test", "f.####.exr")
    assert code == 2
    assert "f.0001.exr: holds 1" in err


@pytest.mark.parametrize("channels", [("motion.X", "motion.Y"), ("Z",), ("depth.Z",)], ids=str)
def test_vectors_and_depth_may_be_unknown(swimlab, tmp_path, channels):
    write(tmp_path, 0.5, channels, np.inf)
    assert swimlab("info", "f.####.exr")[0] == 0


def test_good_values_are_good(swimlab, tmp_path):
    write(tmp_path, 60000.0, ("R", "G", "B"))
    assert swimlab("info", ".")[0] == 0
