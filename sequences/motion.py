"""What a motion is: the rule by which the frames of a sequence differ."""

from abc import abstractmethod
from typing import Protocol

from .camera import Camera
from .scene import Scene, Sun
from .table import Table
from .view import View


class Start(Protocol):
    """What a motion starts from: the sequence as its file gives it. fps: frames a second. size: width, height, px."""

    @property
    def frames(self) -> int: ...
    @property
    def fps(self) -> float: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def scene(self) -> Scene: ...


class Motion(Table):
    """A rule that gives the view of every frame. A file in `motions` with one subclass adds a motion."""

    kind: str
    """Name of the motion in a sequence file; a subclass narrows it to one literal with that default."""

    @abstractmethod
    def view(self, sequence: Start, t: int) -> View:
        """View of frame `t`. Any whole number has one; -1 is where frame 0 is said to come from."""

    def sun(self, sequence: Start, t: int) -> Sun:
        """The sun of frame `t`: the scene's, unless the motion moves it."""
        return sequence.scene.sun

    @property
    def uniform_velocity(self) -> tuple[float, float] | None:
        """How far all of the picture moves in a frame, px right and down; None if it does not move as one."""
        return None

    @property
    def resizes(self) -> bool:
        """Whether frames differ in size."""
        return False
