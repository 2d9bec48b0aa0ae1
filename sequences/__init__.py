"""What is rendered, as plain data: a road, a camera, and how the frames of a clip differ.

A sequence is a TOML file. `load` reads one, from the library or of your own, and names every mistake in it
at once; `schema` describes the format to an editor. `Sequence.view` gives the grid of samples of a frame.
`sequences.asphalt` makes the maps that the library's roads are surfaced with. Nothing here renders.
"""

from .camera import Camera
from .display import Bloom, Display
from .load import library, load, schema
from .motion import Motion
from .motions import MOTIONS
from .problems import SequenceError
from .scene import Material, Posts, Road, Scene, Sun, Wires
from .sequence import Sequence
from .view import View
from .viewing import Viewing

__all__ = [
    "MOTIONS",
    "Bloom",
    "Camera",
    "Display",
    "Material",
    "Motion",
    "Posts",
    "Road",
    "Scene",
    "Sequence",
    "SequenceError",
    "Sun",
    "View",
    "Viewing",
    "Wires",
    "library",
    "load",
    "schema",
]
