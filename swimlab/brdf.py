"""What a reflectance model is."""

from dataclasses import dataclass

import warp as wp


@dataclass(frozen=True)
class Brdf:
    """A reflectance model: `evaluate(texel, normal, light, view, diffuse)` gives radiance in the local frame."""

    name: str
    summary: str
    source: str
    evaluate: wp.Function
