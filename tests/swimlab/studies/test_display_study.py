"""The display of a run: from its sequence into its scores, the gate, and the study of ways to show it."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from metrics import Display
from metrics.display import STANDARD
from sequences import Bloom, SequenceError, load
from sequences import Display as Table
from swimlab.footage.colour import quantisation_floor
from swimlab.render.plan import Plan, load_sequence
from swimlab.render.run import render_run
from swimlab.runs.clips import display_of
from swimlab.runs.entries import read_entries
from swimlab.runs.record import Record, RunError
from swimlab.scoring.measure import measure_run
from swimlab.studies.beyond.display import LINEAR, VARIANTS, display_study

NAMES = ("pixel-aniso", "pixel-point", "reference")
VIEW = "sRGB - Display/ACES 2.0 - SDR 100 nits (Rec.709)"
SQRT = Table(exposure=1, gamma="sqrt", bits=6, dither=True, bloom=Bloom(strength=0.25))


def plan_of(display=None, *, names=NAMES, **changes):
    changes |= {"size": (96, 64)} | ({} if display is None else {"display": display})
    sequence = load("road-shift").with_changes(**changes)
    return Plan(sequence=sequence, techniques=names, frames=(0, 1, 2, 3), samples=4)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("display") / "run"
    render_run(plan_of(), folder)
    return folder


@pytest.fixture
def shown(run):
    """The run as if its sequence file said this, without a pixel rendered."""

    def shown(display):
        record = Record.read(run)
        before = {path: path.stat().st_mtime_ns for path in run.rglob("*.exr")}
        render_run(plan_of(display), run)
        assert {path: path.stat().st_mtime_ns for path in run.rglob("*.exr")} == before
        assert Record.read(run).hash == record.hash
        return run

    yield shown
    render_run(plan_of(), run)


def scores_of(content):
    return [entry["scores"] for entry in content["sequences"]]


def test_the_table_becomes_the_display_of_the_measures(run, shown):
    assert display_of(Record.read(run)) == STANDARD
    found = display_of(Record.read(shown(SQRT)))
    assert asdict(found) == {**SQRT.model_dump(), "seed": 0}
    assert display_of(Record.read(shown(Table()))) == Display()


def test_a_run_without_the_table_is_shown_as_it_stands(run):
    record = Record.read(run)
    del record.sequence["display"]
    assert display_of(record) == STANDARD


def test_a_view_is_the_display_of_the_measures_too(run, tmp_path):
    record = Record.read(run)
    record.sequence["display"] = Table(view=VIEW).model_dump(mode="json")
    assert display_of(record) == Display(view=VIEW)
    record.sequence["display"]["view"] = "sRGB/ACES"
    with pytest.raises(RunError, match="display: OpenColorIO's configuration has no DISPLAY/VIEW 'sRGB/ACES'"):
        display_of(record)
    (tmp_path / "mine.toml").write_text('version = 1\nname = "mine"\n[display]\nview = "sRGB/ACES"\n', encoding="utf-8")
    with pytest.raises(SequenceError, match=r"mine\.toml: display\.view: .*close to it"):
        load_sequence(tmp_path / "mine.toml")


def test_scores_in_the_display_domain_go_through_it_and_say_so(run, shown):
    plain = measure_run(run, domain="display")
    linear = measure_run(run)
    assert plain["sequences"][0]["display"] == asdict(STANDARD)
    assert "display" not in linear["sequences"][0]
    through = measure_run(shown(SQRT), domain="display")
    assert through["sequences"][0]["display"]["gamma"] == "sqrt"
    assert scores_of(through) != scores_of(plain)
    assert scores_of(measure_run(shown(SQRT))) == scores_of(linear)


def test_a_gate_does_not_compare_two_displays(run, shown):
    found = []
    for display in (None, Table(), SQRT):
        measure_run(shown(display), domain="display")
        found.append(read_entries(run)[0].settings)
    assert found[0] == found[1]
    assert found[0].domain == "display"
    assert found[2].difference(found[0]) == (
        "domain display: exposure 1.0, bloom.strength 0.25, gamma sqrt, bits 6, dither True instead of display"
    )


def test_the_study_has_a_row_for_every_way_and_technique(run, tolerance):
    done = []
    rows = display_study(run, advance=done.append)
    assert done == [LINEAR, *VARIANTS]
    assert [(row.settings, row.technique) for row in rows] == [(way, name) for way in done for name in NAMES[:2]]
    for domain, way in (("linear", LINEAR), ("display", "sRGB")):
        for expected, row in zip(scores_of(measure_run(run, domain=domain)), rows[2 * done.index(way) :], strict=False):
            for part, value in (("mse", row.error), ("flicker", row.flicker), ("floor", row.floor)):
                assert value**2 == pytest.approx(expected[f"budget.{part}"], rel=tolerance("budget"))
    found = {row.settings: row for row in rows if row.technique == "pixel-point"}
    assert len({row.error for row in found.values()}) == len(found)
    # Codes end at white, so a sparkle that is many times as bright counts once.
    assert found["sRGB"].flicker < found[LINEAR].flicker
    assert found["bloom"].flicker < found["sRGB"].flicker
    assert found["Reinhard"].flicker < found["sRGB"].flicker


def test_the_study_needs_a_clip_with_a_reference(tmp_path):
    render_run(plan_of(names=("pixel-point",)), tmp_path / "alone")
    scales = plan_of(motion={"kind": "scale"}, names=("pixel-point", "reference"))
    render_run(scales, tmp_path / "scales")
    for name in ("alone", "scales"):
        with pytest.raises(RunError, match=f"{name}: the display study needs"):
            display_study(tmp_path / name)


def test_the_floor_of_stored_codes_follows_the_display(tolerance):
    x, half = 0.25, 0.5 / 255
    found = quantisation_floor(
        np.full(9, x), stored_as="uint8", space="linear", domain="display", display=Display(exposure=1, gamma="sqrt")
    )
    step = np.sqrt(2 * (x + half)) - np.sqrt(2 * (x - half))
    assert found == pytest.approx(step**2 / 12, rel=tolerance("closed form"))


def test_frames_of_ones_own_are_shown_at_an_exposure(run, swimlab):
    words = ["measure", "--test", run / "pixel-aniso", "--reference", run / "reference", "--motion", "0.71875,0.59375"]
    words += ["--motion-unverified", "--json", "-q"]

    def found(*more):
        code, out, err = swimlab(*words, *more)
        assert code == 0, err
        return json.loads(out)

    plain = found("--domain", "display")
    brighter = found("--domain", "display", "--exposure", "1", "--tone-map", "reinhard")
    assert brighter["sequences"][0]["display"] == asdict(Display(exposure=1, tone_map="reinhard"))
    assert brighter["provenance"]["hash"] == plain["provenance"]["hash"]
    assert brighter["sequences"][0]["scores"] != plain["sequences"][0]["scores"]
    viewed = found("--domain", "display", "--display", VIEW)
    assert viewed["sequences"][0]["display"] == asdict(Display(view=VIEW))
    assert len({json.dumps(each["sequences"][0]["scores"]) for each in (plain, brighter, viewed)}) == 3
    code, _, err = swimlab(*words, "--display", VIEW)
    assert (code, f"--display {VIEW}: is for --domain display" in err) == (2, True)
    code, _, err = swimlab(*words, "--domain", "display", "--display", "sRGB/ACES")
    assert code == 2
    assert "--display: OpenColorIO's configuration has no DISPLAY/VIEW 'sRGB/ACES'; close to it" in err
    code, _, err = swimlab(*words, "--exposure", "-1")
    assert (code, "--exposure -1.0: is for --domain display" in err) == (2, True)
    code, _, err = swimlab(*words, "--domain", "display", "--exposure", "99")
    assert (code, "give stops, -20 to 20" in err) == (2, True)
