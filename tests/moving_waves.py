"""Clips of waves that have moved to a place in each frame, as files."""

import numpy as np

from swimlab.runs.frames import write_channels

WIDTH, HEIGHT = 96, 64


def waves(place, seed):
    """[H, W, 3]: a band-limited picture moved to a place, rms 1."""
    random = np.random.default_rng(seed)
    y, x = np.indices((HEIGHT, WIDTH)) + 0.5
    kx, ky = random.uniform(-0.2, 0.2, (2, 16))
    angle = 2 * np.pi * ((x - place[0])[..., None] * kx + (y - place[1])[..., None] * ky) + random.uniform(0, 6, 16)
    return np.repeat(np.cos(angle).sum(axis=2)[..., None] * np.sqrt(2 / 16), 3, axis=2)


def write_clips(folder, places):
    """Folders ref, glued and mv (backward vectors), a file a frame."""
    for t, place in enumerate(places):
        write_picture(folder / "ref" / f"{t:04d}.exr", waves(place, 1))
        write_picture(folder / "glued" / f"{t:04d}.exr", waves(place, 1) + 0.1 * waves(place, 2))
        write_step(folder / "mv" / f"{t:04d}.exr", place - places[t - 1])


def write_picture(path, pixels):
    """[H, W, 3] about 3, which is grey."""
    write_channels(path, (3 + pixels).astype(np.float32), ("R", "G", "B"), half=False, metadata={})


def write_step(path, step):
    """One vector (x, y), px, everywhere."""
    field = np.broadcast_to(np.float32(step), (HEIGHT, WIDTH, 2))
    write_channels(path, field, ("motion.X", "motion.Y"), half=False, metadata={})
