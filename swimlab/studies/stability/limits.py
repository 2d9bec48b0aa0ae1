"""The limits that are left in formulas: where, why, how often they act, and what they do then."""

from typing import NamedTuple

import numpy as np

from metrics.kernels.launch import Launcher
from swimlab.render.inputs import LEAST_POWER, STEEPEST, Maps, slopes
from swimlab.render.kernels.raster import NEAR
from swimlab.render.material import Material
from swimlab.render.techniques import clean, toksvig
from swimlab.studies.stability.moments import SIDE, sloping

ROUNDING = 2.4e-7
"""Least variance over second moment that CLEAN and LEAN believe."""


class Limit(NamedTuple):
    """A limit: what is limited, why, the share of inputs that it touches (None: not counted), what it does there."""

    what: str
    why: str
    touched: float | None
    effect: str


def limits(launcher: Launcher, maps: Maps) -> list[Limit]:
    """The remaining limits. Limits of moments are counted over all levels of the chains of some maps."""
    return [*_of_moments(launcher, maps), *_of_highlights(), *_of_sampling()]


def _of_moments(launcher: Launcher, maps: Maps) -> list[Limit]:
    material = Material(launcher, maps)
    normals = material.chain(toksvig.INPUTS).texels.numpy()[:, 3:6].astype(np.float64)
    length = np.linalg.norm(normals, axis=1)
    longer = max(float(length.max()) - 1, 0.0)
    moments = material.chain(clean.INPUTS).texels.numpy().astype(np.float64)
    variance = (moments[:, 5] - moments[:, 3] ** 2 - moments[:, 4] ** 2) / 2
    about, centre, _ = slopes(maps)
    steep = np.linalg.norm(about + centre, axis=2) >= STEEPEST * (1 - 1e-6)
    flattest = np.degrees(np.arctan(1 / STEEPEST))
    return [
        Limit(
            f"powers below {LEAST_POWER:g} count as that where 1/power is filtered",
            "1/0 has no mean",
            float(np.mean(maps.gloss[..., 1] < LEAST_POWER)),
            f"a highlight of power 0, which is black, has a radiance of {LEAST_POWER:g} Ks",
        ),
        Limit(
            f"LEAN, CLEAN: slopes are cut to {STEEPEST:g}",
            "a normal that lies flat has an infinite slope, which would be all of a mean",
            float(np.mean(steep)),
            f"normals within {flattest:.1f} degrees of the ground count as {flattest:.1f} degrees above it",
        ),
        Limit(
            "Toksvig, vMF: lengths of mean normals are cut to 1e-6..1",
            "rounding makes a mean of unit vectors longer than 1; one of length 0 has no direction",
            float(np.mean((length > 1) | (length < 1e-6))),
            f"the longest is 1 + {longer:.1e}: without the cut a power of 1e5 would grow by {1e5 * longer:.1e}",
        ),
        Limit(
            f"LEAN, CLEAN: variances, and LEAN's determinant, are at least {ROUNDING:g} of the terms they differ by",
            "less than that is rounding, and may come out negative",
            float(np.mean(variance < moments[:, 5] * ROUNDING)),
            f"on smooth slopes of {STEEPEST:g} and -{STEEPEST:g}, the worst there is, of a power of 1e5 one of "
            f"{_steep_plateaus(launcher):,.0f} is left",
        ),
    ]


def _steep_plateaus(launcher: Launcher) -> float:
    """Power that CLEAN leaves of 1e5 where two plateaus lean both ways, so that the map's mean helps none of them."""
    apart = np.zeros((SIDE, SIDE, 2))
    apart[..., 0] = np.where(np.arange(SIDE) < SIDE // 2, STEEPEST, -STEEPEST)
    texel = Material(launcher, sloping(apart, power=1e5)).chain(clean.INPUTS).texels.numpy()[0].astype(np.float32)
    second = texel[5] - texel[3] * texel[3] - texel[4] * texel[4]
    return float(2 / max(second, texel[5] * np.float32(ROUNDING)))


def _of_highlights() -> list[Limit]:
    darkest = float(np.exp2(np.float32(-126)))
    return [
        Limit(
            "vectorised Blinn-Phong: 2^x is cut at x = -126",
            "smaller numbers lose their digits, and are slow",
            None,
            f"a highlight is never darker than {darkest:.1e} p Ks",
        ),
        Limit(
            "Cook-Torrance: no highlight where N.H is below 1e-3; there and in Ashikhmin-Shirley L + V is 1e-6 or more",
            "tan of the angle between H and N, and 1/(H.V), are infinite there",
            None,
            "the lobe there is exp(-1.5e6) and less; light and eye so nearly opposite both graze the ground to 1e-6",
        ),
        Limit(
            "LEAN: no highlight where H lies within 1e-6 of the ground",
            "its slope is infinite there",
            None,
            "slopes are cut to 8, and the Gaussian of one of 1e6 is 0",
        ),
        Limit(
            "tangents within 1e-6 of the normal are replaced by the road's",
            "they have no direction beside it",
            None,
            "the highlight of a map of twist may turn on a normal that lies flat along its own tangent",
        ),
    ]


def _of_sampling() -> list[Limit]:
    return [
        Limit(
            "pixel-point: places within 1e-9 of a texel's edge are beyond it",
            "a place right on an edge would fall to either side by rounding",
            None,
            "an edge is drawn 1e-9 texels off",
        ),
        Limit(
            "vertex: interpolated light is at least 0",
            "the weights of vertices in the dark may round to less",
            None,
            "black stays black",
        ),
        Limit(
            "TSL: light is divided by alpha only where that is above 1e-5",
            "the deck's rule",
            None,
            "see *Targets that are hardly covered*",
        ),
        Limit(
            f"what is nearer than {NEAR * 100:g} cm along the camera's axis is not drawn",
            "1/w is infinite in the eye plane",
            None,
            "an eye so close to the road sees through it",
        ),
    ]
