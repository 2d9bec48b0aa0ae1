"""Studies: what their words and tables say follows from the numbers; and the report that is made of them."""

import json
import re
import xml.etree.ElementTree as ET
from functools import partial

import cv2
import numpy as np
import pytest
from scipy.special import exp1

from metrics import Measurement
from metrics.bands import BANDS
from sequences import load
from swimlab.render.catalogue import techniques
from swimlab.report.charts import Axis, Line
from swimlab.report.contact import CELL, ENLARGED, GAP, HEADER, NAMES
from swimlab.studies.beyond import moments, slivers, tsl, vertex
from swimlab.studies.beyond import report as beyond
from swimlab.studies.beyond import techniques as comparison
from swimlab.studies.page import Figure, Section, Table, chart, markdown, shown, tables, write_page
from swimlab.studies.sheet import contact_sheet
from swimlab.studies.trials import Trial, Variant


def trial(label, error, *, flicker=0.0, shaded=100.0, spread=0.0, floor=0.0, bands=()):
    """A made-up trial of given rms error and flicker, and standard error of the squared error."""
    scores = {"budget.mse": error**2, "budget.flicker": flicker**2, "budget.floor": floor**2}
    scores |= {"budget.bias": 0.0, "budget.detail": error**2 - flicker**2}
    scores |= {f"budget.mse.{band}": value**2 for band, value in zip(BANDS, bands, strict=False)}
    scores |= {f"budget.detail.{band}": value**2 for band, value in zip(BANDS, bands, strict=False)}
    errors = {"budget.mse": spread, "budget.flicker": spread}
    return Trial(Variant(label, "tsl"), Measurement(scores=scores, errors=errors), shaded)


def row(label, ms, error, **more):
    return comparison.Row(trial(label, error, **more), [ms])


ROWS = [
    row("pixel-aniso", 10.0, 0.4, flicker=0.1, bands=(0.1, 0.2, 0.9)),
    row("cheap", 2.0, 0.5, flicker=0.5, bands=(0.6, 0.2, 0.3)),
    row("moments", 15.0, 0.2, flicker=0.05, bands=(0.2, 0.2, 0.2)),
    row("wasteful", 40.0, 0.3, flicker=0.2, bands=(0.3, 0.3, 0.3)),
    row("dear", 300.0, 0.1, flicker=0.08, bands=(0.1, 0.1, 0.15)),
]


def test_the_front_is_what_nothing_is_both_faster_and_closer_than():
    assert [each.label for each in comparison.front(ROWS)] == ["cheap", "pixel-aniso", "moments", "dear"]
    assert comparison.front([*ROWS, row("best", 1.0, 0.01)])[0].label == "best"
    assert len(comparison.front([*ROWS, row("best", 1.0, 0.01)])) == 1


def test_the_answer_follows_from_the_numbers():
    said, table = comparison.answer(ROWS, also=["and more"]).parts
    assert "Closest to the reference: `dear`" in said
    assert "Calmest: `moments`" in said
    assert "Fastest: `cheap`" in said
    assert "`moments`, 1.50 times the time for 0.50 of the error" in said
    assert "Not distinguished" not in said
    assert said.endswith("- and more")
    assert [cells[:2] for cells in table.rows] == [
        ["0.5", "`cheap`"],
        ["1.25", "`pixel-aniso`"],
        *([name, "`moments`"] for name in ("2", "4", "8", "16")),
        ["32", "`dear`"],
        ["any", "`dear`"],
    ]
    quick = [*ROWS, row("quick", 9.0, 0.05, flicker=0.01)]
    said = comparison.answer(quick).parts[0]
    for words in ("Closest to the reference: `quick`", "Calmest: `quick`", "`quick`, 0.90 times the time for 0.12 of"):
        assert words in said


def test_what_chance_or_the_error_of_the_reference_explains_is_not_resolved():
    certain = [row("a", 1.0, 0.2), row("b", 1.0, 0.21), row("c", 1.0, 0.5)]
    assert comparison.unresolved_from(certain[0], certain) == []
    vague = [row("a", 1.0, 0.2, spread=0.003), row("b", 1.0, 0.21, spread=0.003), row("c", 1.0, 0.5, spread=0.003)]
    assert comparison.unresolved_from(vague[0], vague) == ["b"]
    noisy = [row("a", 1.0, 0.2, floor=0.1), row("b", 1.0, 0.21, floor=0.1), row("c", 1.0, 0.5, floor=0.1)]
    assert comparison.unresolved_from(noisy[0], noisy) == ["b"]


