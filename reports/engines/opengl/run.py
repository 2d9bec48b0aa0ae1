"""A gallery drawn by OpenGL (Mesa's llvmpipe, without a graphics card) under three builds, and how much each flickers.

python run.py -o FOLDER [--size 480x270] [--frames 16]
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

os.environ.setdefault("EGL_PLATFORM", "surfaceless")

import gallery
import moderngl as gl
import numpy as np
from numpy.typing import NDArray

from swimlab.runs.frames import write_channels

HERE = Path(__file__).parent
BUILDS = {
    "aliased": ("plain", 1),
    "filtered": ("mipmapped", 1),
    "supersampled": ("plain", 2),
    "reference": ("plain", 8),
}
"""How the normal map is read, and samples a pixel as rows and columns of a grid."""

VERTEX = """
#version 330
uniform mat4 now, before;   // from the world to clip space
uniform vec3 moved, moved_before;
in vec3 place, normal;
in float surface;
out vec3 position, upright;
flat out int kind;
out vec4 clip, clip_before;
void main() {
    position = place + moved;
    upright = normal;
    kind = int(surface);
    clip = now*vec4(position, 1.0);
    clip_before = before*vec4(place + moved_before, 1.0);
    gl_Position = clip;
}
"""

SHADE = """
#version 330
uniform sampler2D bumps;
uniform vec3 eye;
in vec3 position, upright;
flat in int kind;
out vec4 colour;
const vec3 albedo[4] = vec3[](vec3(.1, .07, .04), vec3(.1, .07, .04), vec3(.01), vec3(.03, .06, .15));
void main() {
    vec3 normal = normalize(upright);
    float power = 80.0;
    if (kind < 2) {
        vec3 n = texture(bumps, (kind == 0 ? vec2(position.x, -position.z) : position.xy)/4.0).xyz;
        float size = length(n);                                  // shorter where the normals under it differ
        power *= size/(size + power*(1.0 - min(size, 1.0)));     // Toksvig
        n /= size;
        normal = kind == 0 ? vec3(n.x, n.z, -n.y) : n;
    }
    vec3 sun = normalize(vec3(2.0, 5.0, -8.0)), front = normalize(vec3(-3.0, 4.0, 6.0));
    vec3 halfway = normalize(sun + normalize(eye - position));
    float lobe = (power + 8.0)/25.0*pow(max(dot(normal, halfway), 0.0), power);
    float glossy = kind < 2 ? lobe*max(dot(normal, sun), 0.0) : 0.0;
    float diffuse = 0.4 + 2.0*max(dot(normal, front), 0.0);
    colour = vec4(albedo[kind]*diffuse + glossy, 1.0);
}
"""

GEOMETRY = """
#version 330
in vec4 clip, clip_before;
out vec4 motion_depth;
void main() { motion_depth = vec4(clip.xy/clip.w - clip_before.xy/clip_before.w, clip.w, 1.0); }
"""


class Painter:
    """An OpenGL context with the gallery in it, and a floating-point picture to draw into."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.size = size
        self.context = gl.create_standalone_context(backend="egl", require=330)
        self.context.enable(gl.DEPTH_TEST)
        picture, depth = self.context.texture(size, 4, dtype="f4"), self.context.depth_renderbuffer(size)
        self.frame = self.context.framebuffer(picture, depth)
        self.bumps = self.context.texture((gallery.SIDE, gallery.SIDE), 4, gallery.normals().tobytes(), dtype="f4")
        self.bumps.build_mipmaps()
        self.bumps.use(0)
        self.samplers = {
            "plain": self.context.sampler(filter=(gl.LINEAR, gl.LINEAR)),
            "mipmapped": self.context.sampler(filter=(gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR)),
        }
        self.parts = [
            (self.context.buffer(gallery.still().astype(np.float32).tobytes()), lambda frame: (0.0, 0.0, 0.0)),
            (self.context.buffer(gallery.column().astype(np.float32).tobytes()), gallery.column_place),
        ]
        self.programs = {
            name: self.context.program(vertex_shader=VERTEX, fragment_shader=code)
            for name, code in (("shade", SHADE), ("geometry", GEOMETRY))
        }

    def draw(self, program: str, frame: int, shift: tuple[float, float] = (0.0, 0.0)) -> NDArray[np.float32]:
        """[H, W, 4], the top row first."""
        shader = self.programs[program]
        eye, view = gallery.camera(frame)
        matrices = {
            "now": gallery.lens(self.size, shift) @ view,
            "before": gallery.lens(self.size, shift) @ gallery.camera(frame - 1)[1],
        }
        self.frame.use()
        self.context.clear()

        def give(name: str, values: object) -> None:
            if name in shader:  # the compiler drops what a program does not need
                shader[name].write(np.asarray(values, np.float32).tobytes())

        give("eye", eye)
        for name, matrix in matrices.items():
            give(name, matrix.T)
        for buffer, place in self.parts:
            give("moved", place(frame))
            give("moved_before", place(frame - 1))
            layout = [(buffer, "3f 3f 1f", "place", "normal", "surface")]
            self.context.vertex_array(shader, layout, skip_errors=True).render(gl.TRIANGLES)
        width, height = self.size
        return np.frombuffer(self.frame.read(components=4, dtype="f4"), np.float32).reshape(height, width, 4)[::-1]

    def picture(self, build: str, frame: int) -> NDArray[np.float32]:
        """Linear radiance, the mean of a build's samples, [H, W, 3]."""
        sampler, grid = BUILDS[build]
        self.samplers[sampler].use(0)
        places = (np.arange(grid) + 0.5) / grid - 0.5
        samples = [self.draw("shade", frame, (x, y))[..., :3] for y in places for x in places]
        return np.mean(samples, axis=0, dtype=np.float32)


def render(folder: Path, size: tuple[int, int], frames: int) -> None:
    """Write the frames of every build, the reference, motion and depth, and the shot file."""
    painter = Painter(size)
    drawn_by = {"Software": painter.context.info["GL_RENDERER"]}
    for frame in range(frames):
        motion_depth = painter.draw("geometry", frame)
        pictures = {build: (painter.picture(build, frame), ("R", "G", "B")) for build in BUILDS}
        pictures |= {"motion": (motion_depth[..., :2], ("R", "G")), "depth": (motion_depth[..., 2:3], ("Z",))}
        for name, (pixels, channels) in pictures.items():
            write_channels(folder / name / f"{frame:04d}.exr", pixels, channels, half=False, metadata=drawn_by)
        print(f"frame {frame + 1} of {frames}", file=sys.stderr)
    shutil.copy(HERE / "shot.toml", folder)


def measure(folder: Path) -> None:
    """Scores and report of all builds, in FOLDER/run."""
    words = ["study", folder / "shot.toml", "-o", folder / "run"]
    subprocess.run([sys.executable, "-m", "swimlab", *map(str, words)], check=True)


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder to write into")
    parser.add_argument("--size", default="480x270", help="width x height, pixels")
    parser.add_argument("--frames", type=int, default=16)
    given = parser.parse_args(words)
    width, height = map(int, given.size.split("x"))
    render(given.output, (width, height), given.frames)
    measure(given.output)


if __name__ == "__main__":
    main()
