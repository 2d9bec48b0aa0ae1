"""What a mip chain's coarsest texel stands for."""

import functools
from typing import Any

import warp as wp

from swimlab.render.kernels.structs import Chain


@functools.cache
def resolve_coarsest(resolve: wp.Function) -> wp.Kernel:
    """The kernel that resolves the moments of the last texel of a chain."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(chain: Chain, texels: wp.array(dtype=Any), out: wp.array(dtype=Any)):
        out[0] = resolve(texels[chain.offsets[chain.levels - 1]], chain)

    return kernel
