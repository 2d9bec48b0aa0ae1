"""Ashikhmin-Shirley (see `ashikhmin_shirley.py`) by four tables of two variables, in the manner of Kautz & McCool 1999.

They factor a sampled model numerically; this one factors by its formula, so that powers and anisotropy need no fit:
stretch (cos^2 of H's azimuth, N.H) -> k / sin H, k the sine at which an isotropic lobe of the power is as high;
lobe (k, power) -> (1 - k^2)^(power/2), as in `blinn_phong_factored.py`;
fresnel (H.V, Ks) -> F; body (N.L, N.V) -> the product of the diffuse term.
The divisions by H.V and max(N.L, N.V), which no table holds as they grow without bound, are computed. Ks is in 0..1.
"""

import numpy as np
import warp as wp

from metrics.kernels.making import made_once
from swimlab.render.brdf import Brdf, Model
from swimlab.render.brdfs.ashikhmin_shirley import LEAST_DIVISOR, AshikhminShirleySettings
from swimlab.render.brdfs.blinn_phong_factored import lobe_coordinates, lobe_table
from swimlab.render.kernels.table import Doubles, tabulated


def fresnel(cosine: Doubles, reflectance: Doubles) -> Doubles:
    """Schlick's approximation."""
    return np.asarray(reflectance + (1 - reflectance) * (1 - cosine) ** 5)


def body(cosine_light: Doubles, cosine_view: Doubles) -> Doubles:
    """The diffuse term's dependence on directions."""
    return np.asarray((1 - (1 - cosine_light / 2) ** 5) * (1 - (1 - cosine_view / 2) ** 5))


@made_once
def factored(settings: AshikhminShirleySettings) -> Model:
    """The model with its tables."""
    anisotropy = settings.anisotropy

    def stretch(along: Doubles, cosine: Doubles) -> Doubles:
        # (N.H)^(2 g) = 1 - k^2; k / sin H tends to sqrt(g) at the peak.
        g = along / anisotropy + (1 - along) * anisotropy
        cosine = np.clip(cosine, 1e-300, 1 - 1e-9)
        return np.asarray(np.sqrt((1 - cosine ** (2 * g)) / (1 - cosine**2)))

    tables = (
        tabulated(stretch, columns=65, rows=65),
        lobe_table(),
        tabulated(fresnel, columns=65, rows=2),
        tabulated(body, columns=33, rows=33),
    )
    stretch_at, lobe_at, fresnel_at, body_at = (table.lookup for table in tables)

    @wp.func(module="unique")
    def evaluate(
        albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
    ) -> wp.vec3:
        if light[2] <= 0.0 or view[2] <= 0.0:
            return wp.vec3(0.0, 0.0, 0.0)
        middle = light + view
        length = wp.max(wp.length(middle), 1.0e-6)
        cosine = 0.5 * length
        x = middle[0] / length
        y = middle[1] / length
        sine_squared = x * x + y * y
        sine = wp.sqrt(sine_squared)
        along = x * x / wp.max(sine_squared, 1.0e-30)
        place = lobe_coordinates(sine * stretch_at(along, middle[2] / length), power)
        scale = wp.sqrt((power / anisotropy + 1.0) * (power * anisotropy + 1.0)) / 8.0
        lobe = lobe_at(place[0], place[1]) * scale
        below = wp.max(cosine * wp.max(light[2], view[2]), LEAST_DIVISOR)
        specular = lobe * fresnel_at(cosine, ks) * light[2] / below
        lambert = 28.0 / 23.0 * wp.max(1.0 - ks, 0.0) * body_at(light[2], view[2]) * light[2]
        return albedo * lambert + wp.vec3(specular, specular, specular)

    return Model(evaluate, anisotropic=anisotropy != 1, tables=tables)


BRDF = Brdf(
    name="ashikhmin-shirley-factored",
    summary="ashikhmin-shirley by four tables",
    source="Kautz & McCool 1999, Interactive Rendering with Arbitrary BRDFs using Separable Approximations",
    model=factored,
    settings=AshikhminShirleySettings,
)
