"""A surface of waves, exact at any place, frames in which it moves, and motions of it."""

import numpy as np

from swimlab.footage.motion import UniformMotion

HEIGHT, WIDTH, COUNT = 96, 128, 16


def surface(dx=0.0, dy=0.0, seed=1):
    """[H, W, 3]: waves of up to .2 cycles/px, exact at any place: rms .15 about .5."""
    random = np.random.default_rng(seed)
    frequency, angle, phase = random.uniform(0.01, 0.2, 40), *random.uniform(0, 2 * np.pi, (2, 40))
    across = np.exp(2j * np.pi * frequency * np.cos(angle) * (np.arange(WIDTH)[:, None] - dx) + 1j * phase)
    down = np.exp(2j * np.pi * frequency * np.sin(angle) * (np.arange(HEIGHT)[:, None] - dy))
    waves = (down @ across.T).real
    return np.repeat(np.maximum(0.5 + 0.15 * waves / np.sqrt(20), 0.01)[..., None], 3, axis=2)


def moved(velocity, count=COUNT, noise=0.0):
    """Frames of the surface that moves by (dx, dy) px a frame, with white noise of its own in each."""
    return [
        surface(*np.multiply(velocity, t)) + noise * np.random.default_rng(t).standard_normal((HEIGHT, WIDTH, 1))
        for t in range(count)
    ]


class Vectors(UniformMotion):
    """Motion of fields [H, W, 2], one a frame, sampled at the nearest pixel."""

    def __init__(self, fields):
        super().__init__((1.0, 0.0), (HEIGHT, WIDTH))
        self._fields = fields

    def back(self, points, start, stop):
        for index in range(start, stop, -1):
            row, column = np.clip(np.rint(points), 0, [[HEIGHT - 1], [WIDTH - 1]]).astype(int)
            points = points - self._fields[index][row, column].T[::-1]
        return points

    def moved(self, start, stop):
        return self._fields[start]

    def variants(self):
        return {}


def uniform(velocity):
    return UniformMotion(velocity, (HEIGHT, WIDTH))


def fields(velocity, count=COUNT):
    return [np.broadcast_to(velocity, (HEIGHT, WIDTH, 2)).astype(float).copy() for _ in range(count)]
