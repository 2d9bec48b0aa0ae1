"""Speed against error: the Pareto front, growth, turns, charts with names, peers, and the report made of them."""

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from metrics import Measurement
from sequences import load
from swimlab.render.catalogue import techniques
from swimlab.report.charts import Axis
from swimlab.report.figures import speed as speed_figures
from swimlab.report.palette import inks
from swimlab.report.scatter import LETTER, LINE, Point, scatter
from swimlab.report.weighing import front
from swimlab.runs.record import RunError
from swimlab.studies.panels import Panel, panels
from swimlab.studies.speed import growth
from swimlab.studies.speed import report as speed_report
from swimlab.studies.speed import settings as speed
from swimlab.studies.speed.peers import read_peers, section
from swimlab.studies.trials import Trial, Variant
from swimlab.studies.turns import Time, cpu, in_turns, share, wall

SVG = "{http://www.w3.org/2000/svg}"
COARSE = st.integers(0, 6).map(float)


@given(st.lists(st.tuples(COARSE, st.none() | COARSE), max_size=12))
def test_on_the_front_is_what_none_is_as_good_as_in_both_and_better_in_one(points):
    def beats(one, other):
        return one[1] is not None and one != other and one[0] <= other[0] and one[1] <= other[1]

    expected = [point[1] is not None and not any(beats(other, point) for other in points) for point in points]
    assert front(points) == expected


@given(
    power=st.floats(-3, 3),
    factor=st.floats(1e-3, 1e3),
    sizes=st.lists(st.integers(1, 10**6), min_size=2, max_size=8, unique=True),
)
def test_the_slope_of_a_power_is_its_exponent(power, factor, sizes, tolerance):
    found = growth.slope(sizes, [factor * size**power for size in sizes])
    assert found == pytest.approx(power, abs=tolerance("slope of a power"))


def test_growth_counts_all_cores_and_threads_go_by_the_clock(tolerance):
    times = [[Time(wall=100.0 / x, cpu=2.0 * x), Time(1.0, 2.0 * x), Time(1e3, 2.0 * x)] for x in (1, 2, 4)]
    cores = growth.Curve("pixels", "tsl", [1, 2, 4], times)
    assert cores.exponent == pytest.approx(1, abs=tolerance("slope of a power"))
    clock = growth.Curve("threads", "tsl", [1, 2, 4], times, by_clock=True)
    assert clock.ms == [100, 50, 25]
    assert clock.last_exponent == pytest.approx(-1, abs=tolerance("slope of a power"))
    table = growth.section([cores, clock], about="Made up.").parts[1]
    assert [row[:6] for row in table.rows] == [
        ["pixels of the picture", "`tsl`", 1, 4, 2, 8],
        ["threads", "`tsl`", 1, 4, 100, 25],
    ]


def test_tasks_take_turns_after_one_that_does_not_count():
    log = []

    def task(label):
        def prepare(turn):
            log.append((turn, label, "made"))
            return lambda: log.append((turn, label, "run"))

        return prepare

    times = in_turns({label: task(label) for label in "abc"}, 3)
    assert {label: len(each) for label, each in times.items()} == {"a": 3, "b": 3, "c": 3}
    assert sorted(log) == sorted(
        (turn, label, what) for turn in range(4) for label in "abc" for what in ("made", "run")
    )
    assert [turn for turn, _, _ in log] == sorted(turn for turn, _, _ in log)
    assert all(one[:2] == two[:2] for one, two in zip(log[::2], log[1::2], strict=True))
    orders = ["".join(label for turn, label, what in log if (turn, what) == (t, "run")) for t in range(4)]
    assert len(set(orders)) > 1


def test_medians_and_shares_of_times():
    times = [Time(10.0, 4.0), Time(30.0, 5.0), Time(20.0, 9.0)]
    assert (wall(times), cpu(times)) == (20, 5)
    assert share([times, [Time(40.0, 42.0)]], cores=2) == pytest.approx(60 / 200)


NAMES = ["alpha", "beta", "gamma", "delta", "eps", "zeta", "eta", "theta"]


def boxes(svg):
    found = {}
    for text in ET.fromstring(svg).iter("text"):
        if text.get("class") == "name":
            left, base = float(text.get("x")), float(text.get("y"))
            found[text.text] = (left, base - LINE, left + LETTER * len(text.text), base)
    return found


