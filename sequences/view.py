"""A view: what one frame looks at, and at which places it is sampled."""

from dataclasses import dataclass

from .camera import Camera


@dataclass(frozen=True, slots=True)
class View:
    """A grid of samples over the fixed projection of a camera.

    The base image of a sequence is W by H pixels, j down, with the principal point at its middle. Cell
    (i, j) of the grid has its centre in base-image pixels at
    `(origin[0] + (i + 1/2) * pitch[0], origin[1] + (j + 1/2) * pitch[1])`.
    """

    width: int
    """Cells across."""
    height: int
    """Cells down."""
    origin: tuple[float, float]
    """Upper left corner of the grid in base-image pixels."""
    pitch: tuple[float, float]
    """Size of a cell in base-image pixels."""
    camera: Camera
    """The camera at this frame."""
