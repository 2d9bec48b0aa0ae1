"""The road in numba: the same definitions as straightforward loops in float32, rows in parallel, fast-math."""

import os

os.environ.setdefault("NUMBA_NUM_THREADS", "2")
os.environ.setdefault("NUMBA_THREADING_LAYER", "workqueue")

import numba
import numpy as np
from numba import float32 as f
from numba import njit, prange, uint32
from road import Contender, Image, Road

NEAR = 0.01
MOST = 16


@njit(fastmath=True, inline="always")
def surface(ray, road, px, py):
    """Where the ray of a pixel place meets the road: whether, x, y (m, about the eye), u, v, uv by dx and dy."""
    height, lateral, distance, width, segment, length = road
    dx = ray[0, 0] * px + ray[0, 1] * py + ray[0, 2]
    dy = ray[1, 0] * px + ray[1, 1] * py + ray[1, 2]
    dz = ray[2, 0] * px + ray[2, 1] * py + ray[2, 2]
    s = -height / dz
    x, y = s * dx, s * dy
    u, v = (x + lateral) / width + f(0.5), (y + distance) / segment
    covered = dz < f(0) and s >= f(NEAR) and f(0) <= u < f(1) and -segment <= y < length
    k = -s / dz
    ux, vx = s * ray[0, 0] + k * dx * ray[2, 0], s * ray[1, 0] + k * dy * ray[2, 0]
    uy, vy = s * ray[0, 1] + k * dx * ray[2, 1], s * ray[1, 1] + k * dy * ray[2, 1]
    return covered, x, y, u, v - np.floor(v), ux / width, vx / segment, uy / width, vy / segment


@njit(fastmath=True, inline="always")
def bilinear(texels, offset, side, u, v, weight, texel):
    """Add the weighted mean of the four texels about (u, v) to `texel`."""
    x, y = u * f(side) - f(0.5), v * f(side) - f(0.5)
    left, top = np.floor(x), np.floor(y)
    a, b = x - left, y - top
    i0, j0 = int(left) & (side - 1), int(top) & (side - 1)
    i1, j1 = (int(left) + 1) & (side - 1), (int(top) + 1) & (side - 1)
    p, q = offset + j0 * side, offset + j1 * side
    w00, w10 = (f(1) - a) * (f(1) - b) * weight, a * (f(1) - b) * weight
    w01, w11 = (f(1) - a) * b * weight, a * b * weight
    for c in range(8):
        texel[c] += (
            texels[p + i0, c] * w00 + texels[p + i1, c] * w10 + texels[q + i0, c] * w01 + texels[q + i1, c] * w11
        )


@njit(fastmath=True, inline="always")
def shade(texel, x, y, height, light, diffuse, out):
    """Add the radiance of the deck's Blinn-Phong on flat ground to `out`."""
    nx, ny, nz = texel[3], texel[4], texel[5]
    n = f(1) / np.sqrt(nx * nx + ny * ny + nz * nz)
    e = f(1) / np.sqrt(x * x + y * y + height * height)
    hx, hy, hz = light[0] - x * e, light[1] - y * e, light[2] + height * e
    h = n / np.sqrt(hx * hx + hy * hy + hz * hz)
    cosine = min((nx * hx + ny * hy + nz * hz) * h, f(1))
    power = texel[7]
    specular = f(0)
    if cosine > f(0):
        specular = np.exp(power * np.log(cosine)) * power * texel[6]
    lambert = min(max((nx * light[0] + ny * light[1] + nz * light[2]) * n, f(0)), f(1)) * diffuse
    for c in range(3):
        out[c] += texel[c] * lambert + specular


