"""Vertex lighting: shade at the mesh's vertices and interpolate, the lowest frequency of evaluation.

"Generally, vertex evaluation is lowest frequency, while pixel is at a higher frequency. Not the case for low
resolution" (Sloan & Baker). Light at the vertices does not depend on the size of the frame, while pixel shading filters
its inputs further the smaller the frame is. On `road-scale` vertex lighting is worse than pixel-aniso down to a quarter
of 640x360, and nearer to the reference from 113x64 on. Highlights are smeared over quads, but stick to the road.
"""

from dataclasses import dataclass
from math import log2
from typing import Annotated, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from pydantic import Field

from metrics.kernels.launch import Launcher, OnRows, Scratch
from metrics.kernels.making import made_once
from swimlab.render.inputs import BOX
from swimlab.render.kernels.raster import sample_position, see_row
from swimlab.render.kernels.sampling import trilinear
from swimlab.render.kernels.set_up import find_sampled
from swimlab.render.kernels.shading import in_local_frame, shade_with
from swimlab.render.kernels.structs import TEXELS, Chain, Edges, Grid, Planes, Sun, Surface
from swimlab.render.mesh import Doubles, Mesh, scene_mesh
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, on_host, to_image
from swimlab.render.triangles import Triangles, screen_projection, to_set_up

Quads = Annotated[int, Field(ge=1, le=256)]


class VertexSettings(Settings):
    """How finely the road is cut for lighting; the scene's own tessellation only gives its shape."""

    quads: tuple[Quads, Quads] = Field((16, 16), description="quads of a segment, across and along (1..256)")


@made_once
def shade_vertices(reflect: wp.Function, width: int) -> wp.Kernel:
    """The kernel that shades one vertex a thread, from inputs at one level of detail, texels of `width` floats."""
    texel_type = TEXELS[width]
    shade = shade_with(reflect, width)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        uv: wp.array(dtype=wp.vec2d),
        positions: wp.array(dtype=wp.vec3d),
        slope: wp.array(dtype=wp.float64),
        lod: wp.float32,
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        colours: wp.array(dtype=wp.vec3d),
    ):
        k = wp.tid()
        surface = Surface()
        surface.position = positions[k]
        surface.slope = wp.float32(slope[k])
        colours[k] = wp.vec3d(shade(trilinear(texels, chain, lod, wp.vec2(uv[k])), surface, sun))

    return kernel


@wp.func
def colour_at(planes: Planes, p: wp.vec2d) -> wp.vec4:
    """The colour that the planes carry in the place of positions, where an image point sees them."""
    values = planes @ wp.vec3d(p[0], p[1], wp.float64(1.0))
    w = wp.float64(1.0) / values[0]
    colour = wp.vec3(wp.float32(values[3] * w), wp.float32(values[4] * w), wp.float32(values[5] * w))
    return wp.vec4(wp.max(colour[0], 0.0), wp.max(colour[1], 0.0), wp.max(colour[2], 0.0), 1.0)


@wp.kernel(enable_backward=False)
def interpolate(
    first_row: wp.int32,
    grid: Grid,
    edges: wp.array(dtype=Edges),
    planes: wp.array(dtype=Planes),
    bounds: wp.array(dtype=wp.vec2d),
    picture: wp.array2d(dtype=wp.vec4),
    visible: wp.array2d(dtype=wp.int32),
):
    """Fill rows of pixels with the colours that the planes carry, one thread a row; `visible` is scratch."""
    j = first_row + wp.tid()
    row = wp.tid() % visible.shape[0]
    see_row(row, j, grid, edges, planes, bounds, visible)
    for i in range(grid.width):
        colour = wp.vec4(0.0, 0.0, 0.0, 0.0)
        triangle = visible[row, i]
        if triangle >= 0:
            colour = colour_at(planes[triangle], sample_position(grid, i, j))
        picture[j, i] = colour


