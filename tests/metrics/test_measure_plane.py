"""Alias orders against closed forms."""

import numpy as np
import pytest

from metrics import Clip, measure
from metrics.orders import separate

FREQUENCY = np.array([0.06, 0.21, 0.38, 0.58, 0.77, 0.93])
AMPLITUDE = np.array([1, 0.7, 0.5, 0.8, 0.6, 0.9])
PHASE = np.array([0.3, 1.1, 2.9, 4.0, 5.3, 0.9])


def drifting(samples, velocity, *, frames=24, height=64, width=144, mean=5.0):
    """Sinusoids along x, box-filtered by so many samples a pixel."""
    place = np.arange(width)[:, None] + (np.arange(samples) + 0.5) / samples

    def frame(t):
        angle = 2 * np.pi * FREQUENCY * (place[..., None] - t * velocity) + PHASE
        row = mean + (AMPLITUDE * np.cos(angle)).sum(axis=-1).mean(axis=-1)
        return np.broadcast_to(row[None, :, None], (height, width, 3))

    return Clip(frame, frames, motion=(velocity, 0.0))


@pytest.mark.parametrize("samples", [1, 4, 16])
@pytest.mark.checks("plane.on", "plane.order1")
def test_order_fractions_match_the_closed_form(samples, tolerance):
    gain = np.sinc(FREQUENCY) / np.sinc(FREQUENCY / samples) if samples > 1 else np.ones(6)
    energies = (AMPLITUDE * gain) ** 2
    found = measure(drifting(samples, 0.375), names=["plane"]).scores
    allowed = tolerance("plane")
    assert found["plane.on"] == pytest.approx(energies[:3].sum() / energies.sum(), abs=allowed)
    assert found["plane.order1"] == pytest.approx(energies[3:].sum() / energies.sum(), abs=allowed)
    assert found["plane.order2"] == pytest.approx(0, abs=allowed)
    assert found["plane.off"] == pytest.approx(0, abs=allowed)
    assert sum(found.values()) == pytest.approx(1, abs=tolerance("single precision"))


@pytest.mark.parametrize(("velocity", "frames"), [(0.37, 12), (0.3, 17), (-1.39, 12)])
def test_the_closed_form_does_not_depend_on_how_long_a_clip_is(velocity, frames, tolerance):
    """Lengths in which no order turns a whole number of times: orders beat against each other."""
    energies = AMPLITUDE**2
    found = measure(drifting(1, velocity, frames=frames), names=["plane"]).scores
    assert found["plane.on"] == pytest.approx(energies[:3].sum() / energies.sum(), abs=tolerance("plane"))
    assert sum(found.values()) == pytest.approx(1, abs=tolerance("rounding"))


@pytest.mark.checks("plane.order1", "plane.order2")
def test_orders_in_two_directions_are_told_apart(centres, tolerance):
    x, y = centres(140, 140)
    dx, dy = 23 / 32, 19 / 32
    waves = {(0.11, 0.07): 1.0, (0.8, 0.1): 0.7, (0.2, -1.15): 0.6, (1.3, 1.8): 0.5, (1.75, -0.3): 0.4}

    def frame(t):
        parts = (a * np.cos(2 * np.pi * (kx * (x - t * dx) + ky * (y - t * dy))) for (kx, ky), a in waves.items())
        return np.repeat(sum(parts)[..., None], 3, axis=2)

    found = measure(Clip(frame, 32, motion=(dx, dy)), names=["plane"])
    total = sum(a * a for a in waves.values())
    shares = dict(zip(found.curves["plane.orders"]["order"], found.curves["plane.orders"]["energy"], strict=True))
    halves = {
        "1,0": 0.49,
        "-1,0": 0.49,
        "0,-1": 0.36,
        "0,1": 0.36,
        "1,2": 0.25,
        "-1,-2": 0.25,
        "2,0": 0.16,
        "-2,0": 0.16,
    }
    expected = {"0,0": 1.0} | {order: energy / 2 for order, energy in halves.items()}
    for order, share in shares.items():
        assert share == pytest.approx(expected.get(order, 0.0) / total, abs=tolerance("plane"))


