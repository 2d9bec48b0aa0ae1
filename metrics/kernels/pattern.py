"""Sums of sinusoids, evaluated where the surface is that each pixel sees."""

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.launch import Launcher
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

_WAVES = """
    const int width = values.shape[1], waves = frequency.shape[0];
    float* const to = (float*)values.data + (long)row*width;
    const float* const place = (const float*)away.data + 2*(long)row*width;
    for (int column = 0; column < width; ++column) to[column] = 0.0f;
    for (int wave = 0; wave < waves; ++wave) {
        const float* const right = (const float*)across.data + (long)wave*width;
        const float down = ((const float*)along.data)[(long)wave*along.shape[1] + row];
        const float x = ((const float*)frequency.data)[2*wave], y = ((const float*)frequency.data)[2*wave + 1];
        #pragma clang loop vectorize(enable)
        for (int column = 0; column < width; ++column) {
            const float turns = right[column] + down + (x*place[2*column] + y*place[2*column + 1]);
            const float t = __builtin_fabsf(turns - __builtin_rintf(turns)) - 0.25f, square = t*t;
            const float odd = 81.60520938f + square*(-76.70366577f + square*(41.99995639f - square*14.33682754f));
            to[column] += -t*(6.28318531f + square*(-41.34170193f + square*odd));
        }
    }
    for (int column = 0; column < width; ++column) to[column] *= amplitude;
"""


@form(agrees=Within("native waves against plain"))
def row_of_waves() -> Twins:
    """The function that sums waves of one amplitude in a row of pixels, `away` px (x, y) from each one's centre.

    across, along: each wave's turns at the columns and at the rows, [waves, W] and [waves, H].
    """

    @wp.func(module="unique")
    def sum_waves(
        row: wp.int32,
        across: wp.array2d(dtype=wp.float32),
        along: wp.array2d(dtype=wp.float32),
        frequency: wp.array(dtype=wp.vec2),
        amplitude: wp.float32,
        away: wp.array2d(dtype=wp.vec2),
        values: wp.array2d(dtype=wp.float32),
    ):
        for column in range(values.shape[1]):
            total = wp.float32(0.0)
            for wave in range(frequency.shape[0]):
                turns = across[wave, column] + along[wave, row] + wp.dot(frequency[wave], away[row, column])
                total += wp.cos(wp.static(2.0 * np.pi) * (turns - wp.rint(turns)))
            values[row, column] = amplitude * total

    return Twins(sum_waves, _WAVES)


@made_once
def _rows_of_waves(device: str) -> wp.Kernel:
    sum_waves = row_of_waves().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        across: wp.array2d(dtype=wp.float32),
        along: wp.array2d(dtype=wp.float32),
        frequency: wp.array(dtype=wp.vec2),
        amplitude: wp.float32,
        away: wp.array2d(dtype=wp.vec2),
        values: wp.array2d(dtype=wp.float32),
    ):
        sum_waves(first + wp.tid(), across, along, frequency, amplitude, away, values)

    return kernel


def pattern_at(
    launcher: Launcher,
    frequency: NDArray[np.float64],
    phase: NDArray[np.float64],
    away: NDArray[np.float32],
    *,
    times: float = 1.0,
) -> NDArray[np.float32]:
    """Waves of unit variance, [H, W], seen `times` as far as `away` px, [H, W, 2], from each pixel.

    frequency: [waves, 2] (x, y), cycles/px. phase: [waves], rad.
    """
    height, width = away.shape[:2]
    values: Any = launcher.empty((height, width), wp.float32)
    # Whole turns go out in double precision: thousands of px from the corner a float32 angle is off by 1e-4 rad.
    across = (frequency[:, :1] * (np.arange(width) + 0.5) + phase[:, None] / (2 * np.pi)) % 1
    along = (frequency[:, 1:] * (np.arange(height) + 0.5)) % 1
    waves = [
        *(launcher.array(turns, wp.float32) for turns in (across, along)),
        launcher.array(times * frequency, wp.vec2),
    ]
    places = [float(np.sqrt(2 / len(phase))), launcher.view(away, wp.vec2), values]
    launcher.over(height, _rows_of_waves(launcher.device), (), [*waves, *places])
    return np.asarray(values.numpy())
