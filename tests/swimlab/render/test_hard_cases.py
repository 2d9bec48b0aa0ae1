"""Hard cases: where naive formulas break, what is shipped holds, as the report on them says."""

import json

import numpy as np
import pytest
import warp as wp

from sequences import load
from swimlab.render.inputs import Maps, variances
from swimlab.render.kernels.inspection import raise_cosines
from swimlab.studies.page import Section, Table
from swimlab.studies.stability import frames
from swimlab.studies.stability import limits as stability_limits
from swimlab.studies.stability import lobes as stability_lobes
from swimlab.studies.stability import measures as stability_measures
from swimlab.studies.stability import moments as stability_moments
from swimlab.studies.stability import slivers as stability_slivers
from swimlab.studies.stability.report import CASES, Bench, _cancelled, _eight_bit, errors_table
from swimlab.studies.stability.twin import Twin, compare


@pytest.fixture(scope="module")
def asphalt(maps):
    return Maps(maps[..., :3], maps[..., 3:6], maps[..., 6:8])


def test_errors_are_compared_frame_by_frame():
    exact = [np.array([2.0, 2.0]), np.array([2.0, 2.0])]
    glued = compare([each + 0.5 for each in exact], exact)
    assert (glued.rms, glued.largest, glued.flicker, glued.bad) == (0.25, 0.25, 0, 0)
    blinking = compare([exact[0] + 0.5, exact[1] - 0.5], exact, scale=1.0)
    assert (blinking.rms, blinking.flicker) == (0.5, 1.0)
    broken = compare([np.array([np.nan, 2.0]), np.array([np.inf, 2.0])], exact)
    assert (broken.rms, broken.bad) == (0, 2)


@pytest.mark.parametrize("power", stability_lobes.POWERS)
def test_highlights_hold_at_large_powers(launcher, tolerance, power):
    found = stability_lobes.lobes_of(launcher, 4, 14, 20, power)
    assert found.native.bad == found.plain.bad == 0
    assert found.native.rms <= tolerance("shipped highlight")
    assert found.native.flicker <= tolerance("shipped highlight")
    assert found.native.rms < found.plain.rms
    if power >= 1e3:
        assert found.naive.rms > 100 * found.native.rms


@pytest.mark.parametrize("distance", [200.0, 2e3, 2e4])
def test_light_and_eye_may_be_nearly_opposite(launcher, tolerance, distance):
    """The sum of two vectors of rounded lengths points elsewhere; ten times less so without the lengths' share."""
    found = stability_lobes.lobes_of(launcher, 4, 0, distance, 1e4)
    assert found.native.bad == 0
    assert found.native.rms <= 0.15 * found.plain.rms
    ahead = stability_lobes.lobes_of(launcher, 0, 0, distance, 1e4)
    assert ahead.native.rms <= tolerance("shipped highlight")


def test_what_has_no_value_is_its_limit(launcher, tolerance):
    for case in stability_lobes.degenerate(launcher):
        for found in (case.plain, case.native):
            if found is not None:
                assert found == pytest.approx(case.expected, rel=tolerance("peak of a lobe"), abs=0), case.name


def test_no_model_gives_a_nan_or_less_than_nothing(launcher):
    for name, found in stability_lobes.soundness(launcher).items():
        assert found.evaluations > 10_000, name
        assert (found.bad, found.negative) == (0, 0), name


def test_a_cosine_on_the_horizon_keeps_its_digits(launcher, tolerance):
    """A float's sine has none left of a cosine of 1e-4: 1 - sin^2 is off by several per cent."""
    cosine = np.geomspace(1e-6, 0.1, 64)
    h = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], axis=1).astype(np.float32)
    out = launcher.empty(len(h), wp.float32)
    launcher.launch(raise_cosines, len(h), [launcher.array(h, wp.vec3), 1.0, out])
    assert np.abs(out.numpy() / h[:, 2].astype(np.float64) - 1).max() <= tolerance("logarithm in float32")
    by_sine = np.sqrt(np.maximum(1 - h[:, 0].astype(np.float64) ** 2, 0))
    assert np.abs(by_sine / h[:, 2] - 1).max() > 0.01


def test_normals_that_cancel_shade_as_well_as_they_are_known(launcher, tolerance):
    for length, error in stability_lobes.cancelled(launcher).items():
        assert error.bad == 0
        assert error.rms <= tolerance("direction of a short mean") / length


def test_variances_survive_leaning_maps(launcher, tolerance):
    for (mean, variance), found in stability_moments.lean_variances(launcher).items():
        assert max(found.clean, found.lean) <= tolerance("spread of slopes"), (mean, variance)
    assert found.about_zero > 1e-3
    assert found.half == 1


def test_8_bit_normals_do_not_roughen(tolerance):
    for power, found in stability_moments.eight_bit().items():
        assert found.shipped == pytest.approx(1, abs=power * tolerance("unit in float32"))
        assert found.widest > 1.5
    assert stability_moments.eight_bit()[1e3].negative > 0.2