@pytest.mark.checks("plane.on", "plane.order1", "plane.order2", "plane.off")
def test_noise_spreads_evenly_over_the_orders(tolerance):
    random = np.random.default_rng(8)
    frames = random.standard_normal((32, 110, 110, 3))
    found = measure(Clip(frames.__getitem__, 32, motion=(23 / 32, 19 / 32)), names=["plane"])
    assert found.curves["plane.orders"]["energy"] == pytest.approx([1 / 32] * 25, rel=tolerance("noise"))
    assert found.scores["plane.off"] == pytest.approx(7 / 32, rel=tolerance("noise"))


@pytest.mark.parametrize(("velocity", "frames", "orders"), [((0.61, 0.43), 40, 25), ((0.24, 0.0), 8, 5)])
def test_noise_is_not_raised_where_orders_are_hard_to_tell_apart(velocity, frames, orders, tolerance):
    raised = separate(velocity).raised(frames)
    assert raised.max() > 1.5
    found = []
    for seed in range(4):
        noise = np.random.default_rng(seed).standard_normal((frames, 110, 140, 3))
        found.append(measure(Clip(noise.__getitem__, frames, motion=velocity), names=["plane"]).scores)
    mean = {name: np.mean([scores[name] for scores in found]) for name in found[0]}
    assert mean["plane.on"] == pytest.approx(1 / frames, rel=tolerance("noise"))
    assert mean["plane.order1"] == pytest.approx((8 if orders == 25 else 2) / frames, rel=tolerance("noise"))
    assert mean["plane.off"] == pytest.approx(1 - orders / frames, rel=tolerance("noise"))
    assert sum(mean.values()) == pytest.approx(1, abs=tolerance("rounding"))


def test_orders_that_cannot_be_told_apart_leave_the_others_right(tolerance):
    """At .335 px a frame orders 1 and -2 are all but one in 16 frames; order 0 stands apart from them."""
    energies = AMPLITUDE**2
    found = measure(drifting(1, 0.335, frames=16), names=["plane"])
    assert "too few frames" in found.absent["plane.order1"]
    assert "too few frames" in found.absent["plane.order2"]
    share = energies[:3].sum() / energies.sum()
    assert found.scores["plane.on"] == pytest.approx(share, abs=tolerance("beating orders"))
    assert sum(found.curves["plane.orders"]["energy"]) == pytest.approx(1, abs=tolerance("plane"))


def test_a_mean_level_is_no_energy(tolerance):
    dark, bright = (measure(drifting(1, 0.375, mean=m), names=["plane"]).scores for m in (0.0, 1000.0))
    assert bright == pytest.approx(dark, abs=tolerance("plane"))


@pytest.mark.parametrize("velocity", [1.0, -2.0])
def test_integer_velocities_are_refused_with_the_orders_named(velocity):
    found = measure(drifting(1, velocity, frames=6), names=["plane"])
    assert "(0, 0) and (-1, 0)" in found.absent["plane.on"]
    assert "plane.order1" in found.absent


def test_half_a_pixel_merges_the_first_orders_and_hides_the_second():
    found = measure(drifting(1, 0.5), names=["plane"])
    assert "plane.order1" in found.scores
    assert "(0, 0) and (-2, 0)" in found.absent["plane.on"]
    assert "plane.order2" in found.absent
    assert any("(-1, 0) and (1, 0)" in note for note in found.notes)


def test_no_motion_and_odd_motion_have_reasons():
    still = measure(drifting(1, 0.0), names=["plane"])
    assert "nothing moves" in still.absent["plane.on"]
    clip = drifting(1, 0.375, frames=3)
    field = np.random.default_rng(0).standard_normal((64, 144, 2))
    odd = measure(Clip(clip.frame, 3, motion=lambda _: field), names=["plane"])
    assert "uniform" in odd.absent["plane.on"]
    few = measure(drifting(1, 0.375, frames=4), names=["plane"])
    assert "more than 5 frames" in few.absent["plane.on"]


def test_orders_closer_than_the_clip_is_long_are_refused():
    found = measure(drifting(1, 0.01), names=["plane"])
    assert "too few frames" in found.absent["plane.on"]


def test_the_library_velocity_keeps_all_orders_apart():
    orders = separate((23 / 32, 19 / 32))
    assert len(orders.groups) == 25
    assert not orders.blurred(32)
    assert orders.notes == []
