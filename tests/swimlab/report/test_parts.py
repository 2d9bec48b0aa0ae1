"""The parts of the report: charts, colours, table, display pictures and the choice of frames."""

import base64
import re
from collections.abc import Callable
from typing import Any
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swimlab.report.charts import Axis, Bar, Line, line_chart, number, stacked_bars, ticks
from swimlab.report.clips import outwards
from swimlab.report.display import ERROR_RANGE, ERROR_STEPS, UNMEASURED, error_codes, srgb, webp, wide_codes
from swimlab.report.figures import figures
from swimlab.report.palette import inks
from swimlab.report.table import headline, score_table
from swimlab.runs.columns import COLUMNS, HIGHER, marked, roots


def entry(technique: str, *, bias: float = 0.0, flicker: float = 0.0, **more: Any) -> dict[str, Any]:
    scores = {"budget.mse": bias + flicker, "budget.bias": bias, "budget.detail": 0.0, "budget.flicker": flicker}
    return {"sequence": "road-shift", "technique": technique, "scores": scores, "absent": {}, **more}


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6))
def test_linear_ticks_are_few_rising_and_inside(low: float, span: float) -> None:
    values = [value for value, _ in ticks(low, low + span, "linear")]
    assert values == sorted(set(values))
    assert 2 <= len(values) <= 12
    assert low - 1e-6 * span <= values[0]
    assert values[-1] <= low + span * (1 + 1e-6)


@pytest.mark.parametrize(
    ("low", "high", "scale", "texts"),
    [
        (1 / 16, 1, "octaves", ["1/16", "1/8", "1/4", "1/2", "1"]),
        (1e-4, 1, "log", ["1e-4", "0.001", "0.01", "0.1", "1"]),
        (0.05, 0.4, "log", ["0.05", "0.1", "0.2"]),
        (0, 0.42, "linear", ["0", "0.1", "0.2", "0.3", "0.4"]),
    ],
)
def test_ticks_are_round(low: float, high: float, scale: str, texts: list[str]) -> None:
    assert [text for _, text in ticks(low, high, scale)] == texts


@given(value=st.floats(-1e9, 1e9, allow_subnormal=False).filter(lambda v: v == 0 or abs(v) > 1e-12))
def test_numbers_keep_three_digits(value: float, tolerance: Callable[[str], float]) -> None:
    assert float(number(value)) == pytest.approx(value, rel=tolerance("printed number"))


def test_bars_are_as_long_as_their_values(tolerance: Callable[[str], float]) -> None:
    bars = [
        Bar("a", [("one", 3.0, "#111111", ""), ("two", 1.0, "#222222", "")]),
        Bar("b", [("one", 2.0, "#111111", "")]),
    ]
    svg = ElementTree.fromstring(stacked_bars(bars, label="x", title="t"))
    wide = [float(rect.attrib["width"]) for rect in svg.iter("rect")]
    assert wide[0] / wide[1] == pytest.approx(3, rel=tolerance("drawn length"))
    assert wide[0] / wide[2] == pytest.approx(1.5, rel=tolerance("drawn length"))


def test_a_line_rises_where_its_values_do_and_leaves_gaps_out() -> None:
    line = Line("tsl", [1, 2, 3, 4], [0.1, None, 0.0, 10.0], "#228833")
    svg = ElementTree.fromstring(line_chart([line], x=Axis("x"), y=Axis("y", "log"), title="t"))
    heights = [float(circle.attrib["cy"]) for circle in svg.iter("circle")]
    assert len(heights) == 2
    assert heights[0] > heights[1]


def test_charts_without_values_are_left_out_and_labels_are_escaped() -> None:
    assert line_chart([Line("a", [1], [None], "#111111")], x=Axis("x"), y=Axis("y"), title="t") == ""
    assert stacked_bars([Bar("a", [("one", 0.0, "#111111", "")])], label="x", title="t") == ""
    svg = stacked_bars([Bar("<b>", [('"q"', 1.0, "#111111", "<i>")])], label="<x>", title='"<t>')
    assert not re.search("<b>|<i>|<x>|<t>", svg)
    ElementTree.fromstring(svg)


def test_every_figure_is_well_formed_and_drawn_from_its_scores() -> None:
    scale = {"scale": [1.0, 0.5, 0.25], "rmse": [None, 0.1, 0.2], "mean_drift": [0.0, -1.0, 2.0]}
    entries = [
        entry(name, bias=0.01, flicker=0.02, frames=[{"frame": t, "change": 0.1 / (1 + t)} for t in range(4)])
        for name in ("tsl", "lean")
    ]
    for item in entries:
        item["scores"] |= {"plane.on": 0.9, "plane.order1": 0.08, "plane.off": 0.02}
        item["curves"] = {
            "scale": scale,
            "moire.radial": {"frequency": [0.0, 0.1], "test": [1.0, 0.1], "reference": [1.0, 0.1], "error": [0.1, 0.1]},
        }
    drawn = figures(entries, inks(["tsl", "lean"]))
    assert [figure.title for figure in drawn] == [
        "Error budget",
        "Flicker over time",
        "Spectrum of the error",
        "Spectrum of the picture",
        "Where the energy moves",
        "Scale error",
        "Drift of the mean",
    ]
    for figure in drawn:
        ElementTree.fromstring(figure.svg)
        assert figure.key
        assert figure.sentence.endswith(".")
    assert figures([{**entry("tsl"), "scores": {}}], inks(["tsl"])) == []


