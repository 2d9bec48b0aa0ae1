"""How much of a noise's energy is left where a picture was taken between pixels: interpolation is a filter.

At a place a, b of 0..1 between pixels the quintic spline has the transfer function H(k; a) H(l; b) for frequencies k
and l, with H(k; a) = sum_j w_j(a) exp(2 pi i k j) / sum_j w_j(0) exp(2 pi i k j) (Unser 1999, eq. 12), w its weights.
A noise keeps |H|^2 of its energy: .84 of white noise, on average over all places.
"""

from functools import cache

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.octaves import OCTAVES

wp.set_module_options({"enable_backward": False})

FINEST = 3
"""Octaves from the highest one down in which energy is lost: below 1/8 cycles/px it is less than 1e-3."""

STEPS = 16
"""Steps of the table from a pixel to the middle between two."""

# Frequencies over which it is averaged, along each axis.
_BINS = 64


def _weights(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """[6, n], the quintic spline's weights of the samples -2..3 at places t [n] in 0..1."""
    from scipy.interpolate import BSpline  # heavy

    spline = BSpline.basis_element(np.arange(-3.0, 4.0), extrapolate=False)
    return np.nan_to_num(spline(t - np.arange(-2, 4)[:, None]))


@cache
def table() -> NDArray[np.float32]:
    """[STEPS + 1, STEPS + 1, FINEST], energy left at places (b, a) in 0..1/2 of white noise within an octave of |k|."""
    frequency = np.fft.fftfreq(_BINS)
    turn = np.exp(2j * np.pi * np.arange(-2, 4)[:, None] * frequency)
    places = np.arange(STEPS + 1) / STEPS / 2
    response = np.abs(_weights(places).T @ turn / (_weights(np.zeros(1)).T @ turn)) ** 2
    octave = np.digitize(np.hypot(frequency[:, None], frequency[None, :]), OCTAVES) - 1
    found = [
        np.einsum("bk,al,kl->ba", response, response, octave == number, optimize=True) / np.sum(octave == number)
        for number in range(len(OCTAVES) - FINEST, len(OCTAVES))
    ]
    return np.stack(found, axis=2).astype(np.float32)


def mean_left(away: NDArray[np.float32], left: NDArray[np.float32]) -> NDArray[np.float64]:
    """[FINEST], what is left on average of a picture that is taken at places [..., 2] (x, y), px; 1 of none."""
    between = np.rint(np.abs(away - np.rint(away)) * (2 * STEPS)).astype(np.intp).reshape(-1, 2)
    return left[between[:, 1], between[:, 0]].mean(axis=0, dtype=np.float64) if len(between) else np.ones(FINEST)


def whole_octaves(finest: NDArray[np.float64]) -> NDArray[np.float64]:
    """[..., octaves] of what is left in the finest ones, [..., FINEST]: all of the rest."""
    rest = np.ones((*finest.shape[:-1], len(OCTAVES) - FINEST))
    return np.concatenate([rest, finest], axis=-1)


@wp.func
def step_of(away: wp.float32) -> wp.int32:
    """The table's step of a place; the first where that is not a number."""
    between = away - wp.rint(away)
    return wp.max(wp.int32(wp.rint(wp.abs(between) * wp.static(2.0 * STEPS))), 0)


@wp.kernel
def add_gains(
    first: wp.int32,
    away: wp.array2d(dtype=wp.vec2),
    left: wp.array2d(dtype=wp.vec3),
    gains: wp.array2d(dtype=wp.vec3),
):
    """Add what is left, by the table, of a picture that is taken `away` px from each pixel, a row a thread."""
    row = first + wp.tid()
    for column in range(away.shape[1]):
        place = away[row, column]
        gains[row, column] = gains[row, column] + left[step_of(place[1]), step_of(place[0])]
