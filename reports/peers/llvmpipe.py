"""The road drawn by OpenGL: a software rasteriser (Mesa llvmpipe) where there is no graphics card.

The maps are four floats a texel in two textures; mip levels are those of our chain, uploaded.
"""

import os
from functools import cache

os.environ.setdefault("LP_NUM_THREADS", "2")
os.environ.setdefault("EGL_PLATFORM", "surfaceless")

import moderngl as gl
import numpy as np
from road import Contender, Image, Road

from swimlab.render.mesh import scene_mesh

NEAR = 0.01
TARGET = 1024
"""Side of a segment's target of texture-space lighting, texels."""

SCREEN = """
#version 330
uniform mat4 clip;
in vec3 place;
in vec2 at;
out vec3 position;
out vec2 uv;
void main() { position = place; uv = at; gl_Position = clip*vec4(place, 1.0); }
"""

TEXTURE_SPACE = SCREEN.replace("clip*vec4(place, 1.0)", "vec4(2.0*at - 1.0, 0.0, 1.0)").replace(
    "uniform mat4 clip;", ""
)

SHADE = """
#version 330
uniform sampler2D first;   // albedo, Ks
uniform sampler2D second;  // normal, power
uniform vec3 light;
uniform float diffuse;
in vec3 position;
in vec2 uv;
out vec4 colour;
void main() {
    vec4 a = texture(first, uv), b = texture(second, uv);
    vec3 normal = normalize(b.xyz), halfway = normalize(light - normalize(position));
    float cosine = dot(normal, halfway);
    float specular = cosine > 0.0 ? pow(cosine, b.w)*b.w*a.w : 0.0;
    float lambert = clamp(dot(normal, light), 0.0, 1.0)*diffuse;
    colour = vec4(a.rgb*lambert + specular, 1.0);
}
"""

PASTE = """
#version 330
uniform sampler2D target;
in vec3 position;
in vec2 uv;
out vec4 colour;
void main() {
    vec4 c = texture(target, uv);
    colour = vec4(c.rgb/(c.a > 1.0e-5 ? c.a : 1.0), 1.0);
}
"""

FILTERS = {
    "point": (gl.NEAREST, gl.NEAREST, 1.0),
    "bilinear": (gl.LINEAR, gl.LINEAR, 1.0),
    "trilinear": (gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR, 1.0),
    "aniso": (gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR, 16.0),
}