def test_inks_differ_and_depend_on_the_place_alone() -> None:
    names = [f"technique-{n}" for n in range(18)]
    chosen = inks([*names, "reference"])
    assert len(set(chosen.values())) == 19
    assert inks(["reference", *names]) == chosen


def test_table_marks_best_and_worst_but_never_the_reference() -> None:
    entries = [entry("a", bias=0.04), entry("b", bias=0.09), entry("c", bias=0.01), entry("reference")]
    table = score_table(entries, {"a": 5.0})
    column = [heading for heading, _ in table.headings].index("rms error")
    assert [cells[column].text for _, cells in table.rows] == ["0.200", "0.300", "0.100", "0.00"]
    assert [cells[column].mark for _, cells in table.rows] == ["", "worst", "best", ""]


def test_terminal_and_report_have_the_same_heads() -> None:
    scores = {name: 0.1 for name, _ in COLUMNS.values()}
    table = score_table([{**entry("a"), "scores": scores}], {})
    heads = [heading for heading, _ in table.headings]
    assert [head for head in heads if "share" not in head] == [marked(heading) for heading in COLUMNS]
    for heading in ("on plane", "JOD"):
        assert marked(heading).endswith(HIGHER)
    assert marked("rms error") == "rms error"
    assert "rms error of budget.mse" in roots(list(COLUMNS))
    assert "on plane" not in roots(list(COLUMNS))
    assert roots(["on plane"]) == ""


def test_marks_of_one_colour_differ_in_shape_and_dash() -> None:
    chosen = [ink for name, ink in inks([f"technique-{n}" for n in range(18)]).items() if name != "reference"]
    assert len({(ink.colour, ink.mark(0, 0, 4)) for ink in chosen}) == len({*chosen}) == 18


def test_table_tells_why_a_score_is_missing() -> None:
    with_floor, without = entry("a", bias=0.04), entry("b", bias=0.04)
    with_floor["scores"]["budget.floor"] = 1e-4
    without["absent"] = {"budget.floor": "one half only"}
    for item in (with_floor, without):
        item["absent"]["plane.on"] = "not uniform"
    table = score_table([with_floor, without], {})
    column = [heading for heading, _ in table.headings].index("floor\N{NO-BREAK SPACE}·")
    assert table.rows[1][1][column] == ("—", "", "one half only")
    assert table.missing == [("on plane", "not uniform")]


def test_the_headline_names_the_extremes() -> None:
    text = headline([entry("calm", bias=0.09), entry("true", flicker=0.01), entry("reference")])
    assert "true is nearest to the reference: rms error 0.1." in text
    assert "calm is farthest: 0.3, 3.0 times as much." in text
    assert "true flickers most (0.1 rms), calm least (0)." in text
    assert headline([entry("alone", bias=1.0)]) == ""


def test_srgb_has_its_known_codes() -> None:
    grey = np.array([-1, 0, 0.0031308, 0.18, 0.5, 1, 7], dtype=np.float32)
    assert srgb(grey).tolist() == [0, 0, 10, 118, 188, 255, 255]


@given(error=st.floats(-2, 2, width=32))
def test_error_codes_are_right_to_half_a_step(error: float, tolerance: Callable[[str], float]) -> None:
    reference = np.full((2, 2, 4), 1, np.float32)
    reference[0, 0, 3] = 0.5
    codes = error_codes(reference + np.float32(error), reference)
    assert codes[0, 0] == UNMEASURED
    step = ERROR_RANGE / ERROR_STEPS
    shown = (int(codes[1, 1]) - ERROR_STEPS - 1) * step
    assert 1 <= codes[1, 1] <= 2 * ERROR_STEPS + 1
    assert abs(shown - min(max(error, -ERROR_RANGE), ERROR_RANGE)) <= step / 2 + tolerance("error code")


def test_wide_codes_hold_what_is_brighter_than_a_screen(tolerance: Callable[[str], float]) -> None:
    light = np.geomspace(0.01, 16, 1000).astype(np.float32)
    share = wide_codes(light) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    assert linear / (1 - linear) == pytest.approx(light, rel=tolerance("a wide code"))
    assert wide_codes(np.array([-1.0, 0.0, np.float32(1e12)])).tolist() == [0, 0, 255]


def test_webp_of_codes_is_lossless() -> None:
    codes = np.random.default_rng(3).integers(0, 64, (17, 23)).astype(np.uint8)
    decoded = cv2.imdecode(np.frombuffer(base64.b64decode(webp(codes)), np.uint8), cv2.IMREAD_COLOR)
    assert all(np.array_equal(decoded[..., channel], codes) for channel in range(3))


@given(st.integers(1, 40), st.data())
def test_every_prefix_of_outwards_is_consecutive(count: int, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, count - 1))
    order = outwards(range(count), start)
    assert order[0] == start
    assert sorted(order) == list(range(count))
    for length in range(1, count + 1):
        assert max(order[:length]) - min(order[:length]) == length - 1
