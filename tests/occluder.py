"""A square that moves over a background, each with a texture glued to it."""

import numpy as np

from metrics.synthetic import centres, texture


class Occluder:
    def __init__(self, behind, before, size, half=24):
        """behind, before: px a frame. size: of the square picture, px. half: of the square's side, px."""
        self.half = half
        self.speeds, self.textures = (behind, before), [texture(seed, mean=2.0) for seed in (21, 22)]
        self.x, self.y = np.broadcast_arrays(*centres(size, size))

    def hidden(self, t):
        (dx, dy) = self.speeds[1]
        across, along = self.x - 30 - dx * t, self.y - 75 - dy * t
        return ((np.abs(across) < self.half) & (np.abs(along) < self.half))[..., None]

    def frame(self, t):
        moved = ((self.x - dx * t, self.y - dy * t) for dx, dy in self.speeds)
        back, front = (texture.at(*place) for texture, place in zip(self.textures, moved, strict=True))
        return np.where(self.hidden(t), front, back)

    def motion(self, t):
        return np.where(self.hidden(t), self.speeds[1], self.speeds[0])
