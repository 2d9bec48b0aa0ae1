"""One frame to render: everything that all techniques share, set up once."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import warp as wp

from metrics.kernels.launch import Launcher
from sequences import Sequence, View
from swimlab.render.brdf import Model
from swimlab.render.inputs import Inputs
from swimlab.render.kernels.packet import plain_packet
from swimlab.render.kernels.shading import in_local_frame
from swimlab.render.kernels.structs import Grid, Sun
from swimlab.render.material import Material
from swimlab.render.mesh import Mesh, scene_mesh
from swimlab.render.triangles import Triangles, on_screen, screen_projection

Made = TypeVar("Made")


class Kept:
    """What was made last under some names, and what of, for frames that need the same."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[Any, Any]] = {}

    def get(self, name: str, of: Any, make: Callable[[], Made]) -> Made:
        """What was made of something equal, or what `make` makes now."""
        last = self._last.get(name)
        made: Made = last[1] if last is not None and last[0] == of else make()
        self._last[name] = of, made  # the same again is found sooner than what is equal
        return made


@dataclass(frozen=True)
class Shot:
    """A frame of a sequence before any technique has touched it.

    samples: the reference's samples a pixel, n x n.
    model: the scene's reflectance model.
    thinnest: px; slivers under it are not drawn (see `swimlab.render.triangles.on_screen`).
    """

    sequence: Sequence
    frame: int
    material: Material
    model: Model
    samples: int
    launcher: Launcher
    thinnest: float = 0.0
    _kept: Kept = field(default_factory=Kept, repr=False, compare=False)

    def at(self, frame: int) -> "Shot":
        """Another frame; the mesh and its set-up are kept where the eye stands still."""
        return self if frame == self.frame else replace(self, frame=frame)

    @cached_property
    def view(self) -> View:
        """Where the frame's samples lie."""
        return self.sequence.view(self.frame)

    @cached_property
    def mesh(self) -> Mesh:
        """Road and wires about this frame's eye."""
        scene, camera = self.sequence.scene, self.view.camera
        return self._kept.get("mesh", (scene, camera), lambda: scene_mesh(scene, camera))

    @cached_property
    def triangles(self) -> Triangles:
        """The mesh on the screen."""
        width, height = self.sequence.size
        thinnest = self.thinnest * max(self.view.pitch)

        def make() -> Triangles:
            projection = screen_projection(self.view.camera, height, width)
            return on_screen(self.launcher, self.mesh, projection, thinnest=thinnest)

        of = self.sequence.scene, self.view.camera, width, height, thinnest, self.launcher
        return self._kept.get("triangles", of, make)

    def kept(self, name: str, of: Any, make: Callable[[], Made]) -> Made:
        """What a technique makes under a name of its own, or made for an earlier shot of something equal."""
        return self._kept.get(name, of, make)

    def inputs(self, preferred: Inputs) -> Inputs:
        """The preferred inputs, or their `otherwise` where their own lobe does not fit the scene's model."""
        fits = self.model.slopes_are_gaussian and not self.material.twisted
        return preferred if fits or preferred.otherwise is None else preferred.otherwise

    def shade_packet(self, inputs: Inputs, width: int) -> wp.Function:
        """The function that shades a packet of texels of `width` floats: on the CPU the native form if any."""
        on_cpu = self.launcher.device == "cpu"
        if inputs.native is not None and on_cpu:
            return inputs.native
        if inputs.reflect is not None:
            return plain_packet(inputs.reflect, width)
        if on_cpu and self.model.native is not None and width == 8:
            return self.model.native
        return plain_packet(in_local_frame(self.model.evaluate, width), width)

    @cached_property
    def sun(self) -> Any:
        """The light, as kernels take it (a Sun)."""
        light = self.sequence.sun(self.frame)

        def make() -> Any:
            sun: Any = Sun()
            sun.direction = wp.vec3(*light.direction)
            sun.diffuse = light.diffuse
            return sun

        return self._kept.get("sun", light, make)

    def grid(self, n: int = 1, *, jittered: bool = False) -> Any:
        """The frame's sample grid (a Grid) with n x n cells a pixel."""
        view = self.view
        grid: Any = Grid()
        grid.origin = wp.vec2d(*view.origin)
        grid.pitch = wp.vec2d(view.pitch[0] / n, view.pitch[1] / n)
        grid.width, grid.height = view.width * n, view.height * n
        grid.jittered, grid.seed = int(jittered), _signed(self.sequence.seed)
        return grid


def _signed(seed: int) -> int:
    """The 32 bits of a seed as the kernels' signed number."""
    return seed - (1 << 32) if seed >= 1 << 31 else seed
