"""drive: the camera goes along the road."""

from typing import Literal

from pydantic import Field

from ..motion import Motion, Start
from ..table import Real
from ..view import View


class Drive(Motion):
    """The camera moves straight along y: at frame t it has gone speed t / fps metres."""

    kind: Literal["drive"] = Field("drive", description="the camera goes along the road")
    speed: Real = Field(6.0, ge=-1e4, le=1e4, description="m/s along the road; negative goes backwards")

    def view(self, sequence: Start, t: int) -> View:
        """The base grid of a camera that is `speed * t / fps` metres further."""
        width, height = sequence.size
        distance = sequence.camera.distance + self.speed * t / sequence.fps
        camera = sequence.camera.model_copy(update={"distance": distance})
        return View(width, height, origin=(0.0, 0.0), pitch=(1.0, 1.0), camera=camera)