def test_where_a_technique_fails_is_its_worst_band():
    found = comparison.Comparison(ROWS, row("reference", 99.0, 0.0), 0.01, b"")
    everything, failures, _ = comparison.sections(found, about="Made up.")
    by_name = {cells[0]: cells[1:] for cells in failures.parts[1].rows}
    assert by_name["`pixel-aniso`"][3:] == ["far", pytest.approx(6), "detail: a lost or false pattern"]
    assert by_name["`cheap`"][3] == "near"
    order = [cells[0] for cells in everything.parts[1].rows]
    assert order == ["`dear`", "`moments`", "`wasteful`", "`pixel-aniso`", "`cheap`", "`reference`"]


def test_the_mean_highlight_has_a_closed_form(tolerance):
    """The mean of 2/(1 + s^2) over Gaussian slopes is 2 a exp(a) E1(a), a = 1/(2 sigma^2)."""
    for sigma in (0.1, 0.3):
        a = 1 / (2 * sigma**2)
        expected = 2 * a * np.exp(a) * exp1(a)
        assert moments.mean_peak(sigma, 2.0) == pytest.approx(expected, rel=tolerance("mean over strata"))
    # At high powers a highlight is a Gaussian of variance 1/power: variances add up.
    wide = moments.mean_peak(0.3, 1e5)
    assert wide == pytest.approx(1 / (0.3**2 + 1e-5), rel=tolerance("Gaussian highlight"))


def test_moment_chains_are_off_by_what_is_known(launcher, tolerance):
    rows = moments.moment_study(launcher, sigmas=(0.1, 0.3), powers=(1e3,))
    found = {(each.chain, each.sigma): each for each in rows}
    assert len(found) == 8
    for chain, low in (("toksvig", 0.128), ("vmf", 0.214)):
        assert found[chain, 0.3].variance == pytest.approx(-low, abs=tolerance("closed form of a widened lobe"))
        assert found[chain, 0.3].peak > found[chain, 0.1].peak > 0
    for chain in ("clean", "lean"):
        assert found[chain, 0.3].variance == pytest.approx(0, abs=tolerance("closed form of a widened lobe"))
        assert found[chain, 0.3].peak == pytest.approx(0, abs=tolerance("Gaussian highlight"))


def curves(vertices, pixels):
    sizes = [(64, 32), (32, 16), (16, 8)]
    other = vertex.Curve(sizes, [0.1] * 3, 1.0)
    return {
        "vertex": vertex.Curve(sizes, vertices, 5.0),
        "pixel-aniso": vertex.Curve(sizes, pixels, 1.0),
        "vmf": other,
        "tsl": other,
    }


@pytest.mark.parametrize(
    ("pixels", "size", "words"),
    [
        ([0.1, 0.3, 0.4], (32, 16), "from 32x16 on down"),
        ([0.3, 0.1, 0.4], (16, 8), "from 16x8 on down"),
        ([0.3, 0.3, 0.1], None, "is nowhere closer"),
        ([0.3, 0.3, None], None, "is nowhere closer"),
    ],
)
def test_the_crossover_is_the_size_from_which_vertices_win(pixels, size, words):
    found = curves([0.2] * 3, pixels)
    assert vertex.crossover(found) == size
    assert words in vertex.section(found).parts[0]


def made_costs(error_of_fixed, error_of_chosen):
    trials = {tsl.FULL.label: trial(tsl.FULL.label, 0.1, shaded=6400.0, bands=(0.1, 0.1, 0.1))}
    for variants, error, texels in ((tsl.FIXED, error_of_fixed, 400.0), (tsl.CHOSEN, error_of_chosen, 390.0)):
        for place, variant in enumerate(variants):
            worse = error * (1 + 0.01 * place)
            trials[variant.label] = trial(variant.label, worse, shaded=texels, bands=(worse, 0.1, 0.1))
    return tsl.Costs(trials, dict.fromkeys(trials, 1.0))


def test_savings_are_told_by_the_trials():
    costs = made_costs(0.3, 0.105)
    assert tsl.best(costs, tsl.FIXED, 16).variant.label == tsl.FIXED[0].label
    assert tsl.best(costs, tsl.FIXED, 64) is None
    (said,) = tsl.answers({"made-up": costs})
    assert "1/16 of the texels, chosen by footprint, the error is 1.05 times that of full targets" in said
    assert "within 1.1), with smaller targets for all 3.00 times" in said
    assert "beyond 1.1; worst is near, 3.00 times" in said
    swapped = made_costs(0.105, 0.3)
    assert "the error is 3.00 times" in tsl.answers({"made-up": swapped})[0]
    picture = Figure("x.png", "", b"")
    sizes = {"64x64": {tsl.FULL.label: costs.trials[tsl.FULL.label]}}
    savings = {"made-up": tsl.Saving(100, 50, 0.0)}
    parts = tsl.section(sizes, savings, {"made-up": costs, "swapped": swapped}, picture).parts
    assert "Of the 6 smaller fixed targets 6 are beaten on `made-up`" in " ".join(map(str, parts))
    assert "Of the 6 smaller fixed targets 0 are beaten on `swapped`" in " ".join(map(str, parts))


