"""The charts that are pictures, and the page that carries them: places, words, colours, and what is left out."""

import base64
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from report_runs import make_run, make_scores

from metrics import Clip, measure
from metrics.levels import levels_of, rows_of
from swimlab.report.bands_strip import strip
from swimlab.report.class_maps import class_map, edge_map, rgb
from swimlab.report.figures import figures
from swimlab.report.heat import STEPS, UNKNOWN, cells
from swimlab.report.maps import TITLES, maps
from swimlab.report.page import write_report
from swimlab.report.palette import CLASSES, inks
from swimlab.report.plane_slice import NEAR, plane_slice, share_at_home
from swimlab.report.recorded import open_run
from swimlab.report.spectrum_maps import Peak, spectrum_map, stripes

VELOCITY = (23 / 32, 19 / 32)
SPEED = math.hypot(*VELOCITY)


def an_entry(name: str = "tsl", **curves: Any) -> dict[str, Any]:
    frames = [{"frame": 8 + t, "mse": 0.04} for t in range(3)]
    return {"sequence": "road-shift", "technique": name, "scores": {}, "absent": {}, "frames": frames, "curves": curves}


def a_strip(error: list[list[float | None]]) -> dict[str, Any]:
    return {"frequency": [0.0, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2][: len(error)], "error": error}


