"""Building a mip chain: every texel of a level is the mean of the 2x2 below it."""

from typing import Any

import warp as wp

from swimlab.render.kernels.sampling import fetch
from swimlab.render.kernels.structs import TEXELS, Chain

wp.set_module_options({"enable_backward": False})


@wp.kernel
def halve(level: wp.int32, chain: Chain, texels: wp.array(dtype=Any)):
    """Fill one texel of `level` from the level below; a side that is already 1 texel long stays so."""
    j, i = wp.tid()
    below = level - 1
    right = wp.min(2 * i + 1, wp.max(chain.width >> below, 1) - 1)
    lower = wp.min(2 * j + 1, wp.max(chain.height >> below, 1) - 1)
    total = fetch(texels, chain, below, 2 * i, 2 * j) + fetch(texels, chain, below, right, 2 * j)
    total += fetch(texels, chain, below, 2 * i, lower) + fetch(texels, chain, below, right, lower)
    texels[chain.offsets[level] + j * wp.max(chain.width >> level, 1) + i] = total * 0.25


HALVE = {
    dtype: wp.overload(halve, {"level": wp.int32, "chain": Chain, "texels": wp.array(dtype=dtype)})
    for dtype in TEXELS.values()
}
"""`halve` for every kind of texel."""
