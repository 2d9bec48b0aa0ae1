"""The error budget: five errors of equal size that only a surface-locked measure tells apart."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from metrics import Clip, measure

FRAMES, HEIGHT, WIDTH = 32, 120, 140
MOTION = (0.71875, 0.59375)
NAMES = ["budget", "residual", "measured"]


@pytest.fixture(scope="module")
def five(texture, centres):
    """Reference frames, and the errors by kind, each [frames, H, W, 3]."""
    picture, wrong, (x, y) = texture(1, mean=3.0), texture(2), centres(HEIGHT, WIDTH)
    dx, dy = MOTION
    moves = [(t * dx, t * dy) for t in range(FRAMES)]
    glued = np.array([wrong.at(x - right, y - down) for right, down in moves], dtype=np.float32)
    random = np.random.default_rng(3)
    errors = {
        "glued": glued,
        "screen": np.repeat(wrong.at(x, y)[None], FRAMES, axis=0),
        "swimming": np.array([wrong.at(x + right, y + down) for right, down in moves]),
        "noise": random.standard_normal(glued.shape),
        "blinking": glued * np.array([1.0, -1.0] * (FRAMES // 2))[:, None, None, None],
    }
    reference = np.array([picture.at(x - right, y - down) for right, down in moves], dtype=np.float32)
    return reference, {kind: (0.1 * error).astype(np.float32) for kind, error in errors.items()}


def scores(test, reference, **options):
    options = {"names": NAMES} | options
    clip = Clip(test.__getitem__, len(test), motion=MOTION)
    return measure(clip, Clip(reference.__getitem__, len(reference)), **options)


@pytest.mark.checks("budget.flicker", "residual.flicker.reference")
def test_a_glued_error_has_no_flicker(five, tolerance):
    reference, errors = five
    found = scores(reference + errors["glued"], reference).scores
    assert found["budget.flicker"] < tolerance("glued") * found["budget.mse"]
    assert found["residual.flicker.reference"] < tolerance("glued") * found["budget.mse"]


@pytest.mark.parametrize("kind", ["screen", "swimming", "noise", "blinking"])
@pytest.mark.checks("budget.flicker", "residual.flicker")
def test_an_error_that_moves_against_the_surface_is_flicker(five, kind, tolerance):
    reference, errors = five
    found = scores(reference + errors[kind], reference).scores
    assert found["budget.flicker"] > tolerance("moving") * found["budget.mse"]
    # What the correction of the variance finds beyond the whole error has no static part to come from.
    most = FRAMES / (FRAMES - 1) * found["budget.mse"] * (1 + tolerance("residual is flicker"))
    assert found["budget.flicker"] * (1 - tolerance("residual is flicker")) <= found["residual.flicker"] <= most


@pytest.mark.parametrize("count", [2, 4, 12])
@pytest.mark.checks("budget.flicker")
def test_noise_is_all_flicker_however_short_the_clip(five, count, tolerance):
    """A static error beside the noise keeps its size."""
    reference, errors = five
    glued, noise = errors["glued"][:count], errors["noise"][:count]
    found = scores(reference[:count] + noise, reference[:count]).scores
    assert found["budget.flicker"] > (1 - tolerance("chance of static noise")) * found["budget.mse"]
    found = scores(reference[:count] + glued + noise, reference[:count]).scores
    static = scores(reference[:count] + glued, reference[:count]).scores["budget.mse"]
    assert found["budget.bias"] + found["budget.detail"] == pytest.approx(static, rel=tolerance("equal rms"))


def test_the_static_part_of_sparse_blinking_is_not_below_nothing(five, tolerance):
    """Signs that cancel have less than no static part by the correction: all is flicker, and adds up."""
    reference, errors = five
    found = scores((reference + errors["blinking"])[:4], reference[:4]).scores
    assert found["budget.flicker"] == pytest.approx(found["budget.mse"], rel=tolerance("glued"))
    assert found["budget.bias"] + found["budget.detail"] < tolerance("glued") * found["budget.mse"]


@pytest.mark.checks("budget.mse")
def test_all_five_errors_are_of_one_size(five, tolerance):
    reference, errors = five
    sizes = [scores(reference + e, reference, names=["budget.mse"]).scores["budget.mse"] for e in errors.values()]
    assert sizes == pytest.approx([0.01] * 5, rel=tolerance("equal rms"))


@settings(max_examples=15)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(2, 5),
    dx=st.floats(-2, 2),
    dy=st.floats(-2, 2),
    scale=st.sampled_from([1e-6, 1.0, 1e6]),
)
@pytest.mark.checks("budget.mse")
def test_bias_detail_and_flicker_add_up_to_the_squared_error(seed, count, dx, dy, scale, tolerance):
    random = np.random.default_rng(seed)
    test, reference = scale * random.standard_normal((2, count, 90, 80, 3))
    clip = Clip(test.__getitem__, count, motion=(dx, dy))
    found = measure(clip, Clip(reference.__getitem__, count), names=["budget"]).scores
    parts = [found[f"budget.{part}"] for part in ("bias", "detail", "flicker")]
    assert min(parts) >= 0
    assert sum(parts) == pytest.approx(found["budget.mse"], rel=tolerance("budget"))


def test_bands_weigh_up_to_the_whole_and_add_up_each(five, tolerance):
    reference, errors = five
    depth = np.linspace(2, 30, HEIGHT)[:, None] * np.ones(WIDTH)
    clip = Clip((reference + errors["noise"]).__getitem__, FRAMES, motion=MOTION, depth=lambda _: depth)
    found = measure(clip, Clip(reference.__getitem__, FRAMES), names=["budget"]).scores
    bands = [band for band in ("near", "mid", "far") if f"budget.mse.{band}" in found]
    assert len(bands) >= 2
    for band in bands:
        parts = [found[f"budget.{part}.{band}"] for part in ("bias", "detail", "flicker")]
        assert sum(parts) == pytest.approx(found[f"budget.mse.{band}"], rel=tolerance("budget"))
    sizes = [found[f"budget.mse.{band}"] for band in bands]
    assert min(sizes) <= found["budget.mse"] <= max(sizes)


@pytest.mark.checks("budget.bias")
def test_a_constant_error_is_all_bias(five, tolerance):
    reference, _ = five
    found = scores(reference.astype(float) + 0.5, reference).scores
    assert found["budget.mse"] == pytest.approx(0.25, rel=tolerance("float32"))
    assert found["budget.bias"] == pytest.approx(0.25, rel=tolerance("window leak"))


@pytest.mark.checks("budget.detail")
def test_a_fine_glued_error_is_all_detail(five, centres, tolerance):
    reference, _ = five
    x, _ = centres(HEIGHT, WIDTH)
    error = np.array([np.cos(1.2 * (x - t * MOTION[0])) for t in range(FRAMES)])[..., None]
    found = scores(reference + error, reference).scores
    assert found["budget.detail"] == pytest.approx(found["budget.mse"], rel=tolerance("window leak"))


@pytest.mark.checks("budget.floor")
def test_the_floor_is_the_energy_of_the_half_difference(five, tolerance):
    reference, errors = five
    half = 0.1 * np.ones_like(reference[0])
    found = scores(reference + errors["glued"], reference, reference_error=lambda _: half).scores
    assert found["budget.floor"] == pytest.approx(0.01, rel=tolerance("float32"))
    without = scores(reference, reference)
    assert "half-difference" in without.absent["budget.floor"]


def test_frames_report_their_own_error_and_change(five, tolerance):
    reference, errors = five
    found = scores(reference + errors["blinking"], reference)
    assert [entry["frame"] for entry in found.frames] == list(range(FRAMES))
    assert np.mean([entry["mse"] for entry in found.frames]) == pytest.approx(found.scores["budget.mse"])
    assert "change" not in found.frames[0]
    change = [entry["change"] for entry in found.frames[1:]]
    # Half of the mean square of e - (-e) is twice the energy of e.
    assert change == pytest.approx([2 * found.scores["budget.mse"]] * (FRAMES - 1), rel=tolerance("equal rms"))


def test_without_a_reference_residual_flicker_and_change_remain(five):
    reference, _ = five
    found = measure(Clip(reference.__getitem__, FRAMES, motion=MOTION))
    assert found.absent["budget.mse"] == "needs a reference"
    assert found.absent["moire.excess"] == "needs a reference"
    assert "residual.flicker" in found.scores
    assert "mse" not in found.frames[1]
    assert "change" in found.frames[1]


def test_one_frame_has_an_error_but_no_flicker(five):
    reference, errors = five
    found = scores((reference + errors["noise"])[:1], reference[:1])
    assert "budget.mse" in found.scores
    for name in ("budget.flicker", "budget.bias", "residual.flicker"):
        assert "2 frames" in found.absent[name]


def test_the_display_domain_clamps_before_anything_else(five):
    reference, errors = five
    bright = 10 + reference
    found = scores(bright + errors["noise"], bright, domain="display").scores
    assert found["budget.mse"] == 0


def test_little_travel_is_warned_about(five):
    reference, errors = five
    found = scores((reference + errors["screen"])[:8], reference[:8])
    assert any("travels 6.5 px" in note for note in found.notes)


def test_a_picture_too_small_for_any_tile_has_reasons_not_scores(five):
    reference, _ = five
    small = reference[:, :12, :12]
    found = scores(small, small)
    assert found.absent["budget.mse"] == "no tile stays wholly covered"
    assert found.absent["residual.flicker"] == "no tile stays wholly covered"
    assert found.notes


def test_a_long_journey_is_cut_in_spans(texture, centres, tolerance):
    picture, (x, y) = texture(5), centres(100, 100)
    clip = Clip(lambda t: picture.at(x - 9.3 * t, y), 30, motion=(9.3, 0.0))
    found = measure(clip, names=["residual", "measured"])
    assert found.scores["residual.flicker"] < tolerance("glued")
    assert any("spans of" in note for note in found.notes)


def test_frames_are_read_one_at_a_time(five):
    reference, errors = five
    alive: set[int] = set()
    most = [0]

    class Frame(np.ndarray):
        def __del__(self):
            alive.discard(id(self))

    def frame(t):
        picture = (reference[t] + errors["noise"][t]).view(Frame)
        alive.add(id(picture))
        most[0] = max(most[0], len(alive))
        return picture

    measure(Clip(frame, FRAMES, motion=MOTION), Clip(reference.__getitem__, FRAMES))
    assert most[0] <= 2