def a_map(peaks: list[tuple[float, float, float]] = ()) -> dict[str, Any]:
    size = 64
    power = np.full((size, size // 2 + 1), 1e-6)
    return {
        "moire.map": {
            "x": [i / size for i in range(size // 2 + 1)],
            "y": [i / size - 0.5 for i in range(size)],
            "level": rows_of(power),
        },
        "moire.peaks": {axis: [peak[i] for peak in peaks] for i, axis in enumerate(("x", "y", "strength"))},
    }


def a_slice(power: np.ndarray) -> dict[str, Any]:
    rows, columns = power.shape
    return {
        "k": [i / 2 / (columns - 1) for i in range(columns)],
        "w": [i / rows - 0.5 for i in range(rows)],
        "velocity": list(VELOCITY),
        "level": rows_of(power),
    }


def picture_of(svg: str) -> np.ndarray:
    found = re.search(r"data:image/webp;base64,([^\"]+)", svg)
    assert found
    return cv2.imdecode(np.frombuffer(base64.b64decode(found[1]), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def test_cells_are_brighter_the_more_and_grey_where_nothing_is_known() -> None:
    values = np.array([[-1.0, *np.linspace(0, 1, STEPS), 2.0, np.nan]])
    row = picture_of(cells(values, 0.0, 1.0, (0, 0, 10, 10)))[0].astype(float)
    light = row[:-1] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light[1:-1]) > 0).all()
    assert light[0] == light[1]
    assert light[-1] == light[-2]
    assert tuple(row[-1]) == UNKNOWN


def test_the_strips_words_come_from_its_numbers() -> None:
    svg, sentence = strip(an_entry(**{"budget.strip": a_strip([[0.01, 0.02, 0.01], [0.1, 0.1, 0.2]])}))
    assert "most error lies at over 1/32 cycles/pixel" in sentence
    assert "at its worst 0.2 at over 1/32 in frame 10" in sentence
    picture = picture_of(svg)
    assert picture.shape[:2] == (2, 3)
    assert picture[0].sum() > picture[1].sum()  # the higher band lies above
    assert ">8<" in svg  # the clip's first frame


def test_a_strip_without_numbers_is_left_out() -> None:
    assert strip(an_entry()) == ("", "")
    assert strip(an_entry(**{"budget.strip": a_strip([[None], [None]])})) == ("", "")
    svg, sentence = strip(an_entry(**{"budget.strip": a_strip([[None, 0.1, 0.0], [None, 0.0, 0.0]])}))
    assert "nan" not in svg + sentence


@pytest.mark.parametrize(
    ("x", "y", "degrees"),
    [
        *[(0.1, 0.0, 90), (0.0, 0.1, 0), (-0.1, 0.0, 90), (0.1, 0.1, 45), (0.1, -0.1, 135)],
        *[(0.2, 0.2 * math.sqrt(3), 30), (-1e-4, 0.1, 0), (1e-4, 0.1, 0)],
    ],
)
def test_stripes_run_across_their_frequency(x: float, y: float, degrees: int) -> None:
    """Counter-clockwise as seen, y pointing down: waves to the lower right have stripes that rise to the right."""
    assert Peak(x, y, 20).degrees == degrees
    assert Peak(-x, -y, 20).degrees == degrees


def test_a_peak_is_named_and_marked_at_its_place(tolerance: Callable[[str], float]) -> None:
    svg, sentence = spectrum_map(an_entry(**a_map([(-0.15, -0.2, 25.0)])))
    assert "(1) 0.25 cycles/pixel, stripes at 37° every 4 px, 25 dB over their surroundings" in sentence
    tree = ElementTree.fromstring(svg)
    [circle] = [c for c in tree.iter("circle") if c.get("class") == "peak"]
    image = next(i for i in tree.iter("image"))
    left, top, wide, high = (float(image.attrib[key]) for key in ("x", "y", "width", "height"))
    # Cell 9.6 + 1/2 of 33 across, and 12.8 + 32 + 1/2 of 64 down.
    assert float(circle.attrib["cx"]) == pytest.approx(left + (9.6 + 0.5) / 33 * wide, abs=tolerance("drawn place"))
    assert float(circle.attrib["cy"]) == pytest.approx(top + (44.8 + 0.5) / 64 * high, abs=tolerance("drawn place"))


def test_no_peak_is_said_so() -> None:
    svg, sentence = spectrum_map(an_entry(**a_map()))
    assert 'class="peak"' not in svg
    assert sentence.startswith("No peak stands over its surroundings")
    assert spectrum_map(an_entry()) == ("", "")
    assert stripes("data:,", (128, 96), []) == ""


@settings(deadline=None)
@given(frequency=st.floats(0.05, 0.5), angle=st.floats(0, math.pi))
def test_drawn_stripes_have_the_peaks_direction_and_period(
    frequency: float, angle: float, tolerance: Callable[[str], float]
) -> None:
    peak = Peak(frequency * math.cos(angle), frequency * math.sin(angle), 20)
    path = re.search(r'class="stripe" d="([^"]*)"', stripes("data:,", (128, 96), [peak]))
    assert path
    lines = [[float(n) for n in re.findall(r"-?\d+\.\d", part)] for part in path[1].split("M") if part]
    phases = [(x * peak.x + y * peak.y, u * peak.x + v * peak.y) for x, y, u, v in lines]
    for start, end in phases:
        assert abs(start - end) < tolerance("drawn place")
    assert np.diff([start for start, _ in phases]) == pytest.approx(
        [1] * (len(phases) - 1), abs=tolerance("drawn place")
    )


def test_the_share_on_the_full_line_is_what_lies_there(tolerance: Callable[[str], float]) -> None:
    curve = a_slice(np.zeros((32, 33)))
    w, k = np.array(curve["w"])[:, None], np.array(curve["k"])[None, :]
    away = np.abs((w + k * SPEED + 0.5) % 1 - 0.5)
    on, off = np.where(away < 1 / 32, 1.0, 0.0), np.where(away > 0.25, 1.0, 0.0)
    floor = tolerance("mip in float32")
    assert share_at_home(curve, 10 * np.log10(on + 1e-12)) == pytest.approx(1, abs=floor)
    assert share_at_home(curve, 10 * np.log10(off + 1e-12)) == pytest.approx(0, abs=floor)
    sentence = plane_slice(an_entry(**{"plane.slice": a_slice(on)}))[1]
    assert sentence.endswith("100% of the error in this slice is at the full line (of a noise it would be 16%).")


def test_an_error_glued_to_the_surface_is_on_the_full_line_and_a_noise_is_not() -> None:
    random = np.random.default_rng(1)
    surface = random.random((96, 192, 3), dtype=np.float32)
    noise = random.random((32, 96, 160, 3), dtype=np.float32)
    truth = Clip(lambda t: np.zeros((96, 160, 3), np.float32), 32)
    shares = []
    for frame in (lambda t: surface[:, 31 - t : 191 - t], lambda t: noise[t] - noise.mean()):
        found = measure(Clip(frame, 32, fps=60, motion=(1.0, 0.0)), truth, names=["plane"])
        curve = found.curves["plane.slice"]
        shares.append(share_at_home(curve, levels_of(curve["level"])))
    assert shares[0] > 0.98
    assert shares[1] == pytest.approx((2 * NEAR + 1) / 32, rel=0.2)


def test_lines_of_all_first_orders_stay_in_the_plane(tolerance: Callable[[str], float]) -> None:
    slack = tolerance("drawn place")
    svg, _ = plane_slice(an_entry(**{"plane.slice": a_slice(np.ones((32, 33)))}))
    paths = [p for p in ElementTree.fromstring(svg).iter("path") if str(p.get("class")).startswith("order")]
    assert len(paths) == 9
    for path in paths:
        for x, y in re.findall(r"[ML](\S+) ([\d.]+)", path.attrib["d"]):
            assert 62 - slack <= float(x) <= 408 + slack
            assert 10 - slack <= float(y) <= 312 + slack
    along = {**a_slice(np.ones((32, 33))), "velocity": [0.4, 0.0]}
    svg, _ = plane_slice(an_entry(**{"plane.slice": along}))
    assert svg.count('class="order') == 3
    assert plane_slice(an_entry()) == ("", "")


@settings(max_examples=30)
@given(st.lists(st.floats(0, 1e30) | st.none(), min_size=3, max_size=3))
def test_no_strip_holds_nan(row: list[float | None]) -> None:
    svg, sentence = strip(an_entry(**{"budget.strip": a_strip([row, row])}))
    assert not re.search(r"\b(nan|inf)\b", svg + sentence)


def test_a_spike_is_named_and_a_calm_line_is_not() -> None:
    entries = [an_entry("tsl"), an_entry("pixel-point")]
    for item in entries:
        item["frames"] = [{"frame": t, "change": 0.01} for t in range(8)]
    drawn = {figure.title: figure for figure in figures(entries, inks(["tsl", "pixel-point"]))}
    assert "such as" not in drawn["Flicker over time"].sentence
    entries[1]["frames"][6]["change"] = 0.09
    drawn = {figure.title: figure for figure in figures(entries, inks(["tsl", "pixel-point"]))}
    assert drawn["Flicker over time"].sentence.endswith(
        "a spike, such as that of pixel-point at frame 6, 3 times its median."
    )
    assert drawn["Flicker over time"].svg.count('<g data-name="pixel-point">') == 1


FRAME_MAP = {
    "cell": [16],
    "measured": ["100 0 0", "0 50 0"],
    "edges": ["0 100 0", "0 50 0"],
    "new": ["0 0 100", "0 0 0"],
    "flicker": ["-120 -20 -120", "-120 -40 -120"],
}


def test_a_class_of_pixels_has_its_colour_where_it_is() -> None:
    item = an_entry("tsl", **{"frame.map": FRAME_MAP})
    item["scores"] |= {"measured.fraction": 0.5, "edges.fraction": 0.3, "new.fraction": 0.2, "edges.flicker": 0.01}
    svg, sentence = class_map(item)
    codes = picture_of(svg)
    assert [tuple(codes[0, column]) for column in range(3)] == [tuple(rgb(colour)) for colour in CLASSES.values()]
    assert not codes[1, 0].any()
    assert codes[1, 1] == pytest.approx((rgb(CLASSES["measured"]) + rgb(CLASSES["edges"])) / 2, abs=1)
    assert "tiles reach 50%" in sentence
    svg, sentence = edge_map(item)
    assert (picture_of(svg)[[0, 0, 1, 1], [0, 2, 0, 2]] == UNKNOWN).all()
    assert "rms 0.1, about (24, 8) px; on average 0.1" in sentence
    assert edge_map(an_entry("tsl")) == class_map(an_entry("tsl")) == ("", "")


@pytest.fixture
def full(tmp_path: Path) -> tuple[Path, dict[str, Any]]:
    """A run folder and scores with every curve; one technique has a peak."""
    scores = make_scores()
    for place, item in enumerate(scores["sequences"]):
        item["curves"] |= a_map([(0.1, 0.05, 18.0)] if place else [])
        item["curves"]["budget.strip"] = a_strip([[0.1] * 6] * 6)
        item["curves"]["frame.map"] = FRAME_MAP
        item["scores"] |= {"measured.fraction": 0.5, "edges.fraction": 0.3, "new.fraction": 0.2, "edges.flicker": 0.01}
        item["curves"]["plane.slice"] = a_slice(np.full((32, 33), 1e-6))
    return make_run(tmp_path), scores


def test_every_technique_has_its_maps_and_peaks_are_drawn_on_its_picture(full: tuple[Path, dict[str, Any]]) -> None:
    folder, scores = full
    found = maps(open_run(folder), scores["sequences"])
    assert {name: [figure.title for figure in some] for name, some in found.figures.items()} == {
        "pixel-point": list(TITLES),
        "tsl": [*TITLES, "Stripes of the peaks on the picture"],
    }
    assert found.first in found.figures
    assert found.missing == []
    for figure in (figure for some in found.figures.values() for figure in some):
        ElementTree.fromstring(figure.svg)
        assert figure.sentence.endswith(".")
    assert picture_of(found.figures["tsl"][-1].svg).shape == (96, 128, 3)


def test_maps_that_cannot_be_had_say_why(tmp_path: Path) -> None:
    run = open_run(make_run(tmp_path))
    found = maps(run, make_scores()["sequences"])
    assert found.figures == {}
    assert dict(found.missing)["Motion-plane slice"] == "the motion is not uniform"
    assert "measure the run again" in dict(found.missing)[TITLES[0]]
    resized = [{"technique": "tsl", "scores": {}, "curves": {"scale": {"scale": [1.0]}}}]
    assert {reason for _, reason in maps(run, resized).missing} == {"frames of different sizes are no clip"}
    assert maps(run, []).missing == []


def test_the_page_begins_with_the_verdict_and_picks_one_technique_at_a_time(full: tuple[Path, dict[str, Any]]) -> None:
    folder, scores = full
    write_report([folder], scores, folder / "report.html")
    page = (folder / "report.html").read_text(encoding="utf-8")
    places = [page.index(f'id="{name}"') for name in ("verdict", "scores", "charts")]
    assert places[0] == min(places)
    assert "Which technique should I ship, and what does it cost?" in page
    assert len(re.findall(r'<div class="figures" data-technique="[^"]*" hidden>', page)) == 1
    assert not re.search(r"\bNaN\b|>nan<", json.dumps(re.findall(r"<figure>.*?</figure>", page, re.DOTALL)))
    charts = page[page.index('id="charts"') :]
    assert '<button data-name="tsl"' in charts
    assert '<button data-name="bias"' not in charts
