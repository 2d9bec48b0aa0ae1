"""A sequence: all there is to know about a clip before it is rendered."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, ValidationError

from .camera import Camera
from .display import Display
from .motions import MOTIONS, AnyMotion
from .names import LONGEST, NAME
from .problems import SequenceError, describe
from .scene import Scene, Sun
from .table import Real, Table, Whole
from .view import View
from .viewing import Viewing

Side = Annotated[Whole, Field(ge=8, le=16384)]


class Sequence(Table):
    """A sequence file, version 1. Lengths are metres and angles degrees, unless said."""

    version: Literal[1] = Field(description="version of the file format: 1")
    name: str = Field(
        pattern=NAME,
        max_length=LONGEST,
        description="name of the sequence: letters, digits, dot, dash, underscore; it names a folder",
    )
    frames: Whole = Field(32, ge=1, le=1_000_000, description="number of frames")
    fps: Real = Field(60.0, gt=0, le=1e5, description="frames a second")
    size: tuple[Side, Side] = Field((640, 360), description="width and height in pixels (8..16384)")
    seed: Whole = Field(0, ge=0, lt=2**32, description="seed of every random choice: sample patterns, made maps")
    scene: Scene = Field(default=Scene(), description="what stands still")
    camera: Camera = Field(default=Camera(), description="where from it is seen")
    motion: AnyMotion = Field(default=MOTIONS["shift"](kind="shift"), description="by what the frames differ")
    viewing: Viewing = Field(default=Viewing(), description="how the frames are looked at")
    display: Display = Field(default=Display(), description="how radiance is shown, for the display domain")
    techniques: dict[str, dict[str, Any]] = Field({}, description="settings of techniques, by name")

    _folder: Path = PrivateAttr(default=Path())

    def model_post_init(self, context: Any, /) -> None:
        """Take the folder of the sequence file from the validation context, if that has one."""
        self._folder = (context or {}).get("folder", Path())

    @property
    def folder(self) -> Path:
        """Folder that map files are relative to: where the sequence file lies, or the working folder."""
        return self._folder

    def view(self, t: int) -> View:
        """View of frame `t`; any whole number has one, -1 too."""
        return self.motion.view(self, t)

    def sun(self, t: int) -> Sun:
        """The sun of frame `t`."""
        return self.motion.sun(self, t)

    def map_path(self, value: str) -> Path | None:
        """File that a map of the material names, relative to `folder`; None for a made map."""
        return None if value.startswith("made:") else self._folder / value

    def with_changes(self, **changes: Any) -> Self:
        """A checked copy in which each given key has the given value, as in `with_changes(size=(64, 36))`.

        A table replaces the whole table. Raises SequenceError with every problem.
        """
        try:
            return self.model_validate({**self.model_dump(), **changes}, context={"folder": self._folder})
        except ValidationError as error:
            raise SequenceError(describe(error, type(self))) from None
