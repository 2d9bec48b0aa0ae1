"""What motion vectors mean: their channels, unit, direction and axes. No standard names them, so presets do.

Sources: Blender: Cycles' `primitive_motion_vector` gives (previous - current, current - next) in raster px with y up as
Vector.X, Y, Z, W. Unity: URP's `CalcNdcMotionVectorFromCsPositions` gives current - previous in uv, y up in the picture
as it is read back (render targets are flipped where uv starts at the top). Nuke: VectorGenerator's manual: the
`backward` channels are the offsets at which the previous frame holds the current pixel, `forward` those of the next
frame, px with y up.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Unit = Literal["px", "ndc", "uv"]
Direction = Literal["backward", "forward"]
Vertical = Literal["down", "up"]
Preset = Literal["own", "blender", "unity", "nuke", "ndc", "uv"]

_PLAIN = (("motion.X", "motion.Y"), ("X", "Y"), ("x", "y"), ("U", "V"), ("u", "v"), ("R", "G"))


@dataclass(frozen=True)
class Convention:
    """How stored vectors become px, +x right and +y down.

    channels: pairs of channels, the first that a file has counts. unit: px; "ndc": the picture is 2 wide and high;
    "uv": it is 1 wide and high. direction: "backward": how far the surface seen in a pixel moved since the previous
    frame; "forward": how far it moves until the next one. y: which way the second channel is positive.
    scale: factors of x and y; -1 where vectors point to where the surface was.
    """

    channels: tuple[tuple[str, str], ...] = _PLAIN
    unit: Unit = "px"
    direction: Direction = "backward"
    y: Vertical = "down"
    scale: tuple[float, float] = (1.0, 1.0)

    def factors(self, size: tuple[int, int]) -> NDArray[np.float32]:
        """What stored (x, y) are multiplied with to be px right and down in pictures of a size (width, height)."""
        share = {"px": (1.0, 1.0), "ndc": (size[0] / 2, size[1] / 2), "uv": (float(size[0]), float(size[1]))}[self.unit]
        down = 1.0 if self.y == "down" else -1.0
        return np.array([share[0] * self.scale[0], down * share[1] * self.scale[1]], np.float32)


PRESETS: dict[str, Convention] = {
    "own": Convention(),
    "blender": Convention((("Vector.X", "Vector.Y"),), y="up", scale=(-1.0, -1.0)),
    "unity": Convention((("R", "G"), ("X", "Y"), ("x", "y")), unit="uv", y="up"),
    "nuke": Convention((("backward.u", "backward.v"),), y="up", scale=(-1.0, -1.0)),
    "nuke-forward": Convention((("forward.u", "forward.v"),), y="up", direction="forward"),
    "ndc": Convention(unit="ndc", y="up"),
    "uv": Convention(unit="uv"),
}
"""Every preset; `nuke` is `nuke-forward` where a file has no backward channels."""

_SIGNS = {
    "own": ("motion.X",),
    "blender": ("Vector.X", "Vector.Y"),
    "nuke": ("backward.u",),
    "nuke-forward": ("forward.u",),
}


def guess(channels: tuple[str, ...]) -> str | None:
    """The preset whose channel names a file has; None if none."""
    for name, signs in _SIGNS.items():
        if all(any(c == sign or c.endswith("." + sign) for c in channels) for sign in signs):
            return name
    return None
