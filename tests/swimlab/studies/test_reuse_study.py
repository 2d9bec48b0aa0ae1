"""The study of light that is kept: how lateness is read, and what its verdict says."""

import numpy as np
import pytest

from metrics import Measurement
from sequences import load
from swimlab.render.techniques.tsl import TslSettings
from swimlab.studies.beyond import reuse
from swimlab.studies.trials import Trial
from swimlab.studies.turns import Time

SETTINGS = TslSettings(size=256, texels="needed", inputs="vmf")


def test_lateness_is_the_age_of_light_that_drifts_evenly(tolerance):
    random = np.random.default_rng(0)
    drift = [random.normal(size=(5, 7, 4)).astype(np.float32) for _ in range(3)]
    late = [4 * each for each in drift]
    mixed = [np.where(np.arange(7)[:, None] < 4, 2 * each, 0) for each in drift]
    assert reuse.lateness(late, drift) == pytest.approx(4, abs=tolerance("closed form"))
    assert 0 < reuse.lateness(mixed, drift) < 2
    assert reuse.lateness(drift, [0 * each for each in drift]) is None


def test_light_of_the_frame_before_is_that_frames_where_nothing_else_moves(shoot, render):
    """Under a moving sun a still view in late light is the picture of the frame before, to the bit."""
    sun = load("road-sun").with_changes(size=(96, 54))
    before = render(shoot(sun, 4), "tsl", **SETTINGS.model_dump())
    assert reuse.late(shoot(sun, 5), SETTINGS).tobytes() == before.rgba.tobytes()
    still = sun.with_changes(motion={"kind": "shift", "velocity": [0.25, 0.5]})
    now = render(shoot(still, 5), "tsl", **SETTINGS.model_dump())
    assert reuse.late(shoot(still, 5), SETTINGS).tobytes() == now.rgba.tobytes()


def made(variant, ms, error, shaded, lag):
    measurement = Measurement(scores={"budget.mse": error**2, "budget.flicker": 0.0}, errors={})
    return reuse.Row(Trial(variant, measurement, shaded), [Time(ms, ms)], lag)


def test_the_verdict_is_the_cheapest_within_the_error_that_is_wanted():
    rows = {reuse.PIXELS.label: made(reuse.PIXELS, 10.0, 0.3, 100.0, None)}
    rows[reuse.PLAIN.label] = made(reuse.PLAIN, 40.0, 0.1, 1000.0, 0.0)
    for k, variant in enumerate(reuse.KEPT):
        rows[variant.label] = made(variant, 29.0 - k, 0.1 + 0.002 * k, 500.0 - 20 * k, 1.0)
    best = reuse.KEPT[2].label
    (said,) = reuse.answers({"made-up": rows})
    assert f"the cheapest is `{best}`: 0.68 of the time of lighting anew, 2.7 times `pixel-aniso`, 0.46" in said
    few = 500 - 20 * (len(reuse.KEPT) - 1)
    left = (30 - len(reuse.KEPT)) / 40
    assert f"{few / 1000:.2f} of the texels (`{reuse.KEPT[-1].label}`), takes {left:.2f} of the time." in said
    assert "With none lit anew it would be 0.10, by" in said  # 4 ms and 1/20 ms a texel
    table = reuse.section({"made-up": rows}).parts[2]
    assert [row[0] for row in table.rows] == list(rows)
    dear = rows | {v.label: made(v, 50.0, 0.1, 1.0, 1.0) for v in reuse.KEPT}
    (said,) = reuse.answers({"made-up": dear})
    assert "nothing that was tried is cheaper within 1.05" in said
    assert "none lit anew" not in said
