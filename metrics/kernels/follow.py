"""Surfaces followed from frame to frame: places are px (x, y) away from each pixel of the frame that is followed."""

from typing import NamedTuple

import warp as wp

from metrics.kernels.making import made_once
from metrics.kernels.splines import field_value

wp.set_module_options({"enable_backward": False})

_TOLERANCE = wp.constant(1e-4)
_ROUNDS = wp.constant(30)


class Steps(NamedTuple):
    """Kernels over rows of pixels, from one frame to the next.

    back, ahead: (first, field, top, away[, moved, lost, usable]): places one frame earlier or later, in place. field:
    cubic coefficients of the motion between both frames; top: the frame's row that row 0 of away is. moved: how far the
    places went at the last step, a guess of how far they go. What is still `lost` px or more off is not usable.
    glue_back: (first, field, later, away), glue_ahead: (first, motion, earlier, away): how far from each pixel of a
    frame its surface is in the middle frame, from coefficients of the same in the frame after, or before; the motion is
    that between both.
    """

    back: wp.Kernel
    ahead: wp.Kernel
    glue_back: wp.Kernel
    glue_ahead: wp.Kernel


@made_once
def steps(device: str) -> Steps:
    """The kernels for a device."""
    take = field_value().on(device)

    @wp.func(module="unique")
    def solve(
        field: wp.array2d(dtype=wp.vec2), row: wp.int32, column: wp.int32, away: wp.vec2, guess: wp.vec2
    ) -> wp.vec3:
        """Where the surface at a place will be in the frame whose motion the field is: q - field(q) = place.

        By fixed-point iteration. The third part is the last step's length, px: it stays long where a surface is covered
        up and has no place.
        """
        next = away + guess
        moved = wp.float32(0.0)
        for _ in range(_ROUNDS):
            better = away + take(field, row, column, next)
            moved = wp.max(wp.abs(better[0] - next[0]), wp.abs(better[1] - next[1]))
            next = better
            if moved < _TOLERANCE:
                return wp.vec3(next[0], next[1], moved)
        return wp.vec3(next[0], next[1], moved)

    @wp.kernel(module="unique", enable_backward=False)
    def back(first: wp.int32, field: wp.array2d(dtype=wp.vec2), top: wp.int32, away: wp.array2d(dtype=wp.vec2)):
        line, column = wp.tid()
        line += first
        away[line, column] = away[line, column] - take(field, top + line, column, away[line, column])

    @wp.kernel(module="unique", enable_backward=False)
    def ahead(
        first: wp.int32,
        field: wp.array2d(dtype=wp.vec2),
        top: wp.int32,
        away: wp.array2d(dtype=wp.vec2),
        moved: wp.array2d(dtype=wp.vec2),
        lost: wp.float32,
        usable: wp.array2d(dtype=wp.uint8),
    ):
        line, column = wp.tid()
        line += first
        found = solve(field, top + line, column, away[line, column], moved[line, column])
        next = wp.vec2(found[0], found[1])
        moved[line, column] = next - away[line, column]
        away[line, column] = next
        if found[2] > lost:
            usable[line, column] = wp.uint8(0)

    @wp.kernel(module="unique", enable_backward=False)
    def glue_back(
        first: wp.int32,
        field: wp.array2d(dtype=wp.vec2),
        later: wp.array2d(dtype=wp.vec2),
        away: wp.array2d(dtype=wp.vec2),
    ):
        row, column = wp.tid()
        row += first
        rest = wp.vec2(0.0, 0.0)
        found = solve(field, row, column, rest, take(field, row, column, rest))
        there = wp.vec2(found[0], found[1])
        away[row, column] = there + take(later, row, column, there)

    @wp.kernel(module="unique", enable_backward=False)
    def glue_ahead(
        first: wp.int32,
        motion: wp.array2d(dtype=wp.vec2),
        earlier: wp.array2d(dtype=wp.vec2),
        away: wp.array2d(dtype=wp.vec2),
    ):
        row, column = wp.tid()
        row += first
        there = -motion[row, column]
        away[row, column] = there + take(earlier, row, column, there)

    return Steps(back, ahead, glue_back, glue_ahead)


