"""The report page and the contact sheet, made from small run folders."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from report_runs import FRAMES, REASON, TECHNIQUES, make_run, make_scores

from metrics import METRICS
from swimlab.report.clips import choose_clips, disputed_region
from swimlab.report.contact import CELL, ENLARGED, GAP, HEADER, NAMES, write_contact_sheet
from swimlab.report.display import srgb
from swimlab.report.page import write_report
from swimlab.report.recorded import ReportError, open_run
from swimlab.runs.frames import FrameError, frame_path, read_frame
from swimlab.runs.record import RunError


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def page(run: Path) -> str:
    write_report([run], make_scores(), run / "report.html")
    return (run / "report.html").read_text(encoding="utf-8")


def viewer_data(page: str) -> dict[str, Any]:
    """The JSON of the viewer, with anything that browsers would reject refused."""
    found = re.search(r'<script type="application/json" id="pictures">(.*?)</script>', page, re.DOTALL)
    assert found

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(found[1], parse_constant=refuse)


def decode(text: str) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(base64.b64decode(text), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def test_the_page_fetches_nothing(page: str) -> None:
    assert not re.search(r"https?://", page)
    assert not re.search(r"""\s(?:src|href|action)\s*=\s*["'](?!data:|#)""", page)
    assert not re.search(r"@import|url\(|\bfetch\(|XMLHttpRequest|\bimport\(", page)
    assert "default-src 'none'" in page


def test_the_page_names_every_technique_score_and_unit(page: str) -> None:
    for name in (*TECHNIQUES, "road-shift", "budget.mse", "budget.flicker", *METRICS, "5e771465", "0.1.0"):
        assert name in page
    assert "0.200" in page  # the root of budget.mse = .04
    assert "12.5" in page


def test_the_page_says_what_its_values_are(page: str, run: Path, tmp_path: Path) -> None:
    assert "Values are linear radiance" in page
    write_report(
        [run], make_scores() | {"provenance": {"domain": "display"}}, tmp_path / "display.html", picture_budget=0
    )
    assert "Values are display codes of 0 to 1 over" in (tmp_path / "display.html").read_text(encoding="utf-8")


def test_the_page_says_where_its_frames_are(page: str) -> None:
    assert "rendered frames are in the run folder as EXR." in page


def test_a_score_that_cannot_be_had_shows_its_reason(page: str) -> None:
    assert f"on plane ({REASON})" in page
    assert f'<td title="{REASON}">—</td>' in page


