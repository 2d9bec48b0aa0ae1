"""What is written and said does not depend on the order in which Python's sets happen to stand."""

import os
import subprocess
import sys

import numpy as np

from swimlab.runs.frames import write_channels


def test_scores_and_notes_are_the_same_for_any_hash_seed(tmp_path):
    """Vectors (1, 0) that are the same everywhere: readings with y flipped, and forward ones, fit equally well."""
    picture = np.random.default_rng(0).random((64, 100, 3), np.float32)
    for t in range(4):
        write_channels(tmp_path / f"f.{t}.exr", np.roll(picture, t, axis=1), tuple("RGB"), half=False, metadata={})
        vectors = np.zeros((64, 100, 2), np.float32) + np.float32([1, 0])
        write_channels(tmp_path / f"v.{t}.exr", vectors, tuple("XY"), half=False, metadata={})
    words = ["measure", "--test", "f.%d.exr", "--motion", "v.%d.exr", "--json"]
    said = []
    for seed in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-m", "swimlab", *words],
            cwd=tmp_path,
            env=os.environ | {"PYTHONHASHSEED": seed, "COLUMNS": "200"},
            capture_output=True,
            text=True,
            encoding="utf-8",
            check=True,
        )
        said.append((done.stdout.partition('"sequences"')[2], done.stderr))
    assert "residuals" in said[0][1]
    assert said[0] == said[1]
