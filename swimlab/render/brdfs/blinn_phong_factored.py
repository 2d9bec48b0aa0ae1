"""Blinn-Phong (see `blinn_phong.py`) by one table over (N.H, p) for the lobe (N.H)^p; its factor n(p) is computed.

Over N.H and p as they are, a lobe of p = 1e5 would fall between two nodes. Coordinates are sin H (1 + (p/28)^2)^(1/4),
in which all lobes of p >> 28 are the same Gaussian exp(-14 u^2), and p / (p + 8): the last row is that Gaussian, and
what lobes differ by from it goes linearly to 0 with 1/p.
"""

from functools import cache

import numpy as np
import warp as wp

from metrics.kernels.making import made_once
from swimlab.render.brdf import Brdf, Model
from swimlab.render.brdfs.blinn_phong import FACTORS, BlinnPhongSettings
from swimlab.render.kernels.table import Doubles, Table, tabulated


def lobe(u: Doubles, v: Doubles) -> Doubles:
    """sat(N.H)^p by the table's coordinates; past the last column, where all but 1e-6 of a narrow lobe lies, 0."""
    power = 8 * v / np.maximum(1 - v, 1e-9)
    cosine_squared = 1 - u**2 / np.sqrt(1 + (power / 28) ** 2)
    return np.asarray(np.where((u == 1) & (power > 0), 0, cosine_squared ** (power / 2)))


@wp.func
def lobe_coordinates(sine: wp.float32, power: wp.float32) -> wp.vec2:
    """From the sine between N and H, N.H > 0, and the power to the table's 0..1."""
    ratio = power / 28.0
    return wp.vec2(sine * wp.sqrt(wp.sqrt(1.0 + ratio * ratio)), power / (power + 8.0))


@cache
def lobe_table() -> Table:
    """The lobe's table, 33 KB."""
    return tabulated(lobe, columns=129, rows=65)


@made_once
def factored(settings: BlinnPhongSettings) -> Model:
    """The model with its table."""
    factor = FACTORS[settings.normalisation]
    table = lobe_table()
    lobe_at = table.lookup

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        h = wp.normalize(light + view)
        specular = wp.float32(0.0)
        if h[2] > 0.0 or power == 0.0:
            place = lobe_coordinates(wp.sqrt(h[0] * h[0] + h[1] * h[1]), power)
            specular = lobe_at(place[0], place[1]) * factor(power) * ks
        lambert = wp.clamp(light[2], 0.0, 1.0) * diffuse
        return albedo * lambert + wp.vec3(specular, specular, specular)

    return Model(evaluate, slopes_are_gaussian=settings.normalisation == "deck", tables=(table,))


BRDF = Brdf(
    name="blinn-phong-factored",
    summary="blinn-phong by a table over (N.H, power)",
    source="Sloan & Baker, How Do We Evaluate a BRDF?",
    model=factored,
    settings=BlinnPhongSettings,
)