@given(st.lists(st.tuples(st.floats(1, 100), st.floats(0.01, 1)), min_size=1, max_size=len(NAMES)))
def test_names_stand_inside_and_hide_no_other(places):
    points = [Point(name, x, y, "#123456") for name, (x, y) in zip(NAMES, places, strict=False)]
    svg = scatter([points], x=Axis("x", "log"), y=Axis("y", "log"), title="t", size=(860, 430))
    found = boxes(svg)
    assert set(found) == {point.name for point in points}
    for name, one in found.items():
        assert one[0] >= 0
        assert one[2] <= 860
        assert one[1] >= 0
        assert one[3] <= 430
        for other, two in found.items():
            apart = min(one[2], two[2]) <= max(one[0], two[0]) or min(one[3], two[3]) <= max(one[1], two[1])
            assert name == other or apart


def test_dots_on_the_front_are_filled_and_what_cannot_be_drawn_is_left_out():
    points = [
        Point("good", 1.0, 0.5, "#111111"),
        Point("<beaten>", 2.0, 0.6, "#222222"),
        Point("dear", 3.0, 0.1, "#333333"),
        Point("exact", 4.0, 0.0, "#444444"),
        Point("unknown", 4.0, None, "#444444"),
    ]
    svg = scatter([points], x=Axis("x", "log"), y=Axis("y", "log"), title="t", floor=0.01)
    dots = {dot.find("title").text.split(":")[0]: dot.get("fill") for dot in ET.fromstring(svg).iter("circle")}
    assert dots == {"good": "#111111", "<beaten>": "none", "dear": "#333333"}
    assert svg.count('class="floor"') == 1
    assert scatter([points[3:]], x=Axis("x", "log"), y=Axis("y", "log"), title="t") == ""


def test_panels_hold_every_chart_and_the_key():
    svg = scatter([[Point("a", 1.0, 1.0, "#111111")]], x=Axis("x", "log"), y=Axis("y", "log"), title="t")
    key = [(f"family {n} <of some>", "#222222") for n in range(9)]
    sheet = ET.fromstring(panels("p.svg", "c", [Panel("One", svg), Panel("Two", svg)], columns=1, key=key).content)
    texts = [element.text for element in sheet.iter(f"{SVG}text")]
    assert {"One", "Two", *(name for name, _ in key)} <= set(texts)
    inner = [each for each in sheet.iter(f"{SVG}svg") if each is not sheet]
    _, _, width, height = map(float, sheet.get("viewBox").split())
    for each in inner:
        assert float(each.get("x")) + float(each.get("width")) <= width
        assert float(each.get("y")) + float(each.get("height")) <= height
    assert float(inner[1].get("y")) >= float(inner[0].get("y")) + float(inner[0].get("height"))


def row(label, technique, ms, error, flicker):
    scores = {"budget.mse": error**2, "budget.flicker": flicker**2, "visible.flicker": flicker}
    found = Trial(Variant(label, technique), Measurement(scores=scores), 1.0)
    return speed.Row(speed.Candidate("others", found.variant), found, [Time(1e3, ms)])


def test_the_answer_names_the_fronts_and_what_is_on_none():
    rows = [row("a", "tsl", 1.0, 0.5, 0.1), row("b", "vmf", 2.0, 0.4, 0.3), row("c", "lean", 3.0, 0.6, 0.2)]
    rows += [row("d", "lean", 4.0, 0.45, 0.2), row("e", "taa", 5.0, 0.6, 0.05)]
    said = speed.sections(speed.Found(rows, 256, 0.01, 100.0), about="Made up.")[0].parts[0]
    error, flicker, visible, beaten = said.splitlines()
    assert re.findall("`(.)`", error) == ["a", "b"]
    assert re.findall("`(.)`", flicker) == re.findall("`(.)`", visible) == ["a", "e"]
    assert re.findall("`(.*?)`", beaten) == ["lean"]


def test_a_sequence_without_errors_has_no_chart_of_them():
    entry = {"technique": "tsl", "scores": {"budget.mse": 0.04, "budget.floor": 0.01}}
    (figure,) = speed_figures([entry], {"tsl": 3.0}, inks(["tsl"]))
    assert "tsl: 0.2 at 3, on the front" in figure.svg
    assert speed_figures([{"technique": "tsl", "scores": {"scale.rmse": 0.1}}], {"tsl": 3.0}, inks(["tsl"])) == []
    assert speed_figures([entry], {}, inks(["tsl"])) == []