def test_lengths_of_single_normals_tell_nothing():
    normal = np.zeros((2, 2, 3), np.float32)
    normal[..., 2] = [[0.5, 1.0], [0.99, 0.0]]
    packed = variances(Maps(normal, normal, np.ones((2, 2, 2), np.float32))).texels
    assert packed[..., 5].tolist() == [[1, 1], [1, 0]]


def test_stretched_footprints_are_filtered_alike(launcher, tolerance):
    for aspect, error in frames.footprints(launcher).items():
        assert error.bad == 0
        assert error.largest <= tolerance("native filter against plain"), aspect
        assert error.flicker <= tolerance("weights in float32"), aspect


def test_hard_views_are_those_of_double_precision(launcher, asphalt, tolerance):
    for name, pair in frames.views(launcher, asphalt).items():
        for error in pair:
            assert error.bad == 0, name
            assert error.rms <= tolerance("hard view"), name
            assert error.flicker <= tolerance("hard view"), name


@pytest.mark.parametrize("name", ["pixel-aniso", "tsl", "reference"])
def test_kilometres_change_nothing(launcher, asphalt, tolerance, name):
    for metres, found in frames.drives(launcher, asphalt, name).items():
        assert max(found.largest, found.hills) <= tolerance("frame after 10,000 km"), metres
    assert found.naive > 1000


def test_tiny_steps_are_exact(launcher, asphalt, tolerance):
    for frame, step in frames.tiny_steps(launcher, asphalt).items():
        assert step.error <= tolerance("surface in double"), frame
        assert step.same == (frame % 1024 == 0)


def test_slivers_tear_no_hole(launcher, tolerance):
    for width, found in stability_slivers.strips(launcher).items():
        assert found.wrong == 0, width
        assert found.off <= tolerance("surface in double"), width
    assert found.naive > 0


def test_the_eye_plane_may_cut_the_road(launcher, asphalt, tolerance):
    found = frames.crossings(launcher, asphalt)
    assert any("hills" in name for name in found)
    for name, view in found.items():
        assert view.pixels > 500, name
        assert view.bad == 0, name
        assert view.off <= tolerance("surface in double"), name


def test_maps_of_one_texel_are_of_one_colour(launcher, tolerance):
    for name, sizes in frames.single_texels(launcher).items():
        for error, bad in sizes:
            assert bad == 0, name
            assert error <= tolerance("weights in float32"), name


def test_a_hardly_covered_target_is_no_darker(launcher, tolerance):
    for fraction, (error, bad) in frames.thin_charts(launcher).items():
        assert bad == 0
        assert error <= tolerance("weights in float32"), fraction
    for side, (alpha, error) in frames.faint_texels(launcher).items():
        assert alpha == side**-2
        assert error == (0 if alpha > 1e-5 else pytest.approx(1 - alpha))


def test_a_little_flicker_on_a_bright_picture_is_found(tolerance):
    for level, found in stability_measures.bright_flicker().items():
        assert found.shipped <= tolerance("flicker on a bright picture"), level
    assert found.naive > 1


def test_frames_that_cannot_be_measured_are_refused():
    answers = stability_measures.refused()
    assert all("frame 1" in answer for answer in answers.values())
    assert "NaN" in answers["a NaN"]


def test_limits_do_not_act_on_asphalt(launcher, asphalt):
    limits = stability_limits.limits(launcher, asphalt)
    assert all(limit.what and limit.why and limit.effect for limit in limits)
    touched = {limit.what: limit.touched for limit in limits if limit.touched}
    assert all("lengths" in what for what in touched)


def test_the_twin_knows_the_road(maps, asphalt):
    """The same sky, and the road's own colour at a texel's centre."""
    seen = Twin(load("road-shift"), asphalt).seen(0)
    assert not seen.hit[0].any()
    assert seen.hit[-1].all()
    assert np.abs(seen.position[:, 2] + 1.3).max() < 1e-12


def test_sections_are_made_of_the_numbers(launcher, asphalt):
    section = _cancelled(Bench(launcher, asphalt, None))
    assert isinstance(section, Section)
    table = section.parts[1]
    assert isinstance(table, Table)
    found = stability_lobes.cancelled(launcher)
    assert table == errors_table("cancelled", "length of the mean", found)
    assert [row[1] for row in table.rows] == [error.rms for error in found.values()]
    assert len(CASES) == len(set(CASES)) >= 15


def test_the_command_writes_the_page_and_its_numbers(swimlab, monkeypatch, tmp_path):
    monkeypatch.setattr("swimlab.studies.stability.report.CASES", (_cancelled, _eight_bit))
    code, out, _ = swimlab("bench", "stability", "-o", tmp_path / "reports", "--json", "-q", "--threads", 1)
    assert code == 0
    found = json.loads(out)
    assert set(found["tables"]) == {"cancelled", "8-bit"}
    page = (tmp_path / "reports/stability.md").read_text()
    assert page.startswith("# Hard cases")
    assert f"Warp {found['provenance']['warp']}" in page
    assert page.count("\n## ") == 2
    assert [row["power"] for row in found["tables"]["8-bit"]] == ["100", "1,000", "10,000"]
