"""Which surface the frame before shows at each pixel: pixels of this frame claim the places that they come from."""

import warp as wp

from metrics.kernels.forms import Twins, form
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

_CLAIM = """
    const int height = motion.shape[0], width = motion.shape[1];
    const float* const moves = (const float*)motion.data + 2*(long)row*width;
    const unsigned char* const seen = (const unsigned char*)shown.data + (long)row*width;
    float *const low = (float*)least.data, *const high = (float*)most.data;
    for (int column = 0; column < width; ++column) {
        const float dx = moves[2*column], dy = moves[2*column + 1];
        const float x = __builtin_rintf((float)column - dx), y = __builtin_rintf((float)row - dy);
        if (!seen[column] || !(x >= 0.0f && y >= 0.0f && x < (float)width && y < (float)height)) continue;
        const long place = 2*((long)y*width + (long)x);
        low[place] = dx < low[place] ? dx : low[place];
        low[place + 1] = dy < low[place + 1] ? dy : low[place + 1];
        high[place] = dx > high[place] ? dx : high[place];
        high[place + 1] = dy > high[place + 1] ? dy : high[place + 1];
    }
"""


@form()
def row_claims() -> Twins:
    """The function in which every pixel shown of a row claims the place that it comes from.

    motion: [H, W], px since the frame before. least, most: [H, W], of the motions that claim a place.
    """

    @wp.func(module="unique")
    def claim(
        row: wp.int32,
        motion: wp.array2d(dtype=wp.vec2),
        shown: wp.array2d(dtype=wp.uint8),
        least: wp.array2d(dtype=wp.vec2),
        most: wp.array2d(dtype=wp.vec2),
    ):
        for column in range(motion.shape[1]):
            if shown[row, column] != wp.uint8(0):
                moved = motion[row, column]
                x = wp.int32(wp.rint(wp.float32(column) - moved[0]))
                y = wp.int32(wp.rint(wp.float32(row) - moved[1]))
                if x >= 0 and y >= 0 and x < motion.shape[1] and y < motion.shape[0]:
                    wp.atomic_min(least, y, x, moved)
                    wp.atomic_max(most, y, x, moved)

    return Twins(claim, _CLAIM)


@made_once
def claim_rows(device: str) -> wp.Kernel:
    """The kernel that runs `row_claims`, a row a thread.

    It writes where others may write too: on the CPU it is launched once, for all rows.
    """
    claim = row_claims().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        motion: wp.array2d(dtype=wp.vec2),
        shown: wp.array2d(dtype=wp.uint8),
        least: wp.array2d(dtype=wp.vec2),
        most: wp.array2d(dtype=wp.vec2),
    ):
        claim(wp.tid(), motion, shown, least, most)

    return kernel


_OWN = """
    const long here = (long)row*motion.shape[1];
    const float* const low = (const float*)least.data + 2*here;
    const float* const high = (const float*)most.data + 2*here;
    const float* const moves = (const float*)motion.data + 2*here;
    const unsigned char* const seen = (const unsigned char*)covered.data + here;
    float* const to = (float*)owner.data + 2*here;
    for (int column = 0; column < motion.shape[1]; ++column) {
        const int x = 2*column, y = x + 1;
        const bool one = high[x] - low[x] <= alike && high[y] - low[y] <= alike && high[x] >= low[x];
        const float nan = __builtin_nanf("");
        to[x] = !seen[column] ? nan : one ? (low[x] + high[x])/2.0f : moves[x];
        to[y] = !seen[column] ? nan : one ? (low[y] + high[y])/2.0f : moves[y];
    }
"""


@form()
def row_owners() -> Twins:
    """The function that finds the motion into this frame of what a row's pixels of the frame before show.

    That of the pixels that claim it where they agree within `alike` px, else what the frame before has itself.
    owner: [H, W], px; NaN where it is not known. It may be `least` itself.
    """

    @wp.func(module="unique")
    def settle(
        row: wp.int32,
        least: wp.array2d(dtype=wp.vec2),
        most: wp.array2d(dtype=wp.vec2),
        motion: wp.array2d(dtype=wp.vec2),
        covered: wp.array2d(dtype=wp.uint8),
        alike: wp.float32,
        owner: wp.array2d(dtype=wp.vec2),
    ):
        for column in range(motion.shape[1]):
            low = least[row, column]
            high = most[row, column]
            found = motion[row, column]
            # Where nothing claims the place these are infinite, and no comparison holds.
            if high[0] - low[0] <= alike and high[1] - low[1] <= alike and high[0] >= low[0]:
                found = (low + high) / 2.0
            if covered[row, column] == wp.uint8(0):
                found = wp.vec2(wp.nan, wp.nan)
            owner[row, column] = found

    return Twins(settle, _OWN)


@made_once
def own_places(device: str) -> wp.Kernel:
    """The kernel that runs `row_owners`, a row a thread."""
    settle = row_owners().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(
        first: wp.int32,
        least: wp.array2d(dtype=wp.vec2),
        most: wp.array2d(dtype=wp.vec2),
        motion: wp.array2d(dtype=wp.vec2),
        covered: wp.array2d(dtype=wp.uint8),
        alike: wp.float32,
        owner: wp.array2d(dtype=wp.vec2),
    ):
        settle(first + wp.tid(), least, most, motion, covered, alike, owner)

    return kernel
