"""The curves that are drawn as pictures, against toy errors whose place in them is known."""

import numpy as np
import pytest

from metrics import Clip, measure
from metrics.levels import FAINTEST, levels_of, rows_of
from metrics.motion_slice import SHORTEST, STEPS
from metrics.synthetic import texture

MOTION = (23 / 32, 19 / 32)
AMPLITUDE = 0.2


def clips(error, *, count=32, size=(140, 120), motion=MOTION):
    """Test and reference: a moving texture, and error(x, y, t) on it in all channels."""
    x, y = np.arange(0.5, size[0])[None, :], np.arange(0.5, size[1])[:, None]
    picture = texture(3, mean=2.0)

    def reference(t):
        return picture.at(x - t * motion[0], y - t * motion[1]).astype(np.float32)

    def test(t):
        return reference(t) + (error(x, y, t) * np.ones((1, 1)))[..., None].astype(np.float32)

    return Clip(test, count, motion=motion), Clip(reference, count, motion=motion)


def wave(kx, ky, *, order=(0, 0), frames=None):
    """A cosine of the frequency (kx, ky), cycles/px on the screen, that moves as an alias of an order does."""
    w = -((kx + order[0]) * MOTION[0] + (ky + order[1]) * MOTION[1])

    def error(x, y, t):
        shown = frames is None or t in frames
        return shown * AMPLITUDE * np.cos(2 * np.pi * (kx * x + ky * y + w * t))

    return error


def test_the_strip_is_lit_in_its_band_and_its_frames_only(tolerance):
    frames = [5, 6, 7]
    found = measure(*clips(wave(0.15, 0.1, frames=frames), count=12), names=["budget"])
    strip = found.curves["budget.strip"]
    error = np.array(strip["error"])
    band = np.digitize(np.hypot(0.15, 0.1), strip["frequency"]) - 1
    assert error.shape == (len(strip["frequency"]), 12)
    assert error[band, frames] == pytest.approx(AMPLITUDE / np.sqrt(2), rel=tolerance("band of a window"))
    dark = np.delete(error, frames, axis=1)
    assert dark.max() < tolerance("next frame's leak")
    assert (np.delete(error, band, axis=0)[:, frames] ** 2).sum() < tolerance("band of a window") * AMPLITUDE**2


def test_the_strips_bands_add_up_to_the_error_of_each_frame(tolerance):
    random = np.random.default_rng(4)
    found = measure(*clips(lambda x, y, t: random.standard_normal((120, 140)), count=6), names=["budget"])
    added = (np.array(found.curves["budget.strip"]["error"]) ** 2).sum(axis=0)
    assert added == pytest.approx([row["mse"] for row in found.frames], rel=tolerance("three decimals"))


@pytest.mark.parametrize("place", [(0.21, 0.08), (0.13, -0.3), (0.0, 0.25), (0.3, 0.0)])
def test_the_peak_of_a_cosine_stands_where_its_frequency_is(place, tolerance):
    found = measure(*clips(wave(*place), count=4), names=["moire"])
    strongest = [found.curves["moire.peaks"][axis][0] for axis in "xy"]
    if strongest[0] * place[0] + strongest[1] * place[1] < 0:
        strongest = [-value for value in strongest]
    assert np.hypot(*np.subtract(strongest, place)) < tolerance("peak") * np.hypot(*place)
    picture = found.curves["moire.map"]
    levels = levels_of(picture["level"])
    assert levels.shape == (len(picture["y"]), len(picture["x"]))
    row, column = np.unravel_index(np.argmax(levels), levels.shape)
    bin_width = picture["x"][1]
    seen = np.array([picture["x"][column], picture["y"][row]])
    assert min(np.abs(seen - place).max(), np.abs(seen + place).max()) <= bin_width


def test_the_map_adds_up_to_the_squared_error(tolerance):
    random = np.random.default_rng(5)
    found = measure(*clips(lambda x, y, t: 0.1 * random.standard_normal((120, 140)), count=4))
    power = 10 ** (levels_of(found.curves["moire.map"]["level"]) / 10)
    power[:, 1:-1] *= 2  # the other half plane
    assert power.sum() == pytest.approx(found.scores["budget.mse"], rel=tolerance("whole decibels"))


@pytest.mark.parametrize("order", [(0, 0), (1, 0), (0, -1), (-1, 1)])
def test_a_waves_energy_lies_on_the_line_of_its_order(order):
    along, speed = 0.2, np.hypot(*MOTION)
    kx, ky = along * np.array(MOTION) / speed
    curve = measure(*clips(wave(kx, ky, order=order)), names=["plane"]).curves["plane.slice"]
    levels = levels_of(curve["level"])
    assert levels.shape == (STEPS, len(curve["k"])) == (len(curve["w"]), len(curve["k"]))
    row, column = np.unravel_index(np.argmax(levels), levels.shape)
    w = -along * speed - np.dot(order, MOTION)
    away = (curve["w"][row] - w + 0.5) % 1.0 - 0.5
    assert abs(away) <= 1 / STEPS
    assert abs(curve["k"][column] - along) <= curve["k"][1]
    assert curve["velocity"] == list(MOTION)


def test_what_stands_still_on_the_screen_lies_at_no_temporal_frequency():
    speed = np.hypot(*MOTION)
    kx, ky = 0.25 * np.array(MOTION) / speed
    still = measure(*clips(lambda x, y, t: np.cos(2 * np.pi * (kx * x + ky * y))), names=["plane"])
    levels = levels_of(still.curves["plane.slice"]["level"])
    row, _ = np.unravel_index(np.argmax(levels), levels.shape)
    assert abs(still.curves["plane.slice"]["w"][row]) <= 1 / STEPS


def test_a_clip_that_has_no_slice_has_none():
    few = clips(wave(0.1, 0.1), count=SHORTEST - 1)
    assert "plane.slice" not in measure(*few, names=["plane"]).curves
    still = clips(lambda x, y, t: 0.1 * np.cos(x), motion=(0.0, 0.0))
    assert "plane.slice" not in measure(*still, names=["plane"]).curves
    alone, _ = clips(wave(0.1, 0.1))
    assert "plane.slice" not in measure(alone, names=["plane"]).curves
    assert measure(alone, names=["moire"]).curves == {}
    assert "budget.strip" not in measure(alone, names=["budget"]).curves


def test_pictures_do_not_depend_on_threads_or_memory():
    random = np.random.default_rng(6)
    noise = random.standard_normal((16, 170, 200))
    both = clips(lambda x, y, t: noise[t], count=16, size=(200, 170))
    one, many = (measure(*both, threads=threads).curves for threads in (1, 3))
    little = measure(*both, memory=9e6).curves
    assert one == many
    for name in ("moire.map", "plane.slice"):
        assert np.abs(levels_of(little[name]["level"]) - levels_of(one[name]["level"])).max() <= 1


def test_levels_survive_being_written(tolerance):
    power = np.array([[1.0, 0.5], [1e-9, 0.0]])
    assert rows_of(power) == ["0 -3", f"-90 {FAINTEST}"]
    assert 10 ** (levels_of(rows_of(power))[0] / 10) == pytest.approx(power[0], rel=tolerance("whole decibels"))
