"""A camera that moves past a tilted wall: pictures, and clip-space positions now and before, as an engine has them."""

import numpy as np

from swimlab.runs.frames import write_channels

WIDTH, HEIGHT, COUNT = 128, 96, 8
_NORMAL, _DISTANCE = np.array([0.3, 0.2, 1.0]), -4.0
"""The wall: points of which _NORMAL . point = _DISTANCE; the camera looks along -z."""


def camera(t):
    """[4, 4]: from the world to clip space of OpenGL, y up; the camera drifts, turns and comes nearer."""
    turn = 0.006 * t
    view = np.eye(4)
    view[:3, :3] = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    view[:3, 3] = [-0.04 * t, 0.03 * t, 0.05 * t]
    focal, near, far = 1.4, 0.1, 100.0
    lens = np.zeros((4, 4))
    lens[0, 0], lens[1, 1] = focal * HEIGHT / WIDTH, focal
    lens[2, 2:] = (far + near) / (near - far), 2 * far * near / (near - far)
    lens[3, 2] = -1
    return lens @ view


def wall(t, size=(WIDTH, HEIGHT), jitter=(0.0, 0.0)):
    """[H, W, 4]: the points of the wall that the pixels of frame t see, shifted by a jitter in px right and down."""
    width, height = size
    y, x = np.indices((height, width)) + 0.5
    ndc = np.stack([2 * (x - jitter[0]) / width - 1, 1 - 2 * (y - jitter[1]) / height], axis=-1)
    ends = []
    for depth in (-1.0, 1.0):
        clip = np.concatenate([ndc, np.broadcast_to([depth, 1.0], ndc.shape)], axis=-1)
        world = clip @ np.linalg.inv(camera(t)).T
        ends.append(world[..., :3] / world[..., 3:])
    start, along = ends[0], ends[1] - ends[0]
    reach = (_DISTANCE - start @ _NORMAL) / (along @ _NORMAL)
    return np.concatenate([start + reach[..., None] * along, np.ones((height, width, 1))], axis=-1)


def ndc(points, t):
    """[..., 2]: where points are on the screen of frame t, -1..1, y up: clip space divided by w."""
    clip = points @ camera(t).T
    return clip[..., :2] / clip[..., 3:]


def to_px(place, size=(WIDTH, HEIGHT)):
    """[..., 2]: px right and down from the top left."""
    return (place * [0.5, -0.5] + 0.5) * size


def picture(t, size=(WIDTH, HEIGHT), jitter=(0.0, 0.0)):
    """[H, W, 3]: a smooth pattern painted on the wall."""
    x, y = np.moveaxis(wall(t, size, jitter)[..., :2], -1, 0)
    random = np.random.default_rng(3)
    kx, ky = random.uniform(-9, 9, (2, 12))
    phase = random.uniform(0, 6, 12)
    grey = np.cos(kx * x[..., None] + ky * y[..., None] + phase).sum(axis=2)
    return np.repeat(6 + grey[..., None], 3, axis=2)


def moved(t, size=(WIDTH, HEIGHT)):
    """[H, W, 2]: px that the wall seen in each pixel of frame t moved since the frame before, right and down."""
    points = wall(t, size)
    return to_px(ndc(points, t), size) - to_px(ndc(points, t - 1), size)


def write(folder, frames, channels=("R", "G", "B"), count=COUNT):
    """Write t -> [H, W, n] as 32-bit floats: 0000.exr and so on. Returns the folder."""
    for t in range(count):
        pixels = np.asarray(frames(t), np.float32)
        write_channels(folder / f"{t:04d}.exr", pixels, channels, half=False, metadata={})
    return folder
