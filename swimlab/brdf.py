"""What a reflectance model is."""

from dataclasses import dataclass

import warp as wp


@dataclass(frozen=True)
class Brdf:
    """A reflectance model.

    evaluate: (texel, normal, light, view, diffuse) -> radiance in the local frame, the model as it is read.
    native: (lanes, sun), the same over a packet of samples in a form that a CPU compiler vectorises; None without one.
    """

    name: str
    summary: str
    source: str
    evaluate: wp.Function
    native: wp.Function | None = None
