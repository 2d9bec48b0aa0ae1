"""Every pixel of a disc that moves before a background which moves otherwise: silhouettes, what comes into view."""

from dataclasses import replace

import numpy as np
import pytest

from metrics import Clip, measure
from metrics.levels import levels_of
from metrics.synthetic import centres, texture

HEIGHT, WIDTH, COUNT = 144, 224, 12
X, Y = centres(HEIGHT, WIDTH)
DISC, GROUND = (2.1, -0.3), (-1.3, 0.4)
RADIUS = 36.0
PICTURES, ERRORS = (texture(1), texture(2)), (texture(3), texture(4))


def distance(t, x=X, y=Y):
    """From the disc's centre in frame t."""
    return np.hypot(x - 70 - DISC[0] * t, y - 70 - DISC[1] * t)


def on_disc(t):
    return (distance(t) < RADIUS)[..., None]


def glued(textures, t):
    places = [texture.at(X - dx * t, Y - dy * t) for texture, (dx, dy) in zip(textures, (DISC, GROUND), strict=True)]
    return np.where(on_disc(t), *places)


def motion(t):
    return np.where(on_disc(t), np.float32(DISC), np.float32(GROUND))


def white(t):
    return np.random.default_rng(t).standard_normal((HEIGHT, WIDTH, 3))


def banded(t):
    phase = np.random.default_rng(t).uniform(0, 2 * np.pi, len(ERRORS[0].phase))
    return replace(ERRORS[0], phase=phase).at(X, Y)


def scores(error, names=("frame", "edges", "new", "measured"), **options):
    reference = Clip(lambda t: glued(PICTURES, t), COUNT)
    test = Clip(lambda t: glued(PICTURES, t) + 0.1 * error(t), COUNT, motion=motion, **options)
    return measure(test, reference, names=names)


@pytest.mark.parametrize(
    ("error", "least", "most"),
    [
        (lambda t: glued(ERRORS, t), 0.0, 0.02),
        (white, 0.9, 1.1),
        (banded, 0.9, 1.1),
        (lambda t: ERRORS[0].at(X, Y), 0.2, 0.7),
        (lambda t: glued(ERRORS, t) * (-1) ** t, 1.8, 2.1),
    ],
    ids=["glued", "white noise", "noise", "screen-fixed", "blinking"],
)
@pytest.mark.checks("edges.flicker")
def test_flicker_of_edges_tells_kinds_of_errors(error, least, most):
    found = scores(error).scores
    assert least <= found["edges.flicker"] / found["edges.mse"] <= most


@pytest.mark.checks("frame.mse", "measured.fraction", "edges.fraction", "new.fraction", "edges.floor")
def test_every_pixel_is_in_one_class_and_counts_once(tolerance):
    found = scores(white)
    parts = [found.scores[f"{name}.fraction"] for name in ("measured", "edges", "new")]
    assert sum(parts) == pytest.approx(1, abs=tolerance("closed form"))
    assert min(parts) > 0
    exact = np.mean([np.mean((0.1 * white(t)) ** 2) for t in range(COUNT)])
    assert found.scores["frame.mse"] == pytest.approx(exact, rel=tolerance("mean of float32 squares"))
    assert all(found.errors[name] >= 0 and found.replicates[name] for name in ("frame.mse", "edges.mse", "new.mse"))
    assert found.scores["edges.floor"] < 0.01


def test_the_map_has_every_pixel_in_a_class(tolerance):
    found = scores(white)
    curve = found.curves["frame.map"]
    shares = {name: levels_of(curve[name]) for name in ("measured", "edges", "new")}
    assert curve["cell"] == [16]
    assert shares["new"].shape == (-(-HEIGHT // 16), -(-WIDTH // 16))
    # All is covered; each share is rounded to a percent.
    assert sum(shares.values()) == pytest.approx(100, abs=1.5)
    flicker = 10 ** (levels_of(curve["flicker"]) / 10)
    assert np.average(flicker, weights=shares["edges"]) == pytest.approx(found.scores["edges.flicker"], rel=0.1)


@pytest.mark.checks("frame.mse", "edges.mse", "new.mse")
def test_only_covered_pixels_count(tolerance):
    covered = np.zeros((HEIGHT, WIDTH))
    covered[:, :100] = 1.0
    covered[:, 100] = 0.5
    wrong = np.where(covered[..., None] > 0, 1.0, 50.0)
    found = scores(lambda t: wrong, coverage=lambda t: covered).scores
    for name in ("frame.mse", "edges.mse", "new.mse"):
        assert found[name] == pytest.approx(0.01, rel=tolerance("mean of float32 squares")), name


def test_a_crawling_silhouette_flickers():
    n = 8
    offsets = (np.arange(n) + 0.5) / n - 0.5

    def share(t):
        return np.mean([distance(t, X + dx, Y + dy) < RADIUS for dx in offsets for dy in offsets], axis=0)[..., None]

    reference = Clip(lambda t: share(t) * np.ones(3), COUNT)
    test = Clip(lambda t: on_disc(t) * np.ones(3), COUNT, motion=motion)
    found = measure(test, reference, names=["edges", "budget"]).scores
    assert found["edges.mse"] > 0
    assert found["edges.flicker"] >= 0.35 * found["edges.mse"]


def test_a_ghost_trail_stands_in_what_is_new():
    def trail(t):
        """Of the disc where it was in the frame before, and is no more."""
        return np.where((distance(t - 1) < RADIUS) & ~(distance(t) < RADIUS), 1.0, 0.0)[..., None] * np.ones(3)

    with_ghost, without = scores(trail).scores, scores(lambda t: np.zeros((HEIGHT, WIDTH, 3))).scores
    assert without["new.mse"] == 0
    assert with_ghost["new.mse"] > 10 * with_ghost["frame.mse"] > 0


def test_of_the_first_frame_all_is_new_that_tiles_do_not_reach():
    found = scores(white)
    first = found.frames[0]
    assert "new_mse" in first
    assert "edges_mse" not in first
    assert "edges_mse" in found.frames[1]


def test_without_a_reference_the_classes_are_told_and_no_error():
    found = measure(Clip(lambda t: glued(PICTURES, t), COUNT, motion=motion))
    assert found.scores["edges.fraction"] > 0
    assert found.absent["frame.mse"] == found.absent["edges.flicker"] == "needs a reference"


@pytest.mark.parametrize("threads", [1, 3])
def test_the_same_bits_for_any_number_of_threads(threads):
    def measured(threads):
        reference = Clip(lambda t: glued(PICTURES, t), COUNT)
        test = Clip(lambda t: glued(PICTURES, t) + 0.1 * white(t), COUNT, motion=motion)
        return measure(test, reference, names=["edges", "new", "frame"], threads=threads).scores

    assert measured(threads) == measured(2)
