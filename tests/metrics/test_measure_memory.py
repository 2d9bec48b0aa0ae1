"""Memory is bounded, and neither that nor the number of threads changes a score."""

import weakref
from dataclasses import replace

import numpy as np
import pytest

import metrics.plan
import metrics.spans
import metrics.sweep
from metrics import Clip, measure
from metrics.correspondence import Correspondence
from metrics.geometry import Geometry
from metrics.parts import parts, pieces
from metrics.score import Measuring
from metrics.spans import align
from metrics.synthetic import Rotation, centres, texture

COUNT, SIZE, SPEED = 8, (200, 170), (0.72, 0.59)


TURN = Rotation(2.0, SIZE)


def slid(t):
    x, y = centres(SIZE[1], SIZE[0])
    return x - SPEED[0] * t, y - SPEED[1] * t


@pytest.fixture(scope="module", params=[(slid, SPEED), (TURN.surface, TURN.motion)], ids=["uniform", "turning"])
def clips(request):
    """Test and reference with depth and coverage, moving as a whole or turning."""
    surface, motion = request.param
    reference = np.array([texture(1, mean=2.0).at(*surface(t)) for t in range(COUNT)])
    error = np.array([texture(2).at(*surface(t)) for t in range(COUNT)])
    error += np.random.default_rng(3).standard_normal(error.shape)
    covered = np.ones((SIZE[1], SIZE[0]))
    covered[:20, :90] = 0
    test = Clip(
        (reference + error).__getitem__,
        COUNT,
        motion=motion,
        coverage=lambda _: covered,
        depth=lambda _: np.linspace(1, 30, SIZE[1])[:, None] * np.ones(SIZE[0]),
    )
    return test, Clip(reference.__getitem__, COUNT)


@pytest.fixture(scope="module")
def found(clips):
    return measure(*clips, threads=1)


def test_scores_are_the_same_in_a_tenth_of_the_memory(clips, found, tolerance, monkeypatch):
    began = []
    monkeypatch.setattr(metrics.sweep, "parts", lambda *args: began.append(list(parts(*args))) or began[-1])
    little = measure(*clips, memory=9e6)
    assert max(map(len, began)) >= 2
    assert little.scores == pytest.approx(found.scores, rel=tolerance("budget"), abs=tolerance("budget"))
    assert little.errors == pytest.approx(found.errors, rel=tolerance("error of an error"))
    assert little.absent == found.absent
    assert [row["mse"] for row in little.frames] == pytest.approx(
        [row["mse"] for row in found.frames], rel=tolerance("budget")
    )


@pytest.mark.parametrize("frames", [0, 3, COUNT])
def test_surfaces_are_held_while_there_is_room(clips, frames):
    test, _ = clips
    one = Geometry(test, room=0).surface(1)
    reads = []
    counted = replace(test, depth=None, coverage=lambda t: reads.append(t) or test.coverage(t))
    geometry = Geometry(counted, room=frames * one.nbytes)
    for t in [*range(COUNT), *range(COUNT - 1, -1, -1)]:
        assert np.array_equal(geometry.surface(t).covered, one.covered)
    assert sorted(set(reads)) == list(range(COUNT))
    # The one that was asked for last is always held.
    assert len(reads) == 2 * COUNT - max(1, frames)


def test_places_of_spans_that_are_done_are_let_go(monkeypatch):
    monkeypatch.setattr(metrics.plan, "LONGEST_UNWARPED", 4)
    made, held = weakref.WeakSet(), []
    monkeypatch.setattr(
        metrics.spans, "Correspondence", lambda *args, **kw: made.add(one := Correspondence(*args, **kw)) or one
    )
    grey = np.full((SIZE[1], SIZE[0], 3), 0.5, np.float32)
    frames = 6 * 4
    clip = Clip(lambda t: held.append((t, len(made))) or grey, frames, motion=TURN.motion)
    found = measure(clip, threads=1)
    assert "budget.alignment_floor" in found.scores
    # The middle span is made first, and held beside the others until its turn comes.
    assert {count for t, count in held if 0 < t < frames // 2} == {2}
    assert {count for t, count in held if t >= frames // 2} == {1}


def test_a_file_is_read_once(clips):
    reads = []

    def counted(name, source):
        return lambda t: reads.append((name, t)) or source(t)

    test, reference = clips
    sources = {"frame": test.frame, "coverage": test.coverage}
    if callable(test.motion):
        sources["motion"] = test.motion
    watched = replace(test, **{name: counted(name, source) for name, source in sources.items()})
    measure(watched, replace(reference, frame=counted("reference", reference.frame)))
    assert len(reads) == len(set(reads)) == (len(sources) + 1) * COUNT


def test_motion_that_is_not_held_is_read_once_a_pass(clips, found, monkeypatch):
    """A pass that follows the surface, one that measures, and half of one that the glued pattern takes."""
    reads = []
    test, reference = clips
    if callable(test.motion):
        monkeypatch.setattr(Measuring, "_room", 0.0)
        watched = replace(test, motion=lambda t: reads.append(t) or test.motion(t))
        assert measure(watched, reference).scores == found.scores
        assert len(reads) <= 3 * COUNT


def test_scores_are_the_same_bits_for_any_number_of_threads(clips, found):
    assert vars(measure(*clips, threads=3)) == vars(found)


def test_every_tile_is_in_one_part(clips):
    (span,) = align(clips[0]).spans
    some = list(parts(span, lambda level: level.held, 4e5))
    assert len(some) >= 2
    assert [part.part for part in some] == list(range(len(some)))
    for index, level in enumerate(span.levels):
        assert np.array_equal(np.concatenate([part.levels[index].origin for part in some]), level.origin)
        assert np.array_equal(np.concatenate([part.bands[index] for part in some]), span.bands[index])
    for part in some:
        assert pieces(part)
        rows = [(part.levels[p.level].origin[p.tiles, 0], part.levels[p.level].size) for p in pieces(part)]
        assert min(y.min() for y, _ in rows) >= part.rows.start
        assert max(y.max() + size for y, size in rows) <= part.rows.stop
