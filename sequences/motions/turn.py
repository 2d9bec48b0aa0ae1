"""turn: the camera yaws where it stands."""

from typing import Literal

from pydantic import Field

from ..motion import Motion, Start
from ..table import Real
from ..view import View


class Turn(Motion):
    """The camera turns about the vertical: at frame t its yaw has grown by speed t / fps degrees."""

    kind: Literal["turn"] = Field("turn", description="the camera yaws")
    speed: Real = Field(20.0, ge=-3600, le=3600, description="degrees/s to the right; negative turns left")

    def view(self, sequence: Start, t: int) -> View:
        """The base grid of a camera that is turned by `speed * t / fps` degrees."""
        width, height = sequence.size
        yaw = sequence.camera.yaw + self.speed * t / sequence.fps
        camera = sequence.camera.model_copy(update={"yaw": yaw})
        return View(width, height, origin=(0.0, 0.0), pitch=(1.0, 1.0), camera=camera)
