"""Banks 1994, strands along the tangent T: C = sat(d)^p sat(N.L) Ks + sat(N.L) diffuse Kd, d the cosine of the angle
between the eye and the cone of mirrored light: d = sqrt(1 - (L.T)^2) sqrt(1 - (V.T)^2) - (L.T) (V.T).

The deck's radiance as written: the specular term has no normalisation, and p is Blinn-Phong's power as it is.
"""

import warp as wp

from swimlab.brdf import Brdf, Model
from swimlab.kernels.shading import power_of_cosine


@wp.func
def evaluate(
    albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
) -> wp.vec3:
    """Radiance; `light` and `view` are unit vectors away from the surface in the local frame.

    With L.T = sin a and V.T = sin b, d = cos(a + b); the power is taken of its sine.
    """
    cosine_a = wp.sqrt(light[1] * light[1] + light[2] * light[2])
    cosine_b = wp.sqrt(view[1] * view[1] + view[2] * view[2])
    sine = light[0] * cosine_b + view[0] * cosine_a
    d = cosine_a * cosine_b - light[0] * view[0]
    lambert = wp.clamp(light[2], 0.0, 1.0)
    specular = power_of_cosine(wp.vec3(sine, 0.0, d), power) * lambert * ks
    return albedo * (lambert * diffuse) + wp.vec3(specular, specular, specular)


MODEL = Model(evaluate, anisotropic=True)

BRDF = Brdf(
    name="banks",
    summary="strands along the tangent, a highlight across them",
    source="Banks 1994, Illumination in Diverse Codimensions",
    model=lambda settings: MODEL,
)
