"""One frame to render: everything that the techniques share, set up once."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp

from sequences import Sequence, View
from swimlab.brdf import Brdf
from swimlab.kernels.packet import plain_packet
from swimlab.kernels.structs import Grid, Sun
from swimlab.launch import Launcher
from swimlab.mesh import Mesh, road_mesh
from swimlab.texture import MipChain
from swimlab.triangles import Triangles, on_screen, screen_projection


@dataclass(frozen=True)
class Shot:
    """A frame of a sequence before any technique has touched it.

    samples: the reference's samples a pixel, n x n.
    brdf: the scene's reflectance model.
    """

    sequence: Sequence
    frame: int
    material: MipChain
    brdf: Brdf
    samples: int
    launcher: Launcher

    @cached_property
    def view(self) -> View:
        """Where the frame's samples lie."""
        return self.sequence.view(self.frame)

    @cached_property
    def mesh(self) -> Mesh:
        """The road about this frame's eye."""
        return road_mesh(self.sequence.scene.road, self.view.camera)

    @cached_property
    def triangles(self) -> Triangles:
        """The road on the screen."""
        width, height = self.sequence.size
        return on_screen(self.launcher, self.mesh, screen_projection(self.view.camera, height, width))

    @property
    def shade_packet(self) -> wp.Function:
        """The shading of a packet of samples: native on the CPU where the model has such a form, else the plain one."""
        if self.launcher.device == "cpu" and self.brdf.native is not None:
            return self.brdf.native
        return plain_packet(self.brdf.evaluate)

    @cached_property
    def sun(self) -> Any:
        """The light, as kernels take it (a Sun)."""
        sun: Any = Sun()
        sun.direction = wp.vec3(*self.sequence.scene.sun.direction)
        sun.diffuse = self.sequence.scene.sun.diffuse
        return sun

    def grid(self, n: int = 1, *, jittered: bool = False) -> Any:
        """The frame's sample grid (a Grid) with n x n cells a pixel."""
        view = self.view
        grid: Any = Grid()
        grid.origin = wp.vec2d(*view.origin)
        grid.pitch = wp.vec2d(view.pitch[0] / n, view.pitch[1] / n)
        grid.width, grid.height = view.width * n, view.height * n
        grid.jittered, grid.seed = int(jittered), int(np.uint32(self.sequence.seed).view(np.int32))
        return grid
