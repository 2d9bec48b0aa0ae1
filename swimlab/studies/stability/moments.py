"""Hard cases of filtered moments: variances that cancel, and 8-bit normals."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics.kernels.launch import Launcher
from swimlab.render.inputs import Inputs, Maps, variances
from swimlab.render.kernels.inspection import resolve_coarsest
from swimlab.render.material import Material
from swimlab.render.techniques import clean, lean
from swimlab.studies.stability.twin import Doubles, rms, unit

SIDE = 64
MAPS = 6
"""Maps that an error is taken over."""
LEANS = (0.0, 0.1, 0.5, 2.0)
"""Mean slopes."""
VARIANCES = (1e-2, 1e-3, 1e-4, 1e-5)
GAUGES = (100.0, 1e3, 1e4)
"""Powers of the study of 8-bit normals."""
CODES = 200_000


class Variance(NamedTuple):
    """Relative errors, rms over maps, of the standard deviations that a chain's last texel gives.

    about_zero: moments about slope 0, as first published; 1 is a variance of 0 or less. half: the same in 16-bit
    floats. clean, lean: moments about the map's mean, as shipped; LEAN's is of the fourth root of the determinant.
    """

    half: float
    about_zero: float
    clean: float
    lean: float


def lean_variances(launcher: Launcher) -> dict[tuple[float, float], Variance]:
    """By mean slope, and variance, of which half is the spread of slopes and half 1/power."""
    return {(mean, variance): _variance(launcher, mean, variance) for mean in LEANS for variance in VARIANCES}


def _variance(launcher: Launcher, mean: float, variance: float) -> Variance:
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(MAPS):
        tilt = np.array([mean, -mean]) / np.sqrt(2)
        maps = sloping(tilt + rng.normal(0, np.sqrt(variance / 2), (SIDE, SIDE, 2)), power=2 / variance)
        given = maps.normal.astype(np.float64)
        b = given[..., :2] / given[..., 2:]
        exact = np.cov(b.reshape(-1, 2).T, ddof=0) + np.eye(2) * variance / 2
        half, about_zero = (_isotropic(b, variance / 2, kind) for kind in (np.float16, np.float32))
        last = coarsest(launcher, maps, lean.INPUTS)
        determinant = float(last[5]) * float(last[7]) - float(last[8]) ** 2
        spread = np.sqrt(np.trace(exact) / 2)
        errors.append(
            [
                np.sqrt(half) / spread - 1,
                np.sqrt(about_zero) / spread - 1,
                float(coarsest(launcher, maps, clean.INPUTS)[7]) ** -0.5 / spread - 1,
                (determinant / np.linalg.det(exact)) ** 0.25 - 1,
            ]
        )
    return Variance(*(rms(column) for column in np.transpose(errors)))


def sloping(b: Doubles, *, power: float) -> Maps:
    """Maps of slopes [h, w, 2] and one power."""
    normal = unit(np.concatenate([b, np.ones((*b.shape[:2], 1))], axis=2))
    gloss = np.broadcast_to(np.array([1.0, power], np.float32), (*b.shape[:2], 2))
    return Maps(np.full_like(normal, 0.5, dtype=np.float32), normal.astype(np.float32), gloss)


def coarsest(launcher: Launcher, maps: Maps, inputs: Inputs) -> NDArray[Any]:
    """What the last texel of a chain of moments is resolved to."""
    chain = Material(launcher, maps).chain(inputs)
    if inputs.resolve is None:
        raise ValueError(f"{inputs.name}: filters no moments")
    out = launcher.empty(1, chain.texels.dtype)
    launcher.launch(resolve_coarsest(inputs.resolve), 1, [chain.shape, chain.texels, out])
    return np.asarray(out.numpy()[0])


def _isotropic(b: Doubles, least: float, kind: type) -> float:
    """Mean of the two slopes' variances by raw moments in the precision `kind`, 0 where it came out below."""
    level: NDArray[Any] = np.concatenate([b, (b * b).sum(axis=2, keepdims=True) + 2 * least], axis=2).astype(kind)
    while len(level) > 1:
        level = (level[::2, ::2] + level[::2, 1::2] + level[1::2, ::2] + level[1::2, 1::2]) * kind(0.25)
    x, y, second = level[0, 0]
    return max(0.0, float((second - x * x - y * y) * kind(0.5)))


class Codes(NamedTuple):
    """A map of one normal in 8-bit codes has no roughness of its own: its highlight should keep its power.

    negative: share of codes at which Toksvig's formula as published divides by 0 or less. widest: the largest power
    over what is left of it with lengths cut at 1. deviation: rms of log(power'/power) then. shipped: the largest power
    over what the product leaves of it.
    """

    negative: float
    widest: float
    deviation: float
    shipped: float


def eight_bit() -> dict[float, Codes]:
    """By power, over random normals of the upper hemisphere."""
    normals = unit(np.random.default_rng(0).normal(size=(CODES, 3)))
    normals[:, 2] = np.abs(normals[:, 2])
    decoded = (2 * np.round((normals + 1) / 2 * 255) / 255 - 1)[None].astype(np.float32)
    length = np.linalg.norm(decoded.astype(np.float64), axis=2)
    found = {}
    for power in GAUGES:
        gloss = np.broadcast_to(np.array([1.0, power], np.float32), (1, CODES, 2))
        packed = variances(Maps(np.zeros_like(decoded), decoded, gloss)).texels.astype(np.float64)
        ours = widened(np.linalg.norm(packed[..., 3:6], axis=2), power)
        theirs = widened(length, power)
        found[power] = Codes(
            negative=float(np.mean(length + power * (1 - length) <= 0)),
            widest=float(power / theirs.min()),
            deviation=rms(np.log(theirs / power)),
            shipped=float(power / ours.min()),
        )
    return found


def widened(length: Doubles, power: float) -> Doubles:
    """Toksvig's power of normals of a mean length, cut at 1."""
    length = np.minimum(length, 1)
    return np.asarray(1 / (1 / power + (1 - length) / length))
