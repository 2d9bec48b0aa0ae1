"""scale: every frame has its own size and the same field of view."""

import math
from typing import Literal

from pydantic import Field

from ..motion import Motion, Start
from ..table import Real
from ..view import View


class Scale(Motion):
    """The size of the frames goes geometrically from `from` to `to` times the size of the sequence."""

    kind: Literal["scale"] = Field("scale", description="the size of the frames changes, their field of view stays")
    start: Real = Field(1.0, alias="from", gt=0, le=16, description="size factor of the first frame (0..16)")
    end: Real = Field(0.0625, alias="to", gt=0, le=16, description="size factor of the last frame (0..16)")

    def factor(self, frames: int, t: int) -> float:
        """Size factor of frame `t` of `frames`: from (to/from)^(t/(frames-1)). A single frame has `from`."""
        return self.start * math.pow(self.end / self.start, t / max(frames - 1, 1))

    def view(self, sequence: Start, t: int) -> View:
        """A grid over all of the base image, of round(size * factor) cells, halves up, at least one."""
        factor = self.factor(sequence.frames, t)
        width, height = (max(1, math.floor(full * factor + 0.5)) for full in sequence.size)
        pitch = (sequence.size[0] / width, sequence.size[1] / height)
        return View(width, height, origin=(0.0, 0.0), pitch=pitch, camera=sequence.camera)

    @property
    def resizes(self) -> bool:
        """True: that is what it is for."""
        return True
