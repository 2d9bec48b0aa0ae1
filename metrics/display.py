"""From linear radiance to what a display is sent: exposure, bloom, tone map, gamma, quantisation."""

from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from metrics import ocio
from metrics.bloom import Bloom

Domain = Literal["linear", "display"]
ToneMap = Literal["none", "reinhard", "aces"]
Gamma = Literal["srgb", "sqrt"]

BRIGHTEST = 1e30
"""Radiance above this is taken as this: sums and squares of it stay finite."""
BRIGHTEST_IN_VIEWS = 65504.0
"""The same for views of OpenColorIO, which reckon with halves."""


def encode(radiance: NDArray[Any]) -> NDArray[np.float64]:
    """sRGB code values in 0..1 of linear radiance, any shape: exposure 1, clamped to 0..1 (IEC 61966-2-1).

    >>> float(encode(np.array(1.0)))
    1.0
    """
    clamped = np.clip(np.asarray(radiance, dtype=np.float64), 0.0, 1.0)
    low = 12.92 * clamped
    return np.where(clamped <= 0.0031308, low, 1.055 * np.maximum(clamped, 0.0031308) ** (1 / 2.4) - 0.055)


def reinhard(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """x/(1 + x) of light >= 0, a channel at a time (Reinhard et al. 2002, Photographic Tone Reproduction, eq. 3)."""
    return light / (1.0 + light)


def aces(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fit of the ACES reference and output transforms, of light >= 0, in 0..1 (Narkowicz 2016, ACES Filmic Tone Curve).

    x(2.51 x + .03)/(x(2.43 x + .59) + .14). The author matches ACES's exposure by .6 x for x, which is the exposure's
    part here.
    """
    # From 7.25 on the fit lies above 1.
    x = np.minimum(light, 8.0)
    return np.minimum(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0)


@dataclass(frozen=True)
class Display:
    """How radiance is shown, in this order; as it stands, sRGB codes of radiance clamped to 0..1.

    exposure: stops, at most 20 either way. bloom: of exposed light. tone_map: "none" clamps. gamma: "srgb", or "sqrt",
    the square root that games took for it. view: "DISPLAY/VIEW" of OpenColorIO's configuration, in place of both.
    bits: codes are multiples of 1/(2^bits - 1), 1..16; None: not quantised. dither: adds an even noise of one code
    before quantising, which makes the mean exact (Roberts 1962, Picture Coding Using Pseudo-Random Noise). seed: of
    that noise, 0..2^32 - 1. Raises ValueError for values out of range, and for a view that no configuration has.
    """

    exposure: float = 0.0
    bloom: Bloom = field(default=Bloom())
    tone_map: ToneMap = "none"
    gamma: Gamma = "srgb"
    view: str | None = None
    bits: int | None = None
    dither: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        for key, choices in (("tone_map", get_args(ToneMap)), ("gamma", get_args(Gamma))):
            if getattr(self, key) not in choices:
                raise ValueError(f"{key} is {getattr(self, key)!r}; choose one of {', '.join(choices)}")
        if self.view is not None:
            if (self.tone_map, self.gamma) != ("none", "srgb"):
                raise ValueError("view has a tone map and a gamma of its own; leave out tone_map and gamma")
            ocio.find_view(self.view)
        if not abs(self.exposure) <= 20:
            raise ValueError(f"exposure is {self.exposure}; give stops, -20 to 20")
        if self.bits is not None and not 1 <= self.bits <= 16:
            raise ValueError(f"bits is {self.bits}; give 1 to 16, or None")
        if self.dither and self.bits is None:
            raise ValueError("dither is for quantised codes; give bits too")

    def curve(self, radiance: NDArray[Any]) -> NDArray[np.float64]:
        """Codes in 0..1 of radiance of any shape, without what depends on a pixel's neighbours, place or time.

        With a view [..., 3], or [..., 1] for grey; the codes are [..., 3].
        """
        light = self._exposed(radiance)
        return self._encoded(light) if self.view is None else self._viewed(light, self.view)

    def show(self, radiance: NDArray[Any], frame: int = 0) -> NDArray[np.float64]:
        """Codes in 0..1 of the radiance of a whole frame, [3, H, W]; dither differs from frame to frame."""
        light = self.bloom.spread(self._exposed(radiance))
        if self.view is None:
            codes = self._encoded(light)
        else:
            codes = np.ascontiguousarray(np.moveaxis(self._viewed(np.moveaxis(light, 0, -1), self.view), -1, 0))
        if self.bits is None:
            return codes
        steps = 2**self.bits - 1
        height, width = codes.shape[1:]
        noise = _even_noise(height, width, frame, self.seed) if self.dither else 0.5
        return np.asarray(np.floor(codes * steps + noise) / steps)

    def _exposed(self, radiance: NDArray[Any]) -> NDArray[np.float64]:
        light = np.clip(np.asarray(radiance, dtype=np.float64), 0.0, BRIGHTEST)
        return np.asarray(light * 2.0**self.exposure)

    @staticmethod
    def _viewed(light: NDArray[np.float64], name: str) -> NDArray[np.float64]:
        """Codes [..., 3] of light [..., 3] or [..., 1] under a view; light is held at what halves can hold."""
        colours = np.broadcast_to(np.minimum(light, BRIGHTEST_IN_VIEWS), (*light.shape[:-1], 3))
        codes = ocio.show(colours.reshape(1, -1, 3), ocio.find_view(name))
        return np.clip(codes.astype(np.float64), 0.0, 1.0).reshape(colours.shape)

    def _encoded(self, light: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.tone_map == "reinhard":
            light = reinhard(light)
        elif self.tone_map == "aces":
            light = aces(light)
        return encode(light) if self.gamma == "srgb" else np.sqrt(np.minimum(light, 1.0))


STANDARD = Display()
"""sRGB codes, exposure 1."""


def to_domain(radiance: NDArray[Any], domain: Domain, display: Display = STANDARD, frame: int = 0) -> NDArray[Any]:
    """A frame [3, H, W]: its radiance itself in the linear domain, what is shown of it in the display domain.

    Raises ValueError for other domains.
    """
    if domain not in get_args(Domain):
        raise ValueError(f"domain is {domain!r}; choose one of {', '.join(get_args(Domain))}")
    return display.show(radiance, frame) if domain == "display" else radiance


def _even_noise(height: int, width: int, frame: int, seed: int) -> NDArray[np.float64]:
    """[3, H, W] even in 0..1, by a hash of pixel, frame and seed (pcg3d: Jarzynski & Olano 2020, Hash Functions for
    GPU Rendering).
    """
    row, column = np.indices((height, width), dtype=np.uint32)
    moment = np.full((height, width), (frame + seed * 0x9E3779B9) % 2**32, np.uint32)
    v = np.stack([column, row, moment]) * np.uint32(1664525) + np.uint32(1013904223)
    _mix(v)
    v ^= v >> np.uint32(16)
    _mix(v)
    return v / 2.0**32


def _mix(v: NDArray[np.uint32]) -> None:
    v[0] += v[1] * v[2]
    v[1] += v[2] * v[0]
    v[2] += v[0] * v[1]