@njit(parallel=True, fastmath=True)
def pixel_aniso(texels, offsets, ray, road, light, diffuse, picture):
    """Up to 16 trilinear probes along the footprint's major axis; shaded once."""
    rows, columns = picture.shape[:2]
    levels = len(offsets)
    full = 1 << (levels - 1)
    for j in prange(rows):
        texel = np.empty(8, np.float32)
        for i in range(columns):
            picture[j, i, :] = f(0)
            covered, x, y, u, v, ux, vx, uy, vy = surface(ray, road, f(i) + f(0.5), f(j) + f(0.5))
            if not covered:
                continue
            ux, vx, uy, vy = ux * f(full), vx * f(full), uy * f(full), vy * f(full)
            a, b, c = ux * ux + uy * uy, ux * vx + uy * vy, vx * vx + vy * vy
            half = f(0.5) * (a - c)
            square = f(0.5) * (a + c) + np.sqrt(half * half + b * b)
            major = np.sqrt(square)
            minor = abs(ux * vy - uy * vx) / major
            probes = 1
            if major > f(1):
                probes = MOST
                if minor * f(MOST) > major:
                    probes = min(max(int(np.ceil(major / minor - f(1e-6))), 1), MOST)
            ax, ay = (square - c, b) if a >= c else (b, square - a)
            scale = major / (np.sqrt(ax * ax + ay * ay) * f(full))
            lu, lv = ax * scale, ay * scale
            lod = min(max(np.log2(major / f(probes)), f(0)), f(levels - 1))
            level = int(lod)
            blend = lod - f(level)
            share = f(1) / f(probes)
            texel[:] = f(0)
            for k in range(probes):
                along = (f(k) + f(0.5)) * share - f(0.5)
                pu, pv = u + lu * along, v + lv * along
                bilinear(texels, offsets[level], full >> level, pu, pv, share * (f(1) - blend), texel)
                if blend > f(1e-6):
                    bilinear(texels, offsets[level + 1], full >> (level + 1), pu, pv, share * blend, texel)
            shade(texel, x, y, road[0], light, diffuse, picture[j, i])
            picture[j, i, 3] = f(1)


@njit(inline="always")
def hashed(x):
    """Thirty-two bits from a number (Jarzynski & Olano 2020, PCG)."""
    state = uint32(uint32(x) * uint32(747796405) + uint32(2891336453))
    word = uint32(uint32((state >> ((state >> uint32(28)) + uint32(4))) ^ state) * uint32(277803737))
    return uint32((word >> uint32(22)) ^ word)


@njit(parallel=True, fastmath=True)
def reference(texels, n, side, ray, road, light, diffuse, picture):
    """The mean of n x n stratified samples a pixel, each of bilinear inputs of the finest level."""
    rows, columns = picture.shape[:2]
    share = f(1) / f(n * n)
    for j in prange(rows):
        texel = np.empty(8, np.float32)
        total = np.empty(3, np.float32)
        for i in range(columns):
            total[:] = f(0)
            hits = 0
            for row in range(n):
                for column in range(n):
                    bits = hashed((j * n + row) * columns * n + i * n + column)
                    px = f(i) + (f(column) + (f(bits & uint32(65535)) + f(0.5)) * f(1 / 65536)) / f(n)
                    py = f(j) + (f(row) + (f(bits >> uint32(16)) + f(0.5)) * f(1 / 65536)) / f(n)
                    covered, x, y, u, v, _, _, _, _ = surface(ray, road, px, py)
                    if covered:
                        texel[:] = f(0)
                        bilinear(texels, 0, side, u, v, f(1), texel)
                        shade(texel, x, y, road[0], light, diffuse, total)
                        hits += 1
            for c in range(3):
                picture[j, i, c] = total[c] * share
            picture[j, i, 3] = f(hits) * share


def rays(road: Road, frame: int) -> np.ndarray:
    """The 3x3 matrix from pixels (x, y, 1) to directions whose part along the camera's axis is 1."""
    return np.ascontiguousarray(np.linalg.inv(road.projection(frame)).astype(np.float32))


def lengths(road: Road) -> tuple[np.float32, ...]:
    """Eye's height, lateral and along the segment; road's width, segment, length: m."""
    camera, shape = road.sequence.camera, road.sequence.scene.road
    given = (camera.height, camera.lateral, camera.distance % shape.segment, shape.width, shape.segment, shape.length)
    return tuple(np.float32(x) for x in given)


def contenders(road: Road, *, n: int = 8) -> tuple[str, list[Contender]]:
    """Version, pixel-aniso, and the reference of n x n samples a pixel."""
    width, height = road.sequence.size
    picture: Image = np.zeros((height, width, 4), np.float32)
    texels = np.concatenate([level.reshape(-1, 8) for level in road.levels])
    offsets = np.cumsum([0, *(level.shape[0] * level.shape[1] for level in road.levels[:-1])])
    direction, diffuse = road.light
    common = (lengths(road), direction.astype(np.float32), np.float32(diffuse), picture)
    side = road.levels[0].shape[0]

    def aniso(frame: int) -> None:
        pixel_aniso(texels, offsets, rays(road, frame), *common)

    def supersampled(frame: int) -> None:
        reference(texels, n, side, rays(road, frame), *common)

    return f"numba {numba.__version__}", [
        Contender("numba aniso", aniso, picture.copy),
        Contender("numba reference", supersampled, picture.copy, n * n),
    ]
