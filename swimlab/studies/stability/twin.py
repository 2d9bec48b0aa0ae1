"""The product's formulas once more in double-precision numpy, and how far single precision is from them.

A flat road only: rays against a plane, singular values from numpy, the deck's Blinn-Phong and the moments of the
non-linear chains. No code is shared with the kernels.
"""

from collections.abc import Sequence as Ordered
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sequences import Sequence
from swimlab.render.inputs import Maps

Doubles = NDArray[np.float64]


class Error(NamedTuple):
    """How far single precision is off, as fractions of a scale.

    rms, largest: of the difference. flicker: rms of its change from one frame to the next, the flicker that it alone
    makes. bad: values that are NaN or infinite.
    """

    rms: float
    largest: float
    flicker: float
    bad: int


def compare(found: Ordered[NDArray[Any]], exact: Ordered[Doubles], *, scale: float | None = None) -> Error:
    """Frames in single precision against the same in double; scale: default, the rms of the exact ones."""
    differences = [np.asarray(f, np.float64) - e for f, e in zip(found, exact, strict=True)]
    bad = sum(int(np.sum(~np.isfinite(d))) for d in differences)
    differences = [np.nan_to_num(d, nan=0.0, posinf=0.0, neginf=0.0) for d in differences]
    unit_of = scale if scale is not None else rms(np.concatenate([np.ravel(e) for e in exact]))
    changes = [after - before for before, after in pairwise(differences)]
    return Error(
        rms=rms(np.concatenate([np.ravel(d) for d in differences])) / unit_of,
        largest=max(float(np.abs(d).max(initial=0.0)) for d in differences) / unit_of,
        flicker=rms(np.concatenate([np.ravel(c) for c in changes])) / unit_of if changes else 0.0,
        bad=bad,
    )


def rms(values: ArrayLike) -> float:
    """Root of the mean square; 0 of nothing."""
    values = np.asarray(values, np.float64)
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0


def unit(vectors: ArrayLike) -> Doubles:
    """Vectors [..., 3] of length 1."""
    vectors = np.asarray(vectors, np.float64)
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def radiance(texel: Doubles, position: Doubles, light: Doubles, diffuse: float) -> Doubles:
    """The deck's Blinn-Phong on a flat road [..., 3], of texels [..., 8] at places relative to the eye [..., 3]."""
    normal, half = unit(texel[..., 3:6]), unit(light - unit(position))
    cosine = np.clip(np.sum(normal * half, axis=-1), 0, 1)
    specular = cosine ** texel[..., 7] * texel[..., 7] * texel[..., 6]
    lambert = np.clip(np.sum(normal * light, axis=-1), 0, 1) * diffuse
    return np.asarray(texel[..., :3] * lambert[..., None] + specular[..., None])


class Seen(NamedTuple):
    """What pixels' centres see: [H, W] whether they hit, and of the hits [N, ...] place relative to the eye (m), uv
    and its derivatives by a pixel right and down."""

    hit: NDArray[np.bool_]
    position: Doubles
    uv: Doubles
    dx: Doubles
    dy: Doubles