@dataclass(frozen=True)
class Vertices:
    """A mesh before an eye, and what of it kernels take, on the device.

    points: [N], homogeneous image px. drawn: [M], true: any triangle may be.
    """

    mesh: Mesh
    points: Any
    uv: Any
    positions: Any
    slope: Any
    corners: Any
    drawn: Any

    @staticmethod
    def of(launcher: Launcher, mesh: Mesh, projection: Doubles) -> "Vertices":
        """The vertices under a projection (see `screen_projection`)."""
        return Vertices(
            mesh,
            points=launcher.view(mesh.positions @ projection.T, wp.vec3d),
            uv=launcher.view(mesh.uv, wp.vec2d),
            positions=launcher.view(mesh.positions, wp.vec3d),
            slope=launcher.view(mesh.slope, wp.float64),
            corners=launcher.view(mesh.triangles, wp.vec3i),
            drawn=launcher.filled(len(mesh.triangles), wp.bool, True),
        )

    def sampled(self, launcher: Launcher, grid: Any) -> NDArray[np.bool_]:
        """[M], the triangles that samples of a grid that is not jittered can see.

        Not those that face away, nor those that lie between the grid's rows or beyond them.
        """
        count = len(self.mesh.triangles)
        found = launcher.empty(count, wp.bool)
        launcher.launch(find_sampled, count, [self.points, self.positions, self.corners, grid, found])
        return on_host(found)

    def to_shade(self, shot: Shot, lod: float) -> tuple[Any, Any]:
        """Radiance at each vertex, [N], linear RGB, and the launch that finds it.

        It is from the maps' box chain at a level of detail.
        """
        launcher, chain, count = shot.launcher, shot.material.chain(shot.inputs(BOX)), len(self.mesh.positions)
        kernel = shade_vertices(in_local_frame(shot.model.evaluate, chain.floats), chain.floats)
        colours = launcher.empty(count, wp.vec3d)
        inputs = [self.uv, self.positions, self.slope, lod, chain.texels, chain.shape, shot.sun, colours]
        return colours, launcher.record(kernel, count, inputs)

    def to_set_up(self, launcher: Launcher, colours: Any, chosen: NDArray[np.bool_]) -> tuple[Triangles, OnRows]:
        """The chosen triangles, in order, and what sets them up.

        Their planes carry colours in the place of positions.
        """
        corners = launcher.view(np.compress(chosen, self.mesh.triangles, axis=0), wp.vec3i)
        inputs = [self.points, self.uv, colours, self.slope, corners, self.drawn]
        return to_set_up(launcher, len(corners), inputs)


def vertices_of(shot: Shot, quads: tuple[int, int]) -> Vertices:
    """The road of a shot in so many quads a segment, across and along; kept where the eye stands still."""
    scene, camera = shot.sequence.scene, shot.view.camera
    width, height = shot.sequence.size

    def make() -> Vertices:
        road = scene.road.model_copy(update={"tessellation": quads})
        mesh = scene_mesh(scene.model_copy(update={"road": road}), camera)
        return Vertices.of(shot.launcher, mesh, screen_projection(camera, height, width))

    return shot.kept("vertices", (scene, camera, width, height, quads, shot.launcher), make)


def render(shot: Shot, settings: VertexSettings) -> Picture:
    """Shade the vertices with inputs filtered to their spacing, interpolate with correct perspective."""
    launcher, grid, vertices = shot.launcher, shot.grid(), vertices_of(shot, settings.quads)
    texels = max(size / quads for size, quads in zip(shot.material.size, settings.quads, strict=True))
    picture = launcher.unset((shot.view.height, shot.view.width), wp.vec4)
    chosen = vertices.sampled(launcher, grid)
    # All is laid out before anything else runs, as kernels empty the caches.
    colours, shade = vertices.to_shade(shot, log2(texels))
    triangles, set_up = vertices.to_set_up(launcher, colours, chosen)
    draw = launcher.laid_out(
        shot.view.height,
        interpolate,
        (),
        [grid, triangles.edges, triangles.planes, triangles.bounds, picture],
        own=Scratch(grid.width, wp.int32),
    )
    launcher.start(shade)
    set_up()
    draw()
    return Picture(to_image(picture), shaded=len(colours))


TECHNIQUE = Technique(
    name="vertex",
    summary="shaded at vertices, interpolated between them",
    source="Gouraud 1971, Continuous Shading of Curved Surfaces; Sloan & Baker, Frequency of Evaluation",
    render=render,
    settings=VertexSettings,
)
