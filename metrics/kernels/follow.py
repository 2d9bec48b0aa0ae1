"""Surfaces followed from frame to frame: places are px (x, y) away from each pixel of the frame that is followed."""

from typing import NamedTuple

import warp as wp

from metrics.kernels.field import LOOK, field_value
from metrics.kernels.forms import Twins, Within, form
from metrics.kernels.making import made_once

wp.set_module_options({"enable_backward": False})

TOLERANCE = 1e-4
"""A place in the next frame is found when it is sure to so many px."""

ROUNDS = 30
"""Steps at most towards it."""

_AGREES = Within("native places against plain")

_TOLERANCE = wp.constant(TOLERANCE)
_ROUNDS = wp.constant(ROUNDS)


@wp.func
def solve(
    field: wp.array3d(dtype=wp.float32), row: wp.int32, column: wp.int32, away: wp.vec2, guess: wp.vec2
) -> wp.vec3:
    """Where the surface at a place will be in the frame whose motion the field is: q - field(q) = place.

    By fixed-point iteration. The third part is the last step's length, px: it stays long where a surface is covered up
    and has no place.
    """
    next = away + guess
    moved = wp.float32(0.0)
    for _ in range(_ROUNDS):
        better = away + field_value(field, row, column, next)
        moved = wp.max(wp.abs(better[0] - next[0]), wp.abs(better[1] - next[1]))
        next = better
        if moved < _TOLERANCE:
            return wp.vec3(next[0], next[1], moved)
    return wp.vec3(next[0], next[1], moved)


_ROW = """
    const int width = away.shape[1];
    for (int column = 0; column < width; column += L) {
        const int n = width - column < L ? width - column : L;
        const flags all = first_of(n);
        const long here = (long)line*width + column;
        float* const to = (float*)away.data + 2*here;
        Place place;
        %s
        join(to, n, place.x, place.y);
    }
"""

_SOLVE_CODE = """
    lanes moved_last;
    const auto solve = [&](const auto& field, int row, int column, flags going, Place away, Place guess) {
        Place next = {away.x + guess.x, away.y + guess.y};
        moved_last = 0.0f;
        for (int round = 0; round < %(rounds)d && any(going); ++round) {
            const Place there = look(field, row, column, going, next);
            const Place better = {away.x + there.x, away.y + there.y};
            const lanes moved = __builtin_elementwise_max(__builtin_elementwise_abs(better.x - next.x),
                                                          __builtin_elementwise_abs(better.y - next.y));
            next.x = going ? better.x : next.x;
            next.y = going ? better.y : next.y;
            moved_last = going ? moved : moved_last;
            going &= ~(moved < %(tolerance)gf);
        }
        return next;
    };
"""
_SOLVE = _SOLVE_CODE % {"rounds": ROUNDS, "tolerance": TOLERANCE}


@form(agrees=_AGREES)
def row_back() -> Twins:
    """The function that takes a row's places one frame back, in place.

    field: coefficients of the motion between both frames, [2, H, W]. top: the frame's row that row 0 of away is.
    """

    @wp.func(module="unique")
    def back(line: wp.int32, field: wp.array3d(dtype=wp.float32), top: wp.int32, away: wp.array2d(dtype=wp.vec2)):
        for column in range(away.shape[1]):
            there = away[line, column]
            away[line, column] = there - field_value(field, top + line, column, there)

    code = """
        split(to, n, place.x, place.y);
        const Place moved = look(field, top + line, column, all, place);
        place.x -= moved.x;
        place.y -= moved.y;"""
    return Twins(back, LOOK + _ROW % code)


@form(agrees=_AGREES)
def row_ahead() -> Twins:
    """The function that takes a row's places one frame ahead, in place.

    The rest as for `row_back`. moved: how far the places went at the last step, a guess of how far they go. What is
    still `lost` px or more off is not usable.
    """

    @wp.func(module="unique")
    def ahead(
        line: wp.int32,
        field: wp.array3d(dtype=wp.float32),
        top: wp.int32,
        away: wp.array2d(dtype=wp.vec2),
        moved: wp.array2d(dtype=wp.vec2),
        lost: wp.float32,
        usable: wp.array2d(dtype=wp.uint8),
    ):
        for column in range(away.shape[1]):
            found = solve(field, top + line, column, away[line, column], moved[line, column])
            next = wp.vec2(found[0], found[1])
            moved[line, column] = next - away[line, column]
            away[line, column] = next
            if found[2] > lost:
                usable[line, column] = wp.uint8(0)

    code = """
        Place last, guess;
        float* const moving = (float*)moved.data + 2*here;
        split(to, n, last.x, last.y);
        split(moving, n, guess.x, guess.y);
        place = solve(field, top + line, column, all, last, guess);
        join(moving, n, place.x - last.x, place.y - last.y);
        for (int k = 0; k < n; ++k)
            if (moved_last[k] > lost) ((unsigned char*)usable.data)[here + k] = 0;"""
    return Twins(ahead, LOOK + _SOLVE + _ROW % code)


