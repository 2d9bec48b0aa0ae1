"""Memory is bounded, and neither that nor the number of threads changes a score."""

import weakref
from dataclasses import replace

import numpy as np
import pytest

import metrics.sweep
from metrics import Clip, measure
from metrics.parts import parts, pieces
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


def test_places_of_one_part_at_a_time_are_held(clips, monkeypatch):
    """Each part lets its correspondence go; where all moves as one there is none."""
    test, reference = clips
    made, most = [], [0]

    def watched(*args):
        some = list(parts(*args))
        made.extend(weakref.ref(part) for part in some)
        return some

    def frame(t):
        spans = [part() for part in made]
        most[0] = max(most[0], sum("_places" in vars(span) for span in spans if span is not None))
        return test.frame(t)

    monkeypatch.setattr(metrics.sweep, "parts", watched)
    measure(replace(test, frame=frame), reference, memory=9e6)
    assert len(made) >= 2
    assert most[0] == callable(test.motion)


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
