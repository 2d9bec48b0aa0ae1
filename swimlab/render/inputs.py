"""Inputs of shading: how the maps are packed into a mip chain, and what a filtered texel means."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from swimlab.render.kernels.packet import each_resolved, resolved

Map = NDArray[np.float32]


class Maps(NamedTuple):
    """The material's maps, all of one size.

    albedo: [h, w, 3], linear. normal: [h, w, 3], tangent space. gloss: [h, w, 2], Ks and power.
    twist: [h, w, 2], x and y of the tangent; None without one.
    """

    albedo: Map
    normal: Map
    gloss: Map
    twist: Map | None = None


class Level(NamedTuple):
    """Level 0 of a chain: texels [h, w, n], and the slope that moments in them are taken about."""

    texels: Map
    centre: tuple[float, float] = (0.0, 0.0)


def boxed(maps: Maps) -> Level:
    """Values as they are: albedo, normal, Ks, power."""
    return Level(np.concatenate([maps.albedo, maps.normal, maps.gloss], axis=2, dtype=np.float32))


LEAST_POWER = 1e-4
"""Powers are raised to this where 1/power is filtered, as 1/0 is not finite; the highlight is as black."""

STEEPEST = 8.0
"""Slopes N.xy / N.z of normals that lie flatter than 83 degrees from upright are cut to this."""


def variances(maps: Maps) -> Level:
    """As `boxed`, but with unit normals, and in place of the power the variance of slopes 1/power, as variances add up.

    The length of a mean of normals shows how they spread. The length of a single normal means nothing: 8-bit codes are
    off 1 by up to .007, which would widen a highlight of power 1000 five times.
    """
    packed = boxed(maps).texels.copy()
    length = np.linalg.norm(maps.normal.astype(np.float64), axis=2, keepdims=True)
    packed[..., 3:6] = maps.normal / np.where(length > 0, length, 1)
    packed[..., 7] = 1 / np.maximum(packed[..., 7], LEAST_POWER)
    return Level(packed)


def slopes(maps: Maps) -> tuple[NDArray[np.float64], tuple[float, float], NDArray[np.float64]]:
    """Slopes b = N.xy / N.z [h, w, 2] less their mean over the map, that mean, and 1/power [h, w, 1].

    They are taken about their mean because M - b b^T of large slopes would cancel to nothing in float32.
    """
    normal = maps.normal.astype(np.float64)
    b = normal[..., :2] / np.maximum(normal[..., 2:], 1e-6)
    b *= np.minimum(1, STEEPEST / np.maximum(np.linalg.norm(b, axis=2, keepdims=True), STEEPEST))
    mean = b.mean(axis=(0, 1)).astype(np.float32).astype(np.float64)
    return (
        b - mean,
        (float(mean[0]), float(mean[1])),
        1 / np.maximum(maps.gloss[..., 1:].astype(np.float64), LEAST_POWER),
    )


@dataclass(frozen=True)
class Inputs:
    """How maps are filtered.

    pack: the texels of level 0; every coarser one is the mean of four. The twist, where there is one, is appended.
    resolve: (texel, chain) -> texel, from filtered moments to the texel that is shaded; None: they are the same.
    reflect: (texel, light, view, diffuse) -> radiance in the road's tangent frame: a lobe in place of the scene's
        reflectance model, for models whose slopes are Gaussian.
    otherwise: the inputs for other models and for maps with twist.
    native: (lanes, sun), the native form of that lobe over a packet.
    resolve_lanes: (lanes, chain, count), the native form of `resolve` over a packet.
    """

    name: str
    pack: Callable[[Maps], Level] = field(default=boxed)
    resolve: wp.Function | None = None
    reflect: wp.Function | None = None
    native: wp.Function | None = None
    otherwise: "Inputs | None" = None
    resolve_lanes: wp.Function | None = None

    def after(self, fill: wp.Function, width: int, device: str) -> wp.Function:
        """The filling of a packet with texels of `width` floats by a filter, and what they mean then."""
        if self.resolve is None:
            return fill
        native = self.resolve_lanes if device == "cpu" else None
        return resolved(fill, native or each_resolved(self.resolve, width), width)


BOX = Inputs("box")
"""Means of the values themselves, as in an engine's mip chain. Mean normals are not normalised."""
