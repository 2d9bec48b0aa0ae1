"""Every rule that leaves pixels out is needed: without it a glued picture flickers where it is measured."""

import numpy as np
import pytest
from occluder import Occluder

from metrics import Clip, correspondence, measure
from metrics.synthetic import Rotation, centres, texture

SIZE = 160
X, Y = np.broadcast_arrays(*centres(SIZE, SIZE))


def crossing(speed, count):
    scene = Occluder((0.72, -0.3), speed, SIZE, half=40)
    return Clip(scene.frame, count, motion=scene.motion)


def folding():
    """A surface whose right half is pushed together to three tenths, finer than pixels can show."""
    sizes, fold, fine = (1.0, 1.0, 1.0, 0.7, 0.45, 0.3), 60.0, texture(31, mean=2.0)

    def surface(t, x=X):
        return np.where(x < fold, x, fold + (x - fold) / sizes[t])

    def motion(t):
        on = surface(t)
        before = np.where(on < fold, on, fold + (on - fold) * sizes[t - 1])
        return np.stack([X - before, np.zeros_like(X)], axis=2)

    return Clip(lambda t: fine.at(surface(t), Y), len(sizes), motion=motion)


def bright_outside():
    """Only what is covered follows the motion; beside it stands noise of a thousand times the contrast."""
    turning, pattern = Rotation(1.0, (SIZE, SIZE)), texture(32, mean=2.0)
    covered = (np.abs(X - SIZE / 2) < 70) & (np.abs(Y - SIZE / 2) < 40)

    def frame(t):
        noise = 1000 * np.random.default_rng(t).standard_normal((SIZE, SIZE, 3))
        return np.where(covered[..., None], pattern.at(*turning.surface(t)), noise)

    return Clip(frame, 6, motion=turning.motion, coverage=lambda _: covered.astype(float))


RULES = {
    "an edge of the motion": ("BEND", 100.0, lambda: crossing((1.1, 0.6), 2)),
    "surfaces that meet": ("APART", 1e9, lambda: crossing((45.0, 0.0), 4)),
    "what is covered up": ("LOST", 1e9, lambda: crossing((45.0, 0.0), 4)),
    "what shrinks": ("SHRINK", 8.0, folding),
    "the edge of what is covered": ("MARGIN", 0, bright_outside),
}


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_is_needed(rule, monkeypatch, tolerance):
    name, loose, clip = RULES[rule]
    found = measure(clip(), names=["residual", "measured"]).scores
    assert found["residual.flicker"] < tolerance("left out")
    assert found["measured.fraction"] > 0.02
    monkeypatch.setattr(correspondence, name, loose)
    assert measure(clip(), names=["residual"]).scores["residual.flicker"] > 10 * tolerance("left out")
