"""What the report says of the motion of brought frames."""

import base64
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from report_runs import FRAMES, SIZE, make_run, make_scores

from swimlab.report.motion_map import TITLE, checked_motion, motion_map
from swimlab.report.page import write_report
from swimlab.report.recorded import Run, open_run
from swimlab.runs.frames import frame_path, write_frame

CHECK = {
    "verdict": "partly",
    "scale": [1.0, 1.0],
    "residual": 0.0213,
    "frames": [4, 5, 9],
    "unfit_fraction": 0.5,
    "unfit": 4 * [12 * "1"] + 4 * [12 * "0"],
    "jitter": 0.0,
    "cuts": [3],
    "repeated": [],
}


def entries(**changed: Any) -> list[dict[str, Any]]:
    return [{"technique": "tsl", "motion": "fields", "motion_check": CHECK | changed, "scores": {}}]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    make_run(tmp_path)
    flat = np.full((SIZE[1], SIZE[0], 4), 0.5, np.float32)
    write_frame(frame_path(tmp_path, "reference", FRAMES // 2), flat, half=False, metadata={})
    return open_run(tmp_path)


def test_what_does_not_fit_is_bright(run: Run) -> None:
    (figure,) = motion_map(run, entries())
    (text,) = re.findall('base64,([^"]+)', figure.svg)
    codes = cv2.imdecode(np.frombuffer(base64.b64decode(text), np.uint8), cv2.IMREAD_COLOR)
    upper, lower = codes[: SIZE[1] // 2], codes[SIZE[1] // 2 :]
    assert upper.min() == upper.max() == 255
    assert lower.max() < 100
    assert f"Frame {FRAMES // 2} of reference" in figure.sentence
    assert "50% of what was compared" in figure.sentence


def test_motion_that_fits_has_no_map_but_a_sentence(run: Run) -> None:
    fits = [{**entries(verdict="verified", frames=[], cuts=[])[0]}]
    del fits[0]["motion_check"]["unfit"]
    assert motion_map(run, fits) == []
    assert checked_motion(fits) == (
        "Motion (fields) fits the frames; between neighbouring frames it leaves 0.0213 of the change."
    )
    assert checked_motion([{"technique": "tsl", "scores": {}}]) == ""


def test_frames_that_do_not_fit_are_named() -> None:
    told = checked_motion(entries(jitter=0.3, repeated=[7]))
    assert told.startswith("Motion (fields) fits the frames in part;")
    for said in ("does not fit frames 4-5,9.", "begin with frames 3.", "Frames 7 show", "jitter of 0.3 px rms."):
        assert said in told


def test_the_page_has_both_and_says_whose_a_note_is(run: Run) -> None:
    scores = make_scores()
    for entry in scores["sequences"]:
        entry |= {"motion": "fields", "motion_check": CHECK, "notes": ["said of all"]}
    scores["sequences"][0]["notes"].append("said of one")
    write_report([run.folder], scores, run.folder / "report.html")
    page = (run.folder / "report.html").read_text(encoding="utf-8")
    assert f"<h4>{TITLE}</h4>" in page
    assert "Motion (fields) fits the frames in part" in page
    assert "Note: said of all" in page
    assert "Note (pixel-point): said of one" in page
