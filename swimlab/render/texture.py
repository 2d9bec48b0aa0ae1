"""Mip chains on the device."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from metrics.kernels.launch import Launcher
from swimlab.render.kernels.sampling import HALVE
from swimlab.render.kernels.structs import Chain


@dataclass(frozen=True)
class MipChain:
    """All levels of a texture, from full size down to 1x1, packed one after another in `texels`.

    `shape` is a Chain: it tells kernels the sizes and offsets; row 0 of a level is v = 0.
    """

    texels: Any
    shape: Any

    @property
    def floats(self) -> int:
        """Floats of a texel."""
        return int(self.texels.dtype._length_)

    @staticmethod
    def allocate(launcher: Launcher, *, width: int, height: int, dtype: Any, clamps: bool) -> "MipChain":
        """An empty chain; width and height are powers of two."""
        levels = max(width, height).bit_length()
        sizes = [max(width >> level, 1) * max(height >> level, 1) for level in range(levels)]
        shape: Any = Chain()
        shape.width, shape.height, shape.levels, shape.clamps = width, height, levels, int(clamps)
        shape.offsets = launcher.array(np.concatenate([[0], np.cumsum(sizes)[:-1]]), wp.int32)
        return MipChain(texels=launcher.empty(sum(sizes), dtype), shape=shape)

    def reduce(self, launcher: Launcher) -> None:
        """Fill every level from level 0 by 2x2 means."""
        for level in range(1, self.shape.levels):
            size = (max(self.shape.height >> level, 1), max(self.shape.width >> level, 1))
            launcher.launch(HALVE[self.texels.dtype], size, [level, self.shape, self.texels])
