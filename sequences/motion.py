"""What a motion is: the rule by which the frames of a sequence differ."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from .scene import Sun
from .table import Table
from .view import View

if TYPE_CHECKING:
    from .sequence import Sequence


class Motion(Table):
    """A rule that gives the view of every frame. A file in `motions` with one subclass adds a motion."""

    kind: str
    """Name of the motion in a sequence file; a subclass narrows it to one literal with that default."""

    @abstractmethod
    def view(self, sequence: Sequence, t: int) -> View:
        """View of frame `t`. Any whole number has one; -1 is where frame 0 is said to come from."""

    def sun(self, sequence: Sequence, t: int) -> Sun:
        """The sun of frame `t`: the scene's, unless the motion moves it."""
        return sequence.scene.sun

    @property
    def uniform_velocity(self) -> tuple[float, float] | None:
        """How far all of the picture moves in a frame, px right and down; None if not all moves alike."""
        return None

    @property
    def resizes(self) -> bool:
        """Whether frames differ in size."""
        return False
