"""Shots are measured by themselves: no span, no pair of frames and no velocity reaches over a cut."""

import numpy as np
import pytest

from metrics import Clip, measure
from metrics.spans import align
from metrics.synthetic import Rotation, centres, texture

SIZE, COUNT, CUT = 150, 18, 10
SHOTS = (range(CUT), range(CUT, COUNT))
TURN = Rotation(2.0, (SIZE, SIZE))
X, Y = centres(SIZE, SIZE)


def turning(t):
    return TURN.surface(t)


def sliding(t):
    return X - 0.72 * t, Y + 0.31 * t


MOVES = {"turning": (turning, TURN.motion), "sliding": (sliding, (0.72, -0.31))}
NAMES = ["budget", "residual", "frame", "edges", "new", "measured"]


def frame(surface, t):
    """Each shot shows another picture."""
    return texture(int(t >= CUT), mean=2.0).at(*surface(t))


def noise(t):
    return 0.1 * np.random.default_rng(t).standard_normal((SIZE, SIZE, 3))


@pytest.fixture(params=MOVES)
def clip(request):
    """The clip with its cut, and each shot alone: test and reference."""
    surface, motion = MOVES[request.param]

    def made(frames, **cuts):
        reference = Clip(lambda t: frame(surface, frames[t]), len(frames))
        moved = motion if not callable(motion) else lambda t: motion(frames[t])
        test = Clip(lambda t: frame(surface, frames[t]) + noise(frames[t]), len(frames), motion=moved, **cuts)
        return test, reference

    return made(range(COUNT), cuts=(CUT,)), [made(shot) for shot in SHOTS]


def test_no_span_reaches_over_a_cut(clip):
    (test, _), _ = clip
    assert all(span.stop <= CUT or span.start >= CUT for span in align(test).spans)


def test_a_clip_with_a_cut_is_the_sum_of_its_shots(clip, tolerance):
    whole, shots = clip
    found, parts = measure(*whole, names=NAMES), [measure(*shot, names=NAMES) for shot in shots]
    assert found.scores["residual.flicker.reference"] < tolerance("unwarped glued")
    for key in ("mse", "frame_mse", "edges_mse", "new_mse"):
        rows = [row.get(key) for part in parts for row in part.frames]
        assert [row.get(key) for row in found.frames] == [None if row is None else pytest.approx(row) for row in rows]
    # Of the first frame of each shot all is new that tiles do not reach.
    assert all(("edges_mse" in found.frames[t]) == (t not in (0, CUT)) for t in range(COUNT))


def test_without_its_cut_the_picture_flickers(clip):
    whole, _ = clip
    seen = Clip(whole[0].frame, COUNT, motion=whole[0].motion)
    assert measure(seen, names=["residual"]).scores["residual.flicker"] > 0.3
