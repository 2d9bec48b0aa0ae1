"""shift: the image slides by sub-pixel steps; nothing but the sample points changes."""

from typing import Annotated, Literal

from pydantic import Field

from ..motion import Motion, Start
from ..table import Real
from ..view import View

Step = Annotated[Real, Field(ge=-1e4, le=1e4)]


class Shift(Motion):
    """The whole image moves as one: frame t samples the base image at (i + 1/2 - t vx, j + 1/2 - t vy)."""

    kind: Literal["shift"] = Field("shift", description="the picture slides as one, by parts of a pixel a frame")
    velocity: tuple[Step, Step] = Field(
        (23 / 32, 19 / 32), description="motion of the picture's content, px a frame, right and down"
    )

    def view(self, sequence: Start, t: int) -> View:
        """The base grid moved by -t velocity, so that the content moves by +t velocity."""
        width, height = sequence.size
        origin = (-t * self.velocity[0], -t * self.velocity[1])
        return View(width, height, origin=origin, pitch=(1.0, 1.0), camera=sequence.camera)

    @property
    def uniform_velocity(self) -> tuple[float, float]:
        """The velocity: all of the picture moves as one."""
        return self.velocity
