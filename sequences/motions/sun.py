"""sun: the sun sweeps over a picture that stands still."""

from typing import Literal

from pydantic import Field

from ..motion import Motion, Start
from ..scene import Sun
from ..table import Real
from ..view import View


class SunSweep(Motion):
    """Azimuth and elevation of the sun grow steadily: nothing moves, but the light changes."""

    kind: Literal["sun"] = Field("sun", description="the sun sweeps, the picture stands still")
    azimuth_speed: Real = Field(60.0, ge=-3600, le=3600, description="degrees/s clockwise")
    elevation_speed: Real = Field(0.0, ge=-3600, le=3600, description="degrees/s upwards")

    def view(self, sequence: Start, t: int) -> View:
        """The base grid, in every frame."""
        width, height = sequence.size
        return View(width, height, origin=(0.0, 0.0), pitch=(1.0, 1.0), camera=sequence.camera)

    def sun(self, sequence: Start, t: int) -> Sun:
        """The scene's sun, turned by speeds * t / fps degrees; over the zenith it goes down on the other side."""
        start, seconds = sequence.scene.sun, t / sequence.fps
        angles = {
            "azimuth": start.azimuth + self.azimuth_speed * seconds,
            "elevation": start.elevation + self.elevation_speed * seconds,
        }
        return start.model_copy(update=angles)

    @property
    def uniform_velocity(self) -> tuple[float, float]:
        """None of the picture moves."""
        return 0.0, 0.0
