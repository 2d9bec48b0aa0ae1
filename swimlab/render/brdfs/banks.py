"""Banks 1994, strands along the tangent T: C = sat(d)^n sat(N.L) k(n) Ks + sat(N.L) diffuse Kd.

d = sqrt(1 - (L.T)^2) sqrt(1 - (V.T)^2) - (L.T) (V.T), the cosine between the eye and the cone of mirrored light.
The exponent n is a multiple of Blinn-Phong's power: 1 as the deck writes it. The cone moves twice as fast as the strand
tilts where light and eye stand high, so at 1/4 the highlight is then as wide over slopes as Blinn-Phong's.
The normalisation k(n) is
none: 1, the deck's radiance as written; a wider highlight is then a brighter one, so that techniques which widen
highlights add light;
energy: sqrt((2 n + 5) / (16 pi)), with which Ks of the light is reflected, seen from across the strands, to 1% at
n = 0 and better at larger n.
"""

from typing import Literal

import warp as wp
from pydantic import Field

from metrics.kernels.making import made_once
from swimlab.render.brdf import Brdf, Model
from swimlab.render.kernels.shading import power_of_cosine
from swimlab.render.settings import Settings


class BanksSettings(Settings):
    """How wide and how bright the highlight is."""

    exponent: float = Field(1.0, ge=0, le=16, description="the lobe's exponent, times the power (0..16)")
    normalisation: Literal["none", "energy"] = Field(
        "none", description="the lobe's factor: none (1) or energy (sqrt((2n+5) / (16 pi)), n its exponent)"
    )


@wp.func
def none(exponent: wp.float32) -> wp.float32:
    """1."""
    return wp.float32(1.0)


@wp.func
def energy(exponent: wp.float32) -> wp.float32:
    """sqrt((2 n + 5) / (16 pi))."""
    return wp.sqrt((2.0 * exponent + 5.0) / (16.0 * wp.PI))


FACTORS = {"none": none, "energy": energy}
"""Normalisations by name."""


@made_once
def direct(settings: BanksSettings) -> Model:
    """The formula as it stands."""
    factor = FACTORS[settings.normalisation]
    times = settings.exponent

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        # With L.T = sin a and V.T = sin b, d = cos(a + b); the power is taken of its sine.
        cosine_a = wp.sqrt(light[1] * light[1] + light[2] * light[2])
        cosine_b = wp.sqrt(view[1] * view[1] + view[2] * view[2])
        sine = light[0] * cosine_b + view[0] * cosine_a
        d = cosine_a * cosine_b - light[0] * view[0]
        lambert = wp.clamp(light[2], 0.0, 1.0)
        exponent = times * power
        specular = power_of_cosine(wp.vec3(sine, 0.0, d), exponent) * lambert * factor(exponent) * ks
        return albedo * (lambert * diffuse) + wp.vec3(specular, specular, specular)

    return Model(evaluate, anisotropic=True)


BRDF = Brdf(
    name="banks",
    summary="strands along the tangent, a highlight across them",
    source="Banks 1994, Illumination in Diverse Codimensions",
    model=direct,
    settings=BanksSettings,
)
