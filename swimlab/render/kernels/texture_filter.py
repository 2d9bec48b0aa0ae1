"""Texture filters: what sets one technique apart from another."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import warp as wp

from swimlab.render.kernels import native_filters, sampling
from swimlab.render.kernels.packet import each_lane


@dataclass(frozen=True)
class TextureFilter:
    """A filter of inputs.

    plain: (texels, chain, surface) -> texel, as it is read. native: width -> the same over a packet of texels of so
    many floats, in a form for CPUs; None without one.
    """

    plain: wp.Function
    native: Callable[[int], wp.Function] | None = None

    def fill(self, width: int, device: str) -> wp.Function:
        """What fills a packet: the native form on the CPU where there is one, else the plain one lane by lane."""
        if self.native is not None and device == "cpu":
            return self.native(width)
        return each_lane(self.plain, width)


FINEST = TextureFilter(sampling.finest, native_filters.finest)
"""The four texels of level 0 about uv."""

ISOTROPIC = TextureFilter(sampling.isotropic, native_filters.isotropic)
"""Two levels about log2 of the longer derivative."""


@cache
def anisotropic_to(most: int) -> TextureFilter:
    """Up to `most` trilinear probes along the footprint's major axis."""
    return TextureFilter(sampling.anisotropic_to(most), lambda width: native_filters.anisotropic(width, most))
