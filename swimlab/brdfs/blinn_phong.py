"""Blinn-Phong with the deck's normalisation (Blinn 1977; Sloan & Baker): C = sat(N.H)^p p Ks + sat(N.L) diffuse Kd.

The specular term is not gated by N.L: this is the deck's radiance as written.
"""

import warp as wp

from swimlab.brdf import Brdf
from swimlab.kernels.shading import power_of_cosine
from swimlab.kernels.structs import Texel


@wp.func
def evaluate(texel: Texel, normal: wp.vec3, light: wp.vec3, view: wp.vec3, diffuse: wp.float32) -> wp.vec3:
    """Radiance in the local frame; `light` and `view` are unit vectors away from the surface."""
    power = texel[7]
    specular = power_of_cosine(normal, wp.normalize(light + view), power) * power * texel[6]
    lambert = wp.clamp(wp.dot(normal, light), 0.0, 1.0) * diffuse
    return wp.vec3(texel[0], texel[1], texel[2]) * lambert + wp.vec3(specular, specular, specular)


BRDF = Brdf(
    name="blinn-phong",
    summary="Blinn-Phong with the deck's normalisation by the power",
    source="Blinn 1977; Sloan & Baker, Part II: Techniques",
    evaluate=evaluate,
)
