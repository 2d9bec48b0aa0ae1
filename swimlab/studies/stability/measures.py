"""Hard cases of the measures: a little flicker on a bright picture, and frames that cannot be measured."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics import Clip, ClipError, measure
from swimlab.studies.stability.twin import rms

SIDE, FRAMES = 64, 8
BRIGHTNESS = (1.0, 1e2, 1e4, 1e5)
"""Of the picture, in standard deviations of the flicker."""


class Flicker(NamedTuple):
    """Relative errors of a measured flicker under a bright picture: as E[x^2] - E[x]^2 in single precision (1: none or
    less was found), and as `residual.flicker`."""

    naive: float
    shipped: float


def bright_flicker() -> dict[float, Flicker]:
    """By brightness; the same frames less their brightness, measured in double, are the reference."""
    noise = np.random.default_rng(0).normal(0, 1, (FRAMES, SIDE, SIDE, 3))
    found = {}
    for level in BRIGHTNESS:
        frames = (level + noise).astype(np.float32)
        calm = frames.astype(np.float64) - level
        sums = frames.sum(axis=0, dtype=np.float32), np.square(frames).sum(axis=0, dtype=np.float32)
        mean = sums[0] / np.float32(FRAMES)
        variance = np.maximum(sums[1] / np.float32(FRAMES) - mean * mean, 0)
        exact = calm.var(axis=0)
        found[level] = Flicker(rms(variance - exact) / rms(exact), abs(_flicker(frames) / _flicker(calm) - 1))
    return found


def _flicker(frames: NDArray[Any]) -> float:
    clip = Clip(lambda t: frames[t], len(frames), motion=(0.0, 0.0))
    return measure(clip, names=["residual"]).scores["residual.flicker"]


def refused() -> dict[str, str]:
    """What frames that cannot be measured are answered with."""
    frames = np.ones((2, 16, 16, 3), np.float32)
    cases = {"a NaN": np.nan, "an infinite value": np.inf}
    found = {}
    for name, value in cases.items():
        bad = frames.copy()
        bad[1, 3, 5] = value
        found[name] = _answer([bad[0], bad[1]])
    found["another size"] = _answer([frames[0], frames[1][:8]])
    return found


def _answer(frames: list[NDArray[Any]]) -> str:
    try:
        measure(Clip(lambda t: frames[t], len(frames)), names=["residual"])
    except ClipError as error:
        return str(error)
    return "is measured"
