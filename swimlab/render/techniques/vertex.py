"""Vertex lighting: shade at the mesh's vertices and interpolate, the lowest frequency of evaluation.

"Generally, vertex evaluation is lowest frequency, while pixel is at a higher frequency. Not the case for low
resolution" (Sloan & Baker). Light at the vertices does not depend on the size of the frame, while pixel shading filters
its inputs further the smaller the frame is. On `road-scale` vertex lighting is worse than pixel-aniso down to a quarter
of 640x360, and nearer to the reference from 113x64 on. Highlights are smeared over quads, but stick to the road.
"""

from math import log2
from typing import Annotated, Any

import numpy as np
import warp as wp
from pydantic import Field

from metrics.kernels.making import made_once
from swimlab.render.inputs import BOX
from swimlab.render.kernels.raster import sample_position, see_row
from swimlab.render.kernels.sampling import trilinear
from swimlab.render.kernels.shading import in_local_frame, shade_with
from swimlab.render.kernels.structs import TEXELS, Chain, Edges, Grid, Planes, Sun, Surface
from swimlab.render.mesh import Doubles, Mesh, scene_mesh
from swimlab.render.settings import Settings
from swimlab.render.shot import Shot
from swimlab.render.technique import Picture, Technique, to_image
from swimlab.render.triangles import on_screen, sampled, screen_projection

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
        slope: wp.array(dtype=wp.float32),
        lod: wp.float32,
        texels: wp.array(dtype=texel_type),
        chain: Chain,
        sun: Sun,
        colours: wp.array(dtype=wp.vec3),
    ):
        k = wp.tid()
        surface = Surface()
        surface.position = positions[k]
        surface.slope = slope[k]
        colours[k] = shade(trilinear(texels, chain, lod, wp.vec2(uv[k])), surface, sun)

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


def vertex_colours(shot: Shot, mesh: Mesh, lod: float) -> Doubles:
    """Radiance at each vertex of a mesh, [N, 3], linear RGB, from the maps' box chain at a level of detail."""
    launcher, inputs = shot.launcher, shot.inputs(BOX)
    chain = shot.material.chain(inputs)
    kernel = shade_vertices(in_local_frame(shot.model.evaluate, chain.floats), chain.floats)
    colours = launcher.empty(len(mesh.positions), wp.vec3)
    arguments: list[Any] = [launcher.view(mesh.uv, wp.vec2d), launcher.view(mesh.positions, wp.vec3d)]
    arguments += [
        launcher.view(mesh.slope.astype(np.float32), wp.float32),
        lod,
        chain.texels,
        chain.shape,
        shot.sun,
        colours,
    ]
    launcher.launch(kernel, len(mesh.positions), arguments)
    return np.asarray(colours.numpy(), np.float64)


def render(shot: Shot, settings: VertexSettings) -> Picture:
    """Shade the vertices with inputs filtered to their spacing, interpolate with correct perspective."""
    launcher, scene, camera = shot.launcher, shot.sequence.scene, shot.view.camera
    across, along = settings.quads
    road = scene.road.model_copy(update={"tessellation": settings.quads})
    mesh = scene_mesh(scene.model_copy(update={"road": road}), camera)
    texels_across, texels_along = shot.material.size
    colours = vertex_colours(shot, mesh, log2(max(texels_across / across, texels_along / along)))
    width, height = shot.sequence.size
    projection, grid = screen_projection(camera, height, width), shot.grid()
    triangles = on_screen(launcher, sampled(launcher, mesh, projection, grid), projection, carried=colours)
    picture = launcher.empty((shot.view.height, shot.view.width), wp.vec4)
    launcher.over(
        shot.view.height,
        interpolate,
        (),
        [grid, triangles.edges, triangles.planes, triangles.bounds, picture],
        own=lambda rows: [launcher.empty((rows, grid.width), wp.int32)],
    )
    return Picture(to_image(picture), shaded=len(colours))


TECHNIQUE = Technique(
    name="vertex",
    summary="shaded at vertices, interpolated between them",
    source="Gouraud 1971, Continuous Shading of Curved Surfaces; Sloan & Baker, Frequency of Evaluation",
    render=render,
    settings=VertexSettings,
)