def test_slivers_that_are_left_out_are_weighed():
    trials = [trial(variant.label, 0.2, flicker=0.1) for variant in slivers.COMPARED]
    assert "leaves flicker as it is" in slivers.section(trials).parts[0]
    trials[2] = trial(slivers.WITHOUT.label, 0.3, flicker=0.05)
    assert "lowers flicker by 50%" in slivers.section(trials).parts[0]
    assert "raises the whole error by 50%" in slivers.section(trials).parts[0]


def test_cells_and_tables():
    assert [shown(cell) for cell in (None, "x", 1234567, 1234.5, 0.05, 1.0, 0.0, 12e-5)] == [
        *("–", "x", "1,234,567", "1,234", "0.0500", "1.00", "0.00", "0.00012"),
    ]
    table = Table("t", ["name", "value"], [["a", 1.5], ["b", None]])
    assert markdown(table) == "| name | value |\n| --- | ---: |\n| a | 1.50 |\n| b | – |"
    assert tables([Section("s", ["text", table])]) == {"t": [{"name": "a", "value": 1.5}, {"name": "b", "value": None}]}


def test_a_page_holds_its_pictures_beside_it(tmp_path):
    drawn = chart(
        "c.svg", "A < B", [Line("one & two", [1, 2], [3, 4], "#000")], x=Axis("x", "log"), y=Axis("y", "octaves")
    )
    write_page(tmp_path / "page.md", "Title", "Opening.", [Section("One", ["Text.", drawn])])
    assert (tmp_path / "page.md").read_text() == (
        "# Title\n\nOpening.\n\n## One\n\nText.\n\n![A < B](page/c.svg)\n\n*A < B*\n"
    )
    root = ET.fromstring((tmp_path / "page" / "c.svg").read_text())
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert "one & two" in [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]


def test_a_sheet_shows_the_disputed_details():
    """Two pictures that differ in one place near and in one far; rows and columns stand where they are said to."""
    height, width = 120, 200
    depth = np.where(np.arange(height)[:, None] < 60, 30.0, 3.0) * np.ones((1, width))
    one = np.full((height, width, 4), 0.25, np.float32)
    one[..., 3] = 1
    other = one.copy()
    other[80:90, 20:30, :3] = 0.05
    other[20:30, 150:160, :3] = 0.1
    sheet = cv2.imdecode(np.frombuffer(contact_sheet({"one": [one], "other": [other]}, depth), np.uint8), 1)
    assert sheet.shape == (HEADER + 2 * (CELL[1] + GAP), NAMES + 2 * (CELL[0] + GAP), 3)
    top = HEADER + CELL[1] + GAP

    def cell(row, place):
        left = NAMES + place * (CELL[0] + GAP)
        return sheet[row : row + CELL[1], left : left + CELL[0], 0].astype(int)

    for place in (0, 1):
        changed = cell(top, place) != cell(HEADER, place)
        assert changed.sum() == 100 * ENLARGED**2


def test_the_report_holds_every_technique(swimlab, monkeypatch, tmp_path):
    def short(name, **checks):
        sequence = load(name, **checks)
        scene = sequence.scene.model_dump()
        return sequence.with_changes(scene=scene | {"road": scene["road"] | {"length": 16.0}})

    monkeypatch.setattr(beyond, "load", short)
    monkeypatch.setattr(beyond, "Effort", partial(beyond.Effort, rounds=2))
    words = ["--size", "64x64", "--frames", "4", "--samples", "4", "-o", "out", "--json", "-q"]
    code, out, err = swimlab("bench", "beyond-the-deck", *words)
    assert (code, err) == (0, "")
    found = json.loads(out)
    listed = {cells["technique"].strip("`") for cells in found["tables"]["techniques"]}
    assert listed == {*techniques(), *(variant.label for variant in comparison.THRIFTY)}
    assert {cells["targets"] for cells in found["tables"]["tsl cost road-drive"]} == {
        variant.label for variant in (tsl.FULL, *tsl.FIXED, *tsl.CHOSEN)
    }
    assert all(cells["largest difference"] == 0 for cells in found["tables"]["tsl visible"])
    page = (tmp_path / "out" / "beyond-the-deck.md").read_text()
    assert found["provenance"]["command"] in page
    for table in found["tables"].values():
        assert " | ".join(table[0]) in page
    linked = set(re.findall(r"\]\((\S+)\)", page))
    held = {f"beyond-the-deck/{path.name}" for path in (tmp_path / "out" / "beyond-the-deck").iterdir()}
    assert linked == held
    assert any(name.endswith(".png") for name in held)


def test_a_report_too_small_to_measure_is_refused(swimlab):
    code, _, err = swimlab("bench", "beyond-the-deck", "--size", "32x32")
    assert (code, "64x64" in err) == (2, True)