@wp.func
def slope(
    away: wp.array2d(dtype=wp.vec2), line: wp.int32, column: wp.int32, down: wp.int32, right: wp.int32
) -> wp.vec2:
    """How a place changes for each px down, or right: a difference of both neighbours, of one at an edge."""
    before_line = wp.max(line - down, 0)
    before_column = wp.max(column - right, 0)
    after_line = wp.min(line + down, away.shape[0] - 1)
    after_column = wp.min(column + right, away.shape[1] - 1)
    steps = wp.float32(after_line - before_line + after_column - before_column)
    change = away[after_line, after_column] - away[before_line, before_column]
    return change / wp.max(steps, 1.0) + wp.vec2(wp.float32(right), wp.float32(down))


@wp.kernel
def land(
    first: wp.int32,
    inner: wp.array2d(dtype=wp.uint8),
    top: wp.int32,
    away: wp.array2d(dtype=wp.vec2),
    shortest: wp.float32,
    usable: wp.array2d(dtype=wp.uint8),
):
    """Usable only where the place is an inner pixel, and a step of 1 px there is nowhere shorter than `shortest` px."""
    line, column = wp.tid()
    line += first
    if usable[line, column] == wp.uint8(0):
        return
    x = column + wp.int32(wp.rint(away[line, column][0]))
    y = top + line + wp.int32(wp.rint(away[line, column][1]))
    if x < 0 or y < 0 or x >= inner.shape[1] or y >= inner.shape[0]:
        usable[line, column] = wp.uint8(0)
        return
    across = slope(away, line, column, 0, 1)
    along = slope(away, line, column, 1, 0)
    # The smaller singular value of the map's Jacobian.
    sum = wp.dot(across, across) + wp.dot(along, along)
    area = across[0] * along[1] - across[1] * along[0]
    least = sum / 2.0 - wp.sqrt(wp.max(sum * sum / 4.0 - area * area, 0.0))
    if inner[y, x] == wp.uint8(0) or least <= shortest * shortest:
        usable[line, column] = wp.uint8(0)


@wp.func
def bends(
    motion: wp.array2d(dtype=wp.vec2),
    bend: wp.float32,
    whole: wp.array2d(dtype=wp.uint8),
    row: wp.int32,
    column: wp.int32,
    down: wp.int32,
    right: wp.int32,
) -> wp.bool:
    """Whether the second difference down, or to the right, over wholly covered pixels is above `bend` px."""
    if row < down or column < right or row + down >= motion.shape[0] or column + right >= motion.shape[1]:
        return False
    if whole[row - down, column - right] == wp.uint8(0) or whole[row + down, column + right] == wp.uint8(0):
        return False
    bent = motion[row - down, column - right] - 2.0 * motion[row, column] + motion[row + down, column + right]
    return wp.abs(bent[0]) > bend or wp.abs(bent[1]) > bend


@wp.kernel
def find_smooth(
    first: wp.int32,
    motion: wp.array2d(dtype=wp.vec2),
    bend: wp.float32,
    whole: wp.array2d(dtype=wp.uint8),
    smooth: wp.array2d(dtype=wp.uint8),
):
    """smooth: wholly covered pixels at which the motion has no edge."""
    row, column = wp.tid()
    row += first
    smooth[row, column] = whole[row, column]
    if whole[row, column] != wp.uint8(0):
        if bends(motion, bend, whole, row, column, 1, 0) or bends(motion, bend, whole, row, column, 0, 1):
            smooth[row, column] = wp.uint8(0)


@wp.kernel
def claim(
    motion: wp.array2d(dtype=wp.vec2),
    shown: wp.array2d(dtype=wp.uint8),
    least: wp.array3d(dtype=wp.float32),
    most: wp.array3d(dtype=wp.float32),
):
    """Every pixel shown claims the place that it comes from: of the motions that claim a place the least and the most.

    It writes where others may write too: on the CPU it is launched once, for all rows.
    """
    row, column = wp.tid()
    if shown[row, column] == wp.uint8(0):
        return
    moved = motion[row, column]
    x = wp.int32(wp.rint(wp.float32(column) - moved[0]))
    y = wp.int32(wp.rint(wp.float32(row) - moved[1]))
    if x < 0 or y < 0 or x >= motion.shape[1] or y >= motion.shape[0]:
        return
    for axis in range(2):
        wp.atomic_min(least, y, x, axis, moved[axis])
        wp.atomic_max(most, y, x, axis, moved[axis])
