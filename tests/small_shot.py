"""A small shot of noise that slides by 1 px a frame, and two builds that add noise of their own."""

from pathlib import Path

import numpy as np

from swimlab.runs.frames import write_channels

SIDE, COUNT = 48, 3
SHOT = """
version = 1
name = "corridor"
[reference]
frames = "ref"
colorspace = "linear"
[motion]
velocity = [1.0, 0.0]
[builds.one]
frames = "one"
[builds.two]
frames = "two"
"""


def write_picture(path: Path, pixels: np.ndarray) -> None:
    """A frame [H, W, 3] of linear radiance."""
    write_channels(path, pixels.astype(np.float32), ("R", "G", "B"), half=False, metadata={})


def write_shot(folder: Path) -> Path:
    """Write the frames and corridor.toml; return the latter."""
    scene = np.random.default_rng(0).standard_normal((SIDE, SIDE + COUNT, 3))
    for t in range(COUNT):
        true = 0.5 + 0.05 * scene[:, COUNT - t : COUNT - t + SIDE]
        for place, name in enumerate(("ref", "one", "two")):
            noise = 0.01 * place * np.random.default_rng(10 * place + t).standard_normal(true.shape)
            write_picture(folder / name / f"{t}.exr", true + noise)
    path = folder / "corridor.toml"
    path.write_text(SHOT, encoding="utf-8")
    return path
