"""Ashikhmin & Shirley 2000: an anisotropic lobe over a diffuse term that loses the light that the lobe reflects.

C = pi (rho_s + rho_d) sat(N.L), 0 where light or eye are below the surface, with
rho_s = sqrt((nu+1)(nv+1)) / (8 pi) (N.H)^((nu (H.T)^2 + nv (H.B)^2) / (1 - (N.H)^2)) / (H.V max(N.L, N.V)) F(H.V)
rho_d = 28 Kd / (23 pi) (1 - Ks) (1 - (1 - N.L/2)^5) (1 - (1 - N.V/2)^5)
and F Schlick's approximation from Ks, the reflectance at normal incidence (0..1). nu = power / anisotropy and
nv = power anisotropy: above 1 the highlight is drawn out along the tangent. The sun's irradiance is pi, so the deck's
diffuse intensity is not used.
"""

import warp as wp
from pydantic import Field

from metrics.kernels.making import made_once
from swimlab.render.brdf import Brdf, Model
from swimlab.render.kernels.shading import power_of_cosine
from swimlab.render.settings import Settings

LEAST_DIVISOR = 1e-30
"""H.V max(N.L, N.V) is no less, as it would underflow to 0 where light and eye lie in the horizon, opposite."""


class AshikhminShirleySettings(Settings):
    """How the highlight is drawn out."""

    anisotropy: float = Field(
        1.0, ge=1 / 16, le=16, description="sqrt(nv / nu); above 1 the highlight is longer along the tangent (1/16..16)"
    )


@wp.func
def schlick(reflectance: wp.float32, cosine: wp.float32) -> wp.float32:
    """Fresnel reflectance by its value at normal incidence (Schlick 1994)."""
    rest = wp.clamp(1.0 - cosine, 0.0, 1.0)
    return reflectance + (1.0 - reflectance) * rest * rest * rest * rest * rest


@wp.func
def entering(cosine: wp.float32) -> wp.float32:
    """1 - (1 - cosine/2)^5."""
    rest = 1.0 - 0.5 * cosine
    return 1.0 - rest * rest * rest * rest * rest


@made_once
def direct(settings: AshikhminShirleySettings) -> Model:
    """The formula as it stands."""
    anisotropy = settings.anisotropy

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        if light[2] <= 0.0 or view[2] <= 0.0:
            return wp.vec3(0.0, 0.0, 0.0)
        middle = light + view
        length = wp.max(wp.length(middle), 1.0e-6)
        h = middle / length
        cosine = 0.5 * length
        nu = power / anisotropy
        nv = power * anisotropy
        sine_squared = h[0] * h[0] + h[1] * h[1]
        along = wp.float32(0.5)
        if sine_squared > 0.0:
            along = h[0] * h[0] / sine_squared
        lobe = power_of_cosine(h, nu * along + nv * (1.0 - along)) * wp.sqrt((nu + 1.0) * (nv + 1.0)) / 8.0
        below = wp.max(cosine * wp.max(light[2], view[2]), LEAST_DIVISOR)
        specular = lobe * schlick(ks, cosine) * light[2] / below
        body = 28.0 / 23.0 * wp.max(1.0 - ks, 0.0) * entering(light[2]) * entering(view[2]) * light[2]
        return albedo * body + wp.vec3(specular, specular, specular)

    return Model(evaluate, anisotropic=anisotropy != 1)


BRDF = Brdf(
    name="ashikhmin-shirley",
    summary="anisotropic Phong lobe with Fresnel over a diffuse body",
    source="Ashikhmin & Shirley 2000, An Anisotropic Phong BRDF Model",
    model=direct,
    settings=AshikhminShirleySettings,
)
