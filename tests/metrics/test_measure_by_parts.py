"""A clip whose spans are looked at apart, and joined, has the same bits as one that is measured at once."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import metrics.plan
from metrics import Clip, Measuring, measure
from metrics.measurement import Measurement
from metrics.synthetic import Rotation, centres, texture

SIDE, COUNT, CUT = 136, 56, 40
TURN = Rotation(0.6, (SIDE, SIDE))
FAST = (4.71875, 0.0)
X, Y = centres(SIDE, SIDE)
DEPTH = np.linspace(1, 30, SIDE)[:, None] * np.ones(SIDE)
COVERED = np.ones((SIDE, SIDE))
COVERED[:20, :90] = 0
MOVES = {
    "turning": (TURN.surface, TURN.motion),
    "sliding": (lambda t: (X - FAST[0] * t, Y - FAST[1] * t), FAST),
}


@pytest.fixture(autouse=True)
def short_spans(monkeypatch):
    """Spans that are unwarped are so short that there are several a shot."""
    monkeypatch.setattr(metrics.plan, "LONGEST_UNWARPED", 10)


def made(move, *, cuts=(CUT,)):
    """Test and reference, with noise, depth, coverage and viewing."""
    surface, motion = MOVES[move]
    reference = [texture(int(t >= CUT), mean=2.0).at(*surface(t)) for t in range(COUNT)]
    test = [each + 0.1 * np.random.default_rng(t).standard_normal(each.shape) for t, each in enumerate(reference)]
    seen = {"coverage": lambda _: COVERED, "depth": lambda _: DEPTH, "pixels_per_degree": 40.0, "luminance": 2.0}
    clip = Clip(test.__getitem__, COUNT, motion=motion, cuts=cuts, **seen)
    return clip, Clip(reference.__getitem__, COUNT)


def carried(value):
    """The value as another process gets it."""
    return pickle.loads(pickle.dumps(value))


def by_parts(measuring, spans):
    """Measured in parts of so many spans, the last first."""
    plan = carried(measuring.plan())
    bounds = range(0, len(plan.bounds), spans)
    assert len(bounds) > 1
    found = {first: carried(measuring.look(plan, slice(first, first + spans))) for first in reversed(bounds)}
    return measuring.join(plan, (each for first in bounds for each in found[first]))


def check_same(one: Measurement, other: Measurement) -> None:
    """All that there is, to the last bit, and in the same order."""
    assert repr(vars(one)) == repr(vars(other))


@pytest.fixture(params=MOVES)
def clips(request):
    return made(request.param)


def test_parts_are_the_same_bits(clips):
    whole = measure(*clips)
    assert {"budget.mse.mid", "visible.flicker", "moire.excess", "edges.flicker"} <= whole.scores.keys()
    assert "budget.alignment_floor" in whole.scores or {"plane.orders", "plane.slice"} <= whole.curves.keys()
    check_same(by_parts(Measuring(*clips), 2), whole)


def test_so_are_those_without_a_reference(clips):
    test, _ = clips
    check_same(by_parts(Measuring(test), 1), measure(test))


@pytest.mark.parametrize(
    "options",
    [
        {"domain": "display"},
        {"names": ["edges", "frame"]},
        {"names": ["budget"]},
        {"memory": 6e6},
        {"reference_error": lambda t: 0.01 * np.random.default_rng(t + 99).standard_normal((SIDE, SIDE, 3))},
    ],
    ids=["display", "pixels alone", "no pixels", "little memory", "floor"],
)
def test_so_are_those_of_other_options(options):
    clips = made("turning")
    check_same(by_parts(Measuring(*clips, **options), 2), measure(*clips, **options))


def test_without_a_cut_a_part_begins_with_the_pair_to_the_frame_before():
    clips = made("turning", cuts=())
    found = by_parts(Measuring(*clips), 1)
    assert all("edges_flicker" in row for row in found.frames[1:])
    check_same(found, measure(*clips))


def test_a_part_reads_no_frames_but_its_own_and_the_one_before():
    test, reference = made("turning", cuts=())
    plan = Measuring(test, reference).plan()
    (start, stop) = plan.bounds[1]
    read = set()
    counted = replace(test, frame=lambda t: read.add(t) or test.frame(t))
    Measuring(counted, reference).look(plan, slice(1, 2))
    assert read == {0, *range(start - 1, stop)}  # the first for the size
