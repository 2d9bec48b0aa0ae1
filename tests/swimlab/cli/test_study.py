"""The road study end to end, small: what it writes, what it shows, and the deck's claims in numbers."""

import csv
import json
import shutil
import subprocess
import sys
from math import sqrt
from pathlib import Path

import pytest

from metrics import METRICS
from swimlab.runs.frames import frame_path

FRAMES = 6


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A study of the library's road in 256x144, 6 frames, by way of the command."""
    folder = tmp_path_factory.mktemp("study") / "run"
    script = "from swimlab.cli.main import main; main()"
    words = ["study", "road-shift", "--size", "256x144", "--frames", f"0-{FRAMES - 1}", "--samples", "36"]
    command = [sys.executable, "-c", script, *words, "-o", str(folder)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return folder, result.stdout


@pytest.fixture(scope="module")
def scores(study):
    content = json.loads((study[0] / "scores.json").read_text(encoding="utf-8"))
    return {entry["technique"]: entry["scores"] for entry in content["sequences"]}


def test_point_sampling_sparkles(scores):
    assert sqrt(scores["pixel-point"]["budget.flicker"]) > 4 * sqrt(scores["tsl"]["budget.flicker"])
    assert scores["pixel-point"]["budget.flicker"] > 0.7 * scores["pixel-point"]["budget.mse"]


@pytest.mark.parametrize("technique", ["pixel-aniso", "pixel-trilinear", "lod-hack"])
def test_filtered_inputs_are_at_least_three_times_as_wrong_as_texture_space_lighting(scores, technique):
    assert sqrt(scores[technique]["budget.mse"]) > 3 * sqrt(scores["tsl"]["budget.mse"])


def test_the_level_of_detail_hack_trades_flicker_for_bias(scores):
    assert scores["lod-hack"]["budget.flicker"] < 0.5 * scores["pixel-aniso"]["budget.flicker"]
    assert scores["lod-hack"]["budget.bias"] > 1.5 * scores["pixel-aniso"]["budget.bias"]


def test_the_reference_resolves_every_difference_claimed(scores):
    for technique in scores.values():
        assert technique["budget.floor"] < 0.5 * technique["budget.mse"]


def test_budgets_add_up(scores, tolerance):
    for technique in scores.values():
        for band in ("", ".near", ".mid", ".far"):
            parts = [technique.get(f"budget.{part}{band}") for part in ("bias", "detail", "flicker")]
            if None not in parts:
                assert sum(parts) == pytest.approx(technique[f"budget.mse{band}"], rel=tolerance("closed form"))


def test_every_score_is_there_or_absent_with_a_reason(study):
    content = json.loads((study[0] / "scores.json").read_text(encoding="utf-8"))
    assert content["version"] == 1
    assert content["provenance"]["domain"] == "linear"
    for entry in content["sequences"]:
        assert not set(entry["scores"]) & set(entry["absent"])
        known = {name for name in METRICS if not name.startswith("scale.")}
        assert known <= set(entry["scores"]) | set(entry["absent"])
        assert all(entry["absent"].values())


def test_frames_csv_has_a_row_for_each_technique_and_frame(study, scores):
    with (study[0] / "frames.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == FRAMES * len(scores)
    assert {row["technique"] for row in rows} == set(scores)


def test_the_run_folder_holds_pictures_report_and_contact_sheet(study):
    folder, printed = study
    for technique in ("tsl", "reference", "geometry"):
        assert all(frame_path(folder, technique, frame).is_file() for frame in range(FRAMES))
    assert (folder / "contact.png").stat().st_size > 10_000
    assert "<html" in (folder / "report.html").read_text(encoding="utf-8")[:500]
    assert "lod-hack" in printed
    assert str(folder / "report.html") in printed


def test_measure_and_report_work_on_a_run_alone(study, swimlab):
    code, out, _ = swimlab("measure", study[0], "--domain", "display", "--json", "-q")
    assert code == 0
    assert json.loads(out)["provenance"]["domain"] == "display"
    code, out, _ = swimlab("report", study[0], "-o", "page.html")
    assert (code, out.strip()) == (0, "page.html")


def test_a_missing_picture_is_named(study, swimlab, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(study[0], copy)
    frame_path(copy, "tsl", 2).unlink()
    code, _, err = swimlab("measure", copy, "-q")
    assert code == 2
    assert "0002.exr: is missing" in err


def test_scale_runs_are_measured_by_scale_scores_alone(swimlab):
    words = ["study", "road-scale", "--size", "128x72", "--samples", "16", "-t", "pixel-aniso,tsl", "-o", "run", "-q"]
    code, _, err = swimlab(*words)
    assert code == 0, err
    entries = json.loads(Path("run/scores.json").read_text(encoding="utf-8"))["sequences"]
    for entry in entries:
        assert entry["scores"]
        assert all(name.startswith("scale.") for name in entry["scores"])
    aniso, tsl = (entry["scores"]["scale.rmse"] for entry in entries)
    assert tsl < aniso


def test_peers_are_columns_beside_the_scores(study, swimlab):
    code, out, err = swimlab("measure", study[0], "--peers", "flip-oiio", "--json", "-q")
    assert code == 0, err
    values = {e["technique"]: e["scores"]["flip-oiio.mean"] for e in json.loads(out)["sequences"]}
    assert values["tsl"] < values["pixel-aniso"]
    code, _, err = swimlab("measure", study[0], "--peers", "psnr", "-q")
    assert code == 2
    assert "--peers psnr" in err
