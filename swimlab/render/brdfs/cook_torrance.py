"""Cook & Torrance 1982: microfacets of Beckmann's distribution between V-shaped grooves, over a Lambertian body.

C = pi f sat(N.L), f = Kd / pi + F D G / (4 N.L N.V), with D = exp(-tan^2 a / m^2) / (pi m^2 cos^4 a), a between N and
H, G = min(1, 2 N.H N.V / V.H, 2 N.H N.L / V.H), and F Schlick's approximation from Ks, the reflectance at normal
incidence (0..1). The 1982 paper has pi for the 4 and D without its 1/pi, which is four times as bright.
m = sqrt(2 / (power + 2)), with which D peaks as high as Blinn-Phong's normalised distribution. The sun's irradiance is
pi, so the deck's diffuse intensity is not used. The microfacets' term is 0 where light or eye are below the
surface.
"""

import warp as wp

from swimlab.render.brdf import Brdf, Model
from swimlab.render.brdfs.ashikhmin_shirley import schlick


@wp.func
def evaluate(
    albedo: wp.vec3, ks: wp.float32, power: wp.float32, light: wp.vec3, view: wp.vec3, diffuse: wp.float32
) -> wp.vec3:
    """Radiance; `light` and `view` are unit vectors away from the surface in the local frame."""
    lambert = wp.clamp(light[2], 0.0, 1.0)
    specular = wp.float32(0.0)
    middle = light + view
    length = wp.max(wp.length(middle), 1.0e-6)
    h = middle / length
    # Flatter half vectors than 1e-3 have exp(-1e6).
    if light[2] > 0.0 and view[2] > 0.0 and h[2] > 1.0e-3:
        cosine = 0.5 * length
        squared = h[2] * h[2]
        smoothness = 0.5 * (power + 2.0)
        tangent_squared = (h[0] * h[0] + h[1] * h[1]) / squared
        distribution = smoothness * wp.exp(-tangent_squared * smoothness) / (squared * squared)
        groove = 2.0 * h[2] / cosine
        shadowing = wp.min(wp.min(1.0 / view[2], groove), groove * light[2] / view[2])
        specular = 0.25 * schlick(ks, cosine) * distribution * shadowing
    return albedo * lambert + wp.vec3(specular, specular, specular)


MODEL = Model(evaluate)

BRDF = Brdf(
    name="cook-torrance",
    summary="microfacets of Beckmann's distribution with Fresnel and shadowing",
    source="Cook & Torrance 1982, A Reflectance Model for Computer Graphics",
    model=lambda settings: MODEL,
)