def test_names_are_escaped(tmp_path: Path) -> None:
    sequence, technique = "</script><script>alert(1)</script>", "<img onerror=alert(2)>"
    techniques = (technique, "reference")
    make_run(tmp_path, sequence=sequence, techniques=techniques)
    write_report([tmp_path], make_scores(sequence=sequence, techniques=techniques), tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "<img" not in page
    assert viewer_data(page)["clips"][0]["techniques"] == list(techniques)


def test_pictures_are_lossless(page: str, run: Path) -> None:
    clip = viewer_data(page)["clips"][0]
    for name in TECHNIQUES:
        for frame, text in zip(clip["frames"], clip["pictures"][name], strict=True):
            assert np.array_equal(decode(text), srgb(read_frame(frame_path(run, name, frame))[..., :3]))


def test_whole_frames_start_where_the_error_changes_most(run: Path) -> None:
    one_frame = choose_clips([open_run(run)], make_scores()["sequences"], 300_000)[0]
    assert one_frame.region is None
    assert max(one_frame.frames) == FRAMES - 1


@pytest.mark.parametrize("budget", [0, 3_000, 60_000, 200_000, 300_000, 500_000, 700_000, 5_000_000])
def test_pictures_keep_to_the_budget_in_consecutive_frames(run: Path, budget: int) -> None:
    clips = choose_clips([open_run(run)], make_scores()["sequences"], budget)
    assert sum(clip.size() for clip in clips) <= budget
    for clip in clips:
        assert clip.frames == list(range(clip.frames[0], clip.frames[-1] + 1))
    if budget >= 5_000_000:
        assert [clip.frames for clip in clips] == 2 * [list(range(FRAMES))]
    assert bool(clips) == (budget >= 60_000)
    assert all(clip.shrunk == 1 for clip in clips) == (budget >= 200_000 or not clips)


def test_a_shrunk_picture_has_means_of_radiance(run: Path) -> None:
    clip = choose_clips([open_run(run)], make_scores()["sequences"], 60_000)[0]
    by, (frame,) = clip.shrunk, clip.frames
    rgb = read_frame(frame_path(run, "tsl", frame))[..., :3]
    means = rgb.reshape(rgb.shape[0] // by, by, rgb.shape[1] // by, by, 3).mean(axis=(1, 3))
    assert by > 1
    assert np.array_equal(decode(clip.pictures["tsl"][frame]), srgb(means))


def test_the_page_says_which_frames_it_carries(run: Path, tmp_path: Path) -> None:
    write_report([run], make_scores(), tmp_path / "report.html", picture_budget=580_000)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    clips = viewer_data(page)["clips"]
    assert [bool(clip["region"]) for clip in clips] == [False, True]
    for clip in clips:
        assert clip["name"].removeprefix("road-shift: ") in page.split("Embedded here:")[1].split("</p>")[0]


def test_a_page_without_room_for_pictures_says_so(run: Path, tmp_path: Path) -> None:
    write_report([run], make_scores(), tmp_path / "report.html", picture_budget=0)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert viewer_data(page)["clips"] == []
    assert "road-shift: none, its frames are too large" in page


def test_the_detail_lies_where_techniques_differ(run: Path) -> None:
    x, y, width, height = disputed_region(open_run(run), 0, (32, 24))
    assert (width, height) == (32, 24)
    assert 90 <= x <= 130 - 32
    assert 40 <= y <= 80 - 24


def test_a_run_without_reference_has_no_error_maps(tmp_path: Path) -> None:
    run = make_run(tmp_path, techniques=("tsl", "lean"))
    write_report([run], make_scores(techniques=("tsl", "lean")), tmp_path / "report.html")
    clip = viewer_data((tmp_path / "report.html").read_text(encoding="utf-8"))["clips"][0]
    assert clip["errors"] == {}
    assert set(clip["pictures"]) == {"tsl", "lean"}


def test_nan_is_refused_by_name(run: Path, tmp_path: Path) -> None:
    with pytest.raises(ReportError, match="road-shift, pixel-point: hold NaN"):
        write_report([run], make_scores(bias=float("nan")), tmp_path / "report.html")


def test_a_missing_frame_leaves_the_old_page_alone(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run")
    frame_path(run, "tsl", 3).unlink()
    (tmp_path / "report.html").write_text("old", encoding="utf-8")
    with pytest.raises(FrameError, match=r"tsl.0003\.exr"):
        write_report([run], make_scores(), tmp_path / "report.html")
    assert [path.name for path in tmp_path.iterdir() if path.is_file()] == ["report.html"]
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == "old"


@pytest.mark.parametrize("content", [None, "{", "[]", '{"sequence": {}}'])
def test_a_folder_that_is_no_run_is_named(tmp_path: Path, content: str | None) -> None:
    if content is not None:
        (tmp_path / "run.json").write_text(content, encoding="utf-8")
    with pytest.raises(RunError, match=r"run\.json: is .*(render|run)"):
        write_report([tmp_path], make_scores(), tmp_path / "report.html")


def test_contact_sheet_has_a_row_a_technique_and_enlarges_exactly(run: Path, tmp_path: Path) -> None:
    write_contact_sheet(run, tmp_path / "sheet.png", techniques=TECHNIQUES, frames=[2, 3])
    sheet = cv2.imread(str(tmp_path / "sheet.png"))[..., ::-1]
    assert sheet.shape == (HEADER + 3 * (CELL[1] + GAP), NAMES + 3 * (CELL[0] + GAP), 3)
    x, y, width, height = disputed_region(open_run(run), 2, (CELL[0] // ENLARGED, CELL[1] // ENLARGED))
    truth = srgb(read_frame(frame_path(run, "tsl", 3))[..., :3])[y : y + height, x : x + width]
    top, left = HEADER + CELL[1] + GAP, NAMES + 2 * (CELL[0] + GAP)
    cell = sheet[top : top + CELL[1], left : left + CELL[0]]
    assert np.array_equal(cell[::ENLARGED, ::ENLARGED], truth)
    assert np.array_equal(cell[ENLARGED - 1 :: ENLARGED, ENLARGED - 1 :: ENLARGED], truth)


@pytest.mark.parametrize(
    ("techniques", "frames", "message"),
    [(["lean"], [0], "no technique lean"), (["tsl"], [99], "no frame 99"), (["tsl"], [], "a frame at least")],
)
def test_contact_sheet_refuses_what_was_not_rendered(
    run: Path, tmp_path: Path, techniques: list[str], frames: list[int], message: str
) -> None:
    with pytest.raises(ReportError, match=message):
        write_contact_sheet(run, tmp_path / "sheet.png", techniques=techniques, frames=frames)
    assert not (tmp_path / "sheet.png").exists()


def test_two_runs_of_one_sequence_are_refused(run: Path, tmp_path: Path) -> None:
    """Their scores would be one table, and the verdict would weigh the last of them only."""
    other = tmp_path / "other"
    other.mkdir()
    (other / "run.json").write_bytes((run / "run.json").read_bytes())
    with pytest.raises(ReportError, match=r"other: holds road-shift, as .* does; .*swimlab compare"):
        write_report([run, other], make_scores(), tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()