class OpenGL:
    """A context with the road's maps, and a frame to draw into."""

    def __init__(self, road: Road, *, target: str = "f4") -> None:
        self.road = road
        self.context = gl.create_standalone_context(backend="egl", require=330)
        self.context.disable(gl.DEPTH_TEST | gl.CULL_FACE)
        width, height = road.sequence.size
        self.frame = self.context.framebuffer(self.context.texture((width, height), 4, dtype="f4"))
        self.maps = [self._map((0, 1, 2, 6)), self._map((3, 4, 5, 7))]
        self.target = self.context.texture((TARGET, TARGET), 4, dtype=target)
        self.target.build_mipmaps()
        self.target_frame = self.context.framebuffer(self.target)
        self.samplers = {name: self._sampler(*how) for name, how in FILTERS.items()}
        self.clamping = self._sampler(*FILTERS["aniso"], repeats=False)
        self._fill_geometry()
        self.shade_screen = self._program(SCREEN, SHADE)
        self.shade_target = self._program(TEXTURE_SPACE, SHADE)
        self.paste_target = self._program(SCREEN, PASTE)

    @property
    def description(self) -> str:
        """Renderer and version."""
        return f"{self.context.info['GL_RENDERER']}, {self.context.info['GL_VERSION']}"

    def _map(self, channels: tuple[int, ...]) -> gl.Texture:
        levels = self.road.levels
        texture = self.context.texture(levels[0].shape[1::-1], 4, dtype="f4")
        texture.build_mipmaps()
        for level, texels in enumerate(levels):
            texture.write(np.ascontiguousarray(texels[..., channels]), level=level)
        return texture

    def _sampler(self, small: int, large: int, anisotropy: float, *, repeats: bool = True) -> gl.Sampler:
        sampler = self.context.sampler(repeat_x=repeats, repeat_y=repeats, filter=(small, large))
        sampler.anisotropy = anisotropy
        return sampler

    def _fill_geometry(self) -> None:
        """Vertices of all triangles one after another; the camera of a sliding picture stands still."""
        mesh = scene_mesh(self.road.sequence.scene, self.road.sequence.view(0).camera)
        corners = mesh.triangles.ravel()
        vertices = np.concatenate([mesh.positions[corners], mesh.uv[corners]], axis=1).astype(np.float32)
        self.buffer = self.context.buffer(vertices.tobytes())
        self.vertices = {s: np.flatnonzero(np.repeat(mesh.segments, 3) == s) for s in np.unique(mesh.segments)}

    def _program(self, vertex: str, fragment: str) -> gl.VertexArray:
        program = self.context.program(vertex_shader=vertex, fragment_shader=fragment)
        light, diffuse = self.road.light
        given = {"light": tuple(light), "diffuse": diffuse, "first": 0, "second": 1, "target": 0}
        for name in (name for name in given if name in program):
            program[name] = given[name]
        used = [name for name in ("place", "at") if name in program]
        layout = f"{'3f' if 'place' in used else '3x4'} 2f"
        return self.context.vertex_array(program, [(self.buffer, layout, *used)])

    def _clip(self, frame: int) -> bytes:
        """From positions to clip space: row 0 of the picture is at y = -1, the near plane at z = -w."""
        width, height = self.road.sequence.size
        x, y, w = self.road.projection(frame)
        clip = np.zeros((4, 4))
        clip[:, :3] = 2 * x / width - w, 2 * y / height - w, w, w
        clip[2, 3] = -2 * NEAR
        return clip.T.astype(np.float32).tobytes()

    def pixels(self, frame: int, name: str) -> None:
        """Filter the inputs, shade once a pixel."""
        self.frame.use()
        self.context.clear()
        for place, texture in enumerate(self.maps):
            texture.use(place)
            self.samplers[name].use(place)
        self.shade_screen.program["clip"].write(self._clip(frame))
        self.shade_screen.render(gl.TRIANGLES)
        self.context.finish()

    def texture_space(self, frame: int, segments: list[int]) -> None:
        """Light, reduce and paste one visible segment after another."""
        self.frame.use()
        self.context.clear()
        self.paste_target.program["clip"].write(self._clip(frame))
        for segment in segments:
            mine = self.vertices[segment]
            self.target_frame.use()
            self.context.clear()
            for place, texture in enumerate(self.maps):
                texture.use(place)
                self.samplers["trilinear"].use(place)
            self.shade_target.render(gl.TRIANGLES, vertices=len(mine), first=int(mine[0]))
            self.target.build_mipmaps()
            self.frame.use()
            self.target.use(0)
            self.clamping.use(0)
            self.paste_target.render(gl.TRIANGLES, vertices=len(mine), first=int(mine[0]))
        self.context.finish()

    def read(self) -> Image:
        """The picture."""
        width, height = self.road.sequence.size
        return np.frombuffer(self.frame.read(components=4, dtype="f4"), np.float32).reshape(height, width, 4)


def contenders(road: Road) -> tuple[str, list[Contender]]:
    """Version, and pixel shading under each filter and texture-space lighting."""
    opengl = OpenGL(road)
    segments = cache(road.visible_segments)  # known after the first drawing of a frame, so not timed

    def pixels(name: str) -> Contender:
        return Contender(f"llvmpipe {name}", lambda frame: opengl.pixels(frame, name), opengl.read)

    def texture_space(frame: int) -> None:
        opengl.texture_space(frame, segments(frame))

    return opengl.description, [*map(pixels, FILTERS), Contender("llvmpipe tsl", texture_space, opengl.read)]
