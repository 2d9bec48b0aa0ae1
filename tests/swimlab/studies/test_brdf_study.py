"""The report on reflectance models: what is in it, on few samples and small pictures; never how fast it was."""

import json

import numpy as np
import pytest

from swimlab.render.catalogue import brdfs
from swimlab.studies.brdfs import cost as brdf_cost
from swimlab.studies.brdfs import report as brdf_report
from swimlab.studies.brdfs import scene as road
from swimlab.studies.trials import Variant


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(road, "SIZE", (96, 64))
    monkeypatch.setattr(road, "FRAMES", 2)
    monkeypatch.setattr(road, "SAMPLES", 16)
    monkeypatch.setattr(road, "TECHNIQUES", (road.TECHNIQUES[0], Variant("tsl", "tsl", {"size": 64})))
    monkeypatch.setattr(brdf_report, "ROUNDS", 1)


def test_every_model_has_a_row_of_the_decks_tables():
    assert {form.brdf for form in brdf_cost.FORMS} == set(brdfs())
    assert len({form.label for form in brdf_cost.FORMS}) == len(brdf_cost.FORMS)


def test_costs_count_what_is_read(launcher):
    rows = {cost.form: cost for cost in brdf_cost.time_models(launcher, samples=128, rounds=1)}
    assert list(rows) == [*(form.label for form in brdf_cost.FORMS), brdf_cost.LOOP]
    assert all(min(row.minimal, row.varied) > 0 for row in rows.values())
    assert {row.lookups for name, row in rows.items() if "factored" not in name} == {0}
    factored = rows["ashikhmin-shirley-factored"]
    assert (factored.lookups, factored.maps, factored.texel_bytes) == (4, 4, 40)
    assert factored.table_bytes == 4 * (65 * 65 + 129 * 65 + 65 * 2 + 33 * 33)
    assert (rows["cook-torrance"].maps, rows["cook-torrance"].texel_bytes) == (3, 32)
    assert [name for name, row in rows.items() if row.native is not None] == ["blinn-phong"]


def test_table_errors_are_small_and_of_every_factored_form(launcher, tolerance):
    found = brdf_cost.table_errors(launcher, samples=4096)
    names = [name for name in brdfs() if name.endswith("-factored")]
    assert {(error.form, error.power) for error in found} == {(n, p) for n in names for p in brdf_cost.POWERS}
    assert all(0 < error.rms <= tolerance("table, rms") for error in found)


def test_directions_lie_about_the_highlight(tolerance):
    power = np.repeat([10.0, 1e3, 1e5], 2000)
    light, view = brdf_cost.about_highlights(power, seed=0)
    assert min(light[:, 2].min(), view[:, 2].min()) >= 0.05
    half = (light + view).astype(np.float64)
    slope = np.linalg.norm(half[:, :2], axis=1) / half[:, 2] * np.sqrt(power + 1)
    widths = [slope[power == p].mean() for p in (10.0, 1e3, 1e5)]
    # The mean of a Rayleigh distribution is sqrt(pi / 2); where lobes are wide, directions below are left out.
    assert np.sqrt(np.pi / 2) == pytest.approx(widths[2], rel=tolerance("mean spread"))
    assert widths[0] <= widths[2] * (1 + tolerance("mean spread"))


def test_the_report_has_every_table(small, swimlab, tmp_path, monkeypatch, tolerance):
    forms = tuple(form for form in brdf_cost.FORMS if form.brdf in {"blinn-phong", "banks", "cook-torrance"})
    monkeypatch.setattr(road, "FORMS", forms)
    code, out, err = swimlab("bench", "brdfs", "-o", "page.md", "--json", "-q")
    assert (code, err) == (0, "")
    found = json.loads(out)["tables"]
    assert list(found) == ["minimal variation", "surface variation", "table error", "road-shift"]
    page = (tmp_path / "page.md").read_text()
    assert all(f"`{form.label}`" in page for form in brdf_cost.FORMS)
    assert "swimlab bench brdfs -o page.md" in page
    rows = {row["model"].strip("`"): row for row in found["road-shift"]}
    assert list(rows) == [form.label for form in forms]
    for row in rows.values():
        assert row["tsl: error"] >= row["tsl: flicker"] > 0
        assert 0 < row["reference"] < row["pixel-aniso: error"]
    # Ks of Banks is scaled until its highlights are as bright as Blinn-Phong's.
    assert rows["banks"]["Ks times"] > 1 == rows["cook-torrance"]["Ks times"]
    assert rows["banks"]["mean"] == pytest.approx(rows["blinn-phong"]["mean"], rel=tolerance("equal highlights"))
