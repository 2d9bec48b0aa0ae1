"""Banks (see `banks.py`) by one table over (L.T, V.T), after Heidrich & Seidel 1998.

Their table holds the highlight itself and so one power. This one holds sin((a + b)/2), a = asin(L.T), b = asin(V.T), of
which d = 1 - 2 sin^2((a + b)/2): the power enters after the lookup, so that one table serves a map of powers. As that
sine passes through 0 in a straight line where the highlight peaks, its error is multiplied by sqrt(p) only.
Coordinates are sign(x) (1 - sqrt(1 - |x|)), in which asin stays smooth to the ends.
"""

from functools import cache

import numpy as np
import warp as wp

from metrics.kernels.making import made_once
from swimlab.render.brdf import Brdf, Model
from swimlab.render.brdfs.banks import FACTORS, BanksSettings
from swimlab.render.kernels.shading import power_below_one
from swimlab.render.kernels.table import Doubles, Table, tabulated

NODES = 129
"""Odd, so that the bend of the coordinates at 0 falls on a node."""


def half_sine(u: Doubles, v: Doubles) -> Doubles:
    """sin((a + b)/2) by the table's coordinates."""
    x, y = (np.sign(c) * (1 - (1 - np.abs(c)) ** 2) for c in (2 * u - 1, 2 * v - 1))
    return np.asarray(np.sin((np.arcsin(x) + np.arcsin(y)) / 2))


@wp.func
def coordinate(x: wp.float32) -> wp.float32:
    """From a cosine with the tangent, -1..1, to the table's 0..1."""
    return 0.5 + 0.5 * wp.sign(x) * (1.0 - wp.sqrt(wp.max(1.0 - wp.abs(x), 0.0)))


@cache
def table() -> Table:
    """The table, 67 KB."""
    return tabulated(half_sine, columns=NODES, rows=NODES)


@made_once
def factored(settings: BanksSettings) -> Model:
    """The model with its table."""
    half_sine_at = table().lookup
    factor = FACTORS[settings.normalisation]
    times = settings.exponent

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        sine = half_sine_at(coordinate(light[0]), coordinate(view[0]))
        lambert = wp.clamp(light[2], 0.0, 1.0)
        exponent = times * power
        specular = power_below_one(wp.min(2.0 * sine * sine, 1.0), exponent) * lambert * factor(exponent) * ks
        return albedo * (lambert * diffuse) + wp.vec3(specular, specular, specular)

    return Model(evaluate, anisotropic=True, tables=(table(),))


BRDF = Brdf(
    name="banks-factored",
    summary="banks by a table over (L.T, V.T)",
    source="Heidrich & Seidel 1998, Efficient Rendering of Anisotropic Surfaces Using Computer Graphics Hardware",
    model=factored,
    settings=BanksSettings,
)
