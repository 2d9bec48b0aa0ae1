"""A shot of a picture that turns, with a cut, vectors, depth and viewing, and a build that adds noise."""

from pathlib import Path

import numpy as np
from small_shot import write_picture

from metrics.synthetic import Rotation, texture
from swimlab.runs.frames import write_channels

SHOT = """
version = 1
name = "carousel"
[reference]
frames = "ref"
colorspace = "linear"
[motion]
frames = "motion"
[depth]
frames = "depth"
[viewing]
pixels_per_degree = 40.0
[builds.noisy]
frames = "noisy"
"""


def write_turning_shot(folder: Path, *, count: int, cut: int, side: int) -> Path:
    """Write the frames and carousel.toml; return the latter. cut: the frame that begins the second shot."""
    turn = Rotation(1.0, (side, side))
    depth = np.broadcast_to(np.linspace(1, 30, side)[:, None, None], (side, side, 1))
    for t in range(count):
        name = f"{t:04d}.exr"
        true = texture(int(t >= cut), mean=2.0).at(*turn.surface(t))
        noise = 0.05 * np.random.default_rng(t).standard_normal(true.shape)
        write_picture(folder / "ref" / name, true)
        write_picture(folder / "noisy" / name, true + noise)
        motion = turn.motion(t).astype(np.float32)
        write_channels(folder / "motion" / name, motion, ("motion.X", "motion.Y"), half=False, metadata={})
        write_channels(folder / "depth" / name, depth.astype(np.float32), ("Z",), half=False, metadata={})
    path = folder / "carousel.toml"
    path.write_text(SHOT, encoding="utf-8")
    return path