@form(agrees=_AGREES)
def row_glued_back() -> Twins:
    """The function that finds how far the surface of each of a row's pixels is in the middle frame, which comes later.

    field, later: coefficients [2, H, W] of the motion into the frame after, and of how far what it shows is in the
    middle frame.
    """

    @wp.func(module="unique")
    def back(
        line: wp.int32,
        field: wp.array3d(dtype=wp.float32),
        later: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
    ):
        rest = wp.vec2(0.0, 0.0)
        for column in range(away.shape[1]):
            found = solve(field, line, column, rest, field_value(field, line, column, rest))
            there = wp.vec2(found[0], found[1])
            away[line, column] = there + field_value(later, line, column, there)

    code = """
        const Place rest = {};
        const Place there = solve(field, line, column, all, rest, look(field, line, column, all, rest));
        const Place further = look(later, line, column, all, there);
        place.x = there.x + further.x;
        place.y = there.y + further.y;"""
    return Twins(back, LOOK + _SOLVE + _ROW % code)


@form(agrees=_AGREES)
def row_glued_ahead() -> Twins:
    """The same where the middle frame comes earlier.

    motion: [H, W], into this frame. earlier: coefficients [2, H, W] of how far what the frame before shows is in the
    middle frame.
    """

    @wp.func(module="unique")
    def ahead(
        line: wp.int32,
        motion: wp.array2d(dtype=wp.vec2),
        earlier: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
    ):
        for column in range(away.shape[1]):
            there = -motion[line, column]
            away[line, column] = there + field_value(earlier, line, column, there)

    code = """
        Place there;
        split((const float*)motion.data + 2*here, n, there.x, there.y);
        there = Place{-there.x, -there.y};
        const Place further = look(earlier, line, column, all, there);
        place.x = there.x + further.x;
        place.y = there.y + further.y;"""
    return Twins(ahead, LOOK + _ROW % code)


class Steps(NamedTuple):
    """Kernels over rows of pixels, from one frame to the next: `row_back` and so on, a row a thread.

    Their parameters are those of the functions, with the first row in place of the line.
    """

    back: wp.Kernel
    ahead: wp.Kernel
    glue_back: wp.Kernel
    glue_ahead: wp.Kernel


@made_once
def steps(device: str) -> Steps:
    """The kernels for a device."""
    go_back, go_ahead = row_back().on(device), row_ahead().on(device)
    glued_back, glued_ahead = row_glued_back().on(device), row_glued_ahead().on(device)

    @wp.kernel(module="unique", enable_backward=False)
    def back(first: wp.int32, field: wp.array3d(dtype=wp.float32), top: wp.int32, away: wp.array2d(dtype=wp.vec2)):
        go_back(first + wp.tid(), field, top, away)

    @wp.kernel(module="unique", enable_backward=False)
    def ahead(
        first: wp.int32,
        field: wp.array3d(dtype=wp.float32),
        top: wp.int32,
        away: wp.array2d(dtype=wp.vec2),
        moved: wp.array2d(dtype=wp.vec2),
        lost: wp.float32,
        usable: wp.array2d(dtype=wp.uint8),
    ):
        go_ahead(first + wp.tid(), field, top, away, moved, lost, usable)

    @wp.kernel(module="unique", enable_backward=False)
    def glue_back(
        first: wp.int32,
        field: wp.array3d(dtype=wp.float32),
        later: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
    ):
        glued_back(first + wp.tid(), field, later, away)

    @wp.kernel(module="unique", enable_backward=False)
    def glue_ahead(
        first: wp.int32,
        motion: wp.array2d(dtype=wp.vec2),
        earlier: wp.array3d(dtype=wp.float32),
        away: wp.array2d(dtype=wp.vec2),
    ):
        glued_ahead(first + wp.tid(), motion, earlier, away)

    return Steps(back, ahead, glue_back, glue_ahead)