def spread(value):
    return {"median": value, "low": value, "high": value}


def peer_report(by_clock, by_cores, by="cores"):
    ratio = {"this": "tsl", "that": "peer", "wall": spread(by_clock), "cpu": spread(by_cores)}
    timed = {"ms": spread(1.0), "cpu_ms": spread(2.0), "rms": 0.1}
    rates = {"million_samples_a_second": {"wall": spread(150.0), "cpu": spread(200.0)}}
    return {
        "machine": "a machine",
        "versions": {"peer": "1.0"},
        "settings": {"size": [1280, 720], "rounds": 3, "threads": 2},
        "others": 0.1,
        "covered": 0.6,
        "truth_error": 0.01,
        "results": {"tsl": timed, "peer": timed, "reference": timed | rates},
        "targets": [ratio | {"limit": 1.0, "by": by}],
        "ratios": [ratio],
    }


@pytest.mark.parametrize(
    ("by_clock", "by_cores", "by", "words", "met"),
    [
        (1.1, 1.0, "cores", "met", 1),
        (0.9, 1.2, "cores", "**not met**", 0),
        (0.9, 1.2, "clock", "met", 1),
        (1.1, 0.8, "clock", "**not met**", 0),
    ],
)
def test_targets_against_peers_are_judged_by_what_is_asked(by_clock, by_cores, by, words, met):
    parts = section(peer_report(by_clock, by_cores, by)).parts
    assert f"**{met} of 1 targets are met**" in parts[0]
    assert parts[1].rows[0][-2:] == [f"≤ 1 by the {by}", words]
    assert parts[1].rows[0][:6] == parts[3].rows[0]
    assert [line[0] for line in parts[5].rows] == ["`tsl`", "`peer`", "`reference`"]
    assert [line[-1] for line in parts[5].rows] == [None, None, 150.0]


def test_a_comparison_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(RunError, match=r"nothing\.json"):
        read_peers(tmp_path / "nothing.json")
    path = tmp_path / "other.json"
    for content in ("{", "[]", json.dumps({"settings": {}})):
        path.write_text(content)
        with pytest.raises(RunError, match="run it again"):
            read_peers(path)


def test_the_report_holds_every_setting(swimlab, monkeypatch, tmp_path):
    def short(name):
        sequence = load(name)
        scene = sequence.scene.model_dump()
        return sequence.with_changes(scene=scene | {"road": scene["road"] | {"length": 16.0}})

    monkeypatch.setattr(speed_report, "load", short)
    for name, values in (("HEIGHTS", (36, 72)), ("LENGTHS", (8.0, 16.0)), ("SAMPLES", (4, 16)), ("CLIP", (1, 2))):
        monkeypatch.setattr(growth, name, values)
    (tmp_path / "peers.json").write_text(json.dumps(peer_report(0.5, 0.5)))
    words = ["--size", "128x72", "--frames", "2", "--samples", "100", "--rounds", "1", "--peers", "peers.json"]
    code, out, err = swimlab("bench", "speed-error", *words, "-o", "out", "--json", "-q")
    assert (code, err) == (0, "")
    found = json.loads(out)
    tried = speed.candidates()
    assert {each.variant.technique for each in tried} == set(techniques())
    listed = [cells["technique and setting"].strip("`") for cells in found["tables"]["speed against error"]]
    assert sorted(listed[:-1]) == sorted(each.variant.label for each in tried)
    assert listed[-1] == "the reference, 100 samples"
    assert {cells["grows with"] for cells in found["tables"]["growth"]} >= set(growth.TITLES.values()) - {"threads"}
    page = (tmp_path / "out" / "speed-against-error.md").read_text()
    assert found["provenance"]["command"] in page
    assert "## Against peers" in page
    linked = set(re.findall(r"\]\((\S+)\)", page))
    drawn = list((tmp_path / "out" / "speed-against-error").iterdir())
    assert linked == {f"speed-against-error/{path.name}" for path in drawn}
    for path in drawn:
        ET.fromstring(path.read_text())


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--size", "32x32"], "64x64"),
        (["--rounds", "0"], "at least 1"),
        (["--samples", "64"], "above 64"),
        (["--peers", "none.json"], "none.json"),
    ],
)
def test_what_cannot_be_held_against_each_other_is_refused(swimlab, words, problem):
    code, _, err = swimlab("bench", "speed-error", *words)
    assert (code, problem in err) == (2, True)
    assert not Path("reports").exists()
