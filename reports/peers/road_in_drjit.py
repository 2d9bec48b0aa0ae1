"""The road's reference in Dr.Jit's LLVM backend: one lane a pixel, a symbolic loop over its samples.

Needs a libLLVM; 15 aborts on its code ("cannot select fminimum"), 19 does not.
"""

import os
from pathlib import Path

os.environ.setdefault("DRJIT_LIBLLVM_PATH", str(max(Path("/usr/lib").glob("*/libLLVM.so.*"), default="libLLVM.so")))

import drjit as dr
import numpy as np
from drjit.llvm import Array2f, Array3f, Float, TensorXf, Texture2f, UInt
from numba_road import lengths, rays
from road import Contender, Road

NEAR = 0.01


def radiance(texel: list[Float], x: Float, y: Float, height: Float, light: Array3f, diffuse: Float) -> Array3f:
    """The deck's Blinn-Phong on flat ground."""
    normal = dr.normalize(Array3f(texel[3], texel[4], texel[5]))
    halfway = dr.normalize(light - dr.normalize(Array3f(x, y, -height)))
    cosine, power = dr.dot(normal, halfway), texel[7]
    specular = dr.select(cosine > 0, dr.exp2(power * dr.log2(cosine)) * power * texel[6], 0)
    lambert = dr.clip(dr.dot(normal, light), 0, 1) * diffuse
    return Array3f(texel[0], texel[1], texel[2]) * lambert + specular


def hashed(x: UInt) -> UInt:
    """Thirty-two bits from a number (Jarzynski & Olano 2020, PCG)."""
    state = x * 747796405 + 2891336453
    word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737
    return (word >> 22) ^ word


@dr.syntax
def reference(
    texture: Texture2f,
    columns: int,
    rows: int,
    n: int,
    ray: list[Float],
    road: list[Float],
    light: Array3f,
    diffuse: Float,
) -> tuple[Array3f, Float]:
    """The mean of n x n stratified samples a pixel, each of bilinear inputs of the finest level; and coverage."""
    height, lateral, distance, width, segment, length = road
    pixel = dr.arange(UInt, columns * rows)
    i, j = pixel % columns, pixel // columns
    total, hits, k = dr.zeros(Array3f, columns * rows), dr.zeros(Float, columns * rows), UInt(0)
    while k < n * n:
        column, row = k % n, k // n
        bits = hashed((j * n + row) * (columns * n) + i * n + column)
        px = Float(i) + (Float(column) + (Float(bits & 65535) + 0.5) / 65536) / n
        py = Float(j) + (Float(row) + (Float(bits >> 16) + 0.5) / 65536) / n
        across, ahead, up = (ray[3 * c] * px + ray[3 * c + 1] * py + ray[3 * c + 2] for c in range(3))
        s = -height / up
        x, y = s * across, s * ahead
        u, v = (x + lateral) / width + 0.5, (y + distance) / segment
        covered = (up < 0) & (s >= NEAR) & (u >= 0) & (u < 1) & (y >= -segment) & (y < length)
        texel = texture.eval(Array2f(u, v - dr.floor(v)), covered)
        total += dr.select(covered, radiance(texel, x, y, height, light, diffuse), 0)
        hits += dr.select(covered, Float(1), Float(0))
        k += 1
    return total / (n * n), hits / (n * n)


def contenders(road: Road, *, n: int = 8, threads: int = 2) -> tuple[str, list[Contender]]:
    """Version, and the reference of n x n samples a pixel."""
    dr.set_thread_count(threads)
    columns, rows = road.sequence.size
    texture = Texture2f(
        TensorXf(np.ascontiguousarray(road.levels[0])), filter_mode=dr.FilterMode.Linear, wrap_mode=dr.WrapMode.Repeat
    )
    direction, diffuse = road.light
    shape = [dr.opaque(Float, float(x)) for x in lengths(road)]
    light, intensity = Array3f(*map(float, direction)), Float(diffuse)
    dr.make_opaque(light, intensity)
    drawn: list[np.ndarray] = []

    def supersampled(frame: int) -> None:
        ray = [dr.opaque(Float, float(x)) for x in rays(road, frame).ravel()]
        colour, coverage = reference(texture, columns, rows, n, ray, shape, light, intensity)
        dr.eval(colour, coverage)
        dr.sync_thread()
        drawn[:] = [*colour, coverage]

    def read() -> np.ndarray:
        return np.stack([plane.numpy() for plane in drawn], axis=-1).reshape(rows, columns, 4)

    return f"Dr.Jit {dr.__version__}", [Contender("drjit reference", supersampled, read, n * n)]