@dataclass(frozen=True)
class Twin:
    """Frames of a sequence on a flat road with some maps, in double precision."""

    sequence: Sequence
    maps: Maps

    def seen(self, frame: int) -> Seen:
        """Rays through pixels' centres against the plane of the road."""
        view, road = self.sequence.view(frame), self.sequence.scene.road
        camera = view.camera
        (width, height), focal = self.sequence.size, camera.focal(self.sequence.size[1])
        right, down, forward = camera.basis()
        j, i = np.mgrid[: view.height, : view.width]
        x = view.origin[0] + (i + 0.5) * view.pitch[0] - width / 2
        y = view.origin[1] + (j + 0.5) * view.pitch[1] - height / 2
        ray = forward + right * (x / focal)[..., None] + down * (y / focal)[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            far = np.where(ray[..., 2] < 0, -camera.height / ray[..., 2], np.nan)
            position = ray * far[..., None]
            aside = np.abs(position[..., 0] + camera.lateral) <= road.width / 2
            hit = aside & (position[..., 1] >= -road.segment) & (position[..., 1] <= road.length)
        ray, far, position = ray[hit], far[hit, None], position[hit]
        scale = np.array([road.width, road.segment])
        steps = [axis * pitch / focal for axis, pitch in zip((right, down), view.pitch, strict=True)]
        by = [(step[:2] - ray[:, :2] * (step[2] / ray[:, 2:])) * far / scale for step in steps]
        start = np.array(
            [camera.lateral / road.width + 0.5, np.remainder(camera.distance, road.segment) / road.segment]
        )
        return Seen(hit, position, position[:, :2] / scale + start, *by)

    def radiance(self, frame: int, *, most: int | None) -> tuple[NDArray[np.bool_], Doubles]:
        """Hits [H, W], and their radiance [N, 3] under bilinear inputs (`most` None) or up to `most` probes."""
        seen, levels = self.seen(frame), chain(packed(self.maps))
        texel = bilinear(levels[0], seen.uv) if most is None else stretched(levels, seen.uv, seen.dx, seen.dy, most)
        sun = self.sequence.sun(frame)
        return seen.hit, radiance(texel, seen.position, sun.direction, sun.diffuse)


def packed(maps: Maps) -> Doubles:
    """Albedo, normal, Ks and power side by side [h, w, 8]."""
    return np.concatenate([maps.albedo, maps.normal, maps.gloss], axis=2, dtype=np.float64)


def chain(texels: Doubles) -> list[Doubles]:
    """Levels from full size to 1x1 by means of 2x2."""
    levels = [texels]
    while max(levels[-1].shape[:2]) > 1:
        below = levels[-1]
        if below.shape[0] > 1:
            below = (below[::2] + below[1::2]) / 2
        if below.shape[1] > 1:
            below = (below[:, ::2] + below[:, 1::2]) / 2
        levels.append(below)
    return levels


def bilinear(level: Doubles, uv: Doubles) -> Doubles:
    """Bilinear samples [N, c] of a level that repeats, at uv [N, 2]."""
    size = np.array(level.shape[1::-1])
    place = uv * size - 0.5
    first = np.floor(place).astype(np.int64)
    a, b = (place - first).T[..., None]
    (i, j), (right, below) = (first % size).T, ((first + 1) % size).T
    upper = level[j, i] * (1 - a) + level[j, right] * a
    lower = level[below, i] * (1 - a) + level[below, right] * a
    return np.asarray(upper * (1 - b) + lower * b)


def stretched(levels: Ordered[Doubles], uv: Doubles, dx: Doubles, dy: Doubles, most: int) -> Doubles:
    """Means of up to `most` trilinear probes along the footprints' major axes (see `kernels.sampling.probes_of`)."""
    size = np.array(levels[0].shape[1::-1])
    left, singular, _ = np.linalg.svd(np.stack([dx * size, dy * size], axis=-1))
    major, minor = singular.T
    count = np.clip(np.ceil(major / np.maximum(minor, 1e-300) - 1e-6), 1, most)
    count = np.where(major <= 1, 1, count)
    with np.errstate(divide="ignore"):
        lod = np.clip(np.log2(major / count), 0, len(levels) - 1)
    step = left[:, :, 0] * major[:, None] / size
    out = np.zeros((len(uv), levels[0].shape[2]))
    for probe in range(most):
        mine = count > probe
        place = uv[mine] + step[mine] * ((probe + 0.5) / count[mine] - 0.5)[:, None]
        out[mine] += trilinear(levels, place, lod[mine]) / count[mine, None]
    return out


def trilinear(levels: Ordered[Doubles], uv: Doubles, lod: Doubles) -> Doubles:
    """Samples of the two levels about `lod`."""
    out = np.zeros((len(uv), levels[0].shape[2]))
    floor = np.floor(lod).astype(int)
    for each in np.unique(floor):
        mine = floor == each
        blend = (lod[mine] - each)[:, None]
        upper = bilinear(levels[min(int(each) + 1, len(levels) - 1)], uv[mine])
        out[mine] = bilinear(levels[int(each)], uv[mine]) * (1 - blend) + upper * blend
    return out
