"""Tables of functions of two variables, for reflectance models that are factored into textures.

The values stand in the code of the kernels that look them up, so that other kernels need no more parameters.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]


class Table(NamedTuple):
    """A function sampled at evenly spaced nodes, the ends of 0..1 among them.

    values: [rows, columns], by v and u. lookup: the device function (u, v) -> value between four nodes, bilinearly; u
        and v are clamped to 0..1.
    """

    values: Floats
    lookup: wp.Function

    def at(self, u: Floats, v: Floats) -> Floats:
        """The plain form of `lookup`, on the host: the same bits for float32 arrays u and v."""
        rows, columns = self.values.shape
        x = np.clip(u, 0, 1) * np.float32(columns - 1)
        y = np.clip(v, 0, 1) * np.float32(rows - 1)
        i, j = np.minimum(x.astype(np.int32), columns - 2), np.minimum(y.astype(np.int32), rows - 2)
        a, b = x - i.astype(np.float32), y - j.astype(np.float32)
        lower = self.values[j, i] + (self.values[j, i + 1] - self.values[j, i]) * a
        upper = self.values[j + 1, i] + (self.values[j + 1, i + 1] - self.values[j + 1, i]) * a
        return np.asarray(lower + (upper - lower) * b, np.float32)


def tabulated(function: Callable[[Doubles, Doubles], Doubles], *, columns: int, rows: int) -> Table:
    """The table of function(u, v), which takes arrays of 0..1 in double precision.

    Raises ValueError where it is not finite at a node.
    """
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    values = np.asarray(function(u, v), np.float64).astype(np.float32)
    if not np.isfinite(values).all():
        raise ValueError(f"{function.__qualname__}: is not finite at {int((~np.isfinite(values)).sum())} nodes")
    numbers = ",".join(f"{value:.9e}f" for value in values.ravel().tolist())
    snippet = f"""
    static const float nodes[] = {{{numbers}}};
    const float x = (u > 0.0f ? (u < 1.0f ? u : 1.0f) : 0.0f)*{columns - 1}.0f;
    const float y = (v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f)*{rows - 1}.0f;
    const int i = x < {columns - 2}.0f ? (int)x : {columns - 2}, j = y < {rows - 2}.0f ? (int)y : {rows - 2};
    const float a = x - (float)i, b = y - (float)j;
    const float* at = nodes + j*{columns} + i;
    const float lower = at[0] + (at[1] - at[0])*a, upper = at[{columns}] + (at[{columns + 1}] - at[{columns}])*a;
    return lower + (upper - lower)*b;
"""

    @wp.func_native(snippet)
    def lookup(u: wp.float32, v: wp.float32) -> wp.float32: ...

    return Table(values, lookup)
