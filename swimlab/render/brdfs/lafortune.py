"""Lafortune et al. 1997: a Lambertian body and n generalised cosine lobes.

C = pi f sat(N.L), f = Kd / pi + Ks sum_i n(n_i) sat(Cx Lx Vx + Cy Ly Vy + Cz Lz Vz)^n_i. Lobe i's exponent n_i is a
multiple of Blinn-Phong's power: a mirror's lobe (-1, -1, 1), whose angle moves twice as fast as the half vector's, is
as wide as Blinn-Phong's at a quarter of it. The normalisation is
none: 1, as the paper writes the lobes; a wider highlight is then a brighter one, so that techniques which widen
highlights add light, and Ks has no unit;
energy: (n_i + 2) / (2 pi), with which a mirror's lobe reflects Ks of the light at normal incidence.
Coefficients are in -1..1, so that no power overflows: a scale belongs in Ks. The sun's irradiance is pi, so the deck's
diffuse intensity is not used. Lobes are 0 where light or eye are below the surface.
"""

from typing import Literal

import numpy as np
import warp as wp
from pydantic import Field, field_validator

from metrics.kernels.making import made_once
from swimlab.render.brdf import Brdf, Model
from swimlab.render.kernels.shading import power_below_one
from swimlab.render.settings import Settings


class Lobe(Settings):
    """One lobe: its coefficients, and its exponent as a multiple of the power."""

    x: float = Field(-1.0, ge=-1, le=1, description="Cx, along the tangent (-1..1)")
    y: float = Field(-1.0, ge=-1, le=1, description="Cy, along the bitangent (-1..1)")
    z: float = Field(1.0, ge=-1, le=1, description="Cz, along the normal (-1..1)")
    exponent: float = Field(0.25, ge=0, le=16, description="exponent, times the power (0..16)")


class LafortuneSettings(Settings):
    """The lobes."""

    lobes: tuple[Lobe, ...] = Field((Lobe(),), description="the lobes, 1 to 8 tables (default: a mirror's)")

    normalisation: Literal["none", "energy"] = Field(
        "none", description="a lobe's factor: none (1) or energy ((n+2) / (2 pi), n its exponent)"
    )

    @field_validator("lobes")
    @classmethod
    def _a_few(cls, lobes: tuple[Lobe, ...]) -> tuple[Lobe, ...]:
        if not 1 <= len(lobes) <= 8:
            raise ValueError(f"{len(lobes)} lobes (there may be 1 to 8)")
        return lobes


@wp.func
def none(exponent: wp.float32) -> wp.float32:
    """1."""
    return wp.float32(1.0)


@wp.func
def energy(exponent: wp.float32) -> wp.float32:
    """(n + 2) / (2 pi)."""
    return (exponent + 2.0) / (2.0 * wp.PI)


FACTORS = {"none": none, "energy": energy}
"""Normalisations by name."""


@made_once
def with_lobes(settings: LafortuneSettings) -> Model:
    """The model of some lobes."""
    factor = FACTORS[settings.normalisation]
    count = len(settings.lobes)
    table = np.array([(lobe.x, lobe.y, lobe.z, lobe.exponent) for lobe in settings.lobes], np.float32)
    lobes = wp.types.matrix(shape=(count, 4), dtype=wp.float32)(table)

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        lambert = wp.clamp(light[2], 0.0, 1.0)
        total = wp.float32(0.0)
        if light[2] > 0.0 and view[2] > 0.0:
            for i in range(wp.static(count)):
                # 1 - base = sum ((L - C V)^2 + (1 - C^2) V^2) / 2 for unit L, V: no difference of near numbers.
                x = wp.float32(0.0)
                for k in range(3):
                    c = lobes[i, k]
                    apart = light[k] - c * view[k]
                    x += apart * apart + (1.0 - c * c) * view[k] * view[k]
                exponent = lobes[i, 3] * power
                total += power_below_one(wp.min(0.5 * x, 1.0), exponent) * factor(exponent)
        specular = wp.PI * ks * total * lambert
        return albedo * lambert + wp.vec3(specular, specular, specular)

    return Model(evaluate, anisotropic=any(lobe.x != lobe.y for lobe in settings.lobes))


BRDF = Brdf(
    name="lafortune",
    summary="generalised cosine lobes, as many as given",
    source="Lafortune, Foo, Torrance & Greenberg 1997, Non-Linear Approximation of Reflectance Functions",
    model=with_lobes,
    settings=LafortuneSettings,
)
