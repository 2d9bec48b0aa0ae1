"""The report as a folder: every frame beside the page, written whole or not at all."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from report_runs import FRAMES, TECHNIQUES, make_run, make_scores

from swimlab.cli.report_command import report_command
from swimlab.report.display import error_codes, srgb
from swimlab.report.page import write_report_folder
from swimlab.report.recorded import ReportError
from swimlab.runs.frames import FrameError, frame_path, read_frame


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_run(tmp_path_factory.mktemp("run"))
    (folder / "scores.json").write_text(
        json.dumps(make_scores() | {"provenance": {"hash": "5e771465"}}), encoding="utf-8"
    )
    return folder


def handed(script: Path) -> list[Any]:
    """The arguments that a script hands to the viewer."""
    found = re.fullmatch(r"received\((.*)\);\n", script.read_text(encoding="utf-8"))
    assert found
    return list(json.loads(f"[{found[1]}]"))


def decode(text: str) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(base64.b64decode(text), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def test_the_command_writes_every_frame_of_every_technique(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert report_command(run, folder=True, quiet=True) == 0
    page = run / "report" / "index.html"
    assert capsys.readouterr().out == f"{page}\n"
    scripts = sorted(path.relative_to(page.parent).as_posix() for path in page.parent.glob("pictures/*/*"))
    assert scripts == sorted(f"pictures/0/{name}.{frame:04d}.js" for name in TECHNIQUES for frame in range(FRAMES))
    reference = read_frame(frame_path(run, "reference", 3))
    for technique in TECHNIQUES:
        rgba = read_frame(frame_path(run, technique, 3))
        name, picture, error = handed(page.parent / f"pictures/0/{technique}.0003.js")
        assert name == f"pictures/0/{technique}.0003.js"
        assert np.array_equal(decode(picture), srgb(rgba[..., :3]))
        if technique == "reference":
            assert error is None
        else:
            assert np.array_equal(decode(error)[..., 0], error_codes(rgba, reference))


def test_a_report_folder_is_replaced_and_nothing_else_is(run: Path, tmp_path: Path) -> None:
    write_report_folder([run], make_scores(), tmp_path / "report")
    (tmp_path / "report" / "pictures" / "0" / "gone.0000.js").touch()
    write_report_folder([run], make_scores(), tmp_path / "report")
    assert not (tmp_path / "report" / "pictures" / "0" / "gone.0000.js").exists()
    (tmp_path / "report" / "thesis.txt").touch()
    with pytest.raises(ReportError, match=r"is no report folder \(thesis\.txt is there\); name another with --output"):
        write_report_folder([run], make_scores(), tmp_path / "report")
    with pytest.raises(ReportError, match="a file is there"):
        write_report_folder([run], make_scores(), tmp_path / "report" / "thesis.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["report"]


def test_a_missing_frame_leaves_the_old_folder_alone(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run")
    write_report_folder([run], make_scores(), tmp_path / "report")
    before = {path: path.read_bytes() for path in (tmp_path / "report").rglob("*") if path.is_file()}
    frame_path(run, "tsl", FRAMES - 1).unlink()
    with pytest.raises(FrameError, match=r"tsl.0005\.exr"):
        write_report_folder([run], make_scores(), tmp_path / "report")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report", "run"]
    assert {path: path.read_bytes() for path in (tmp_path / "report").rglob("*") if path.is_file()} == before


def test_runs_keep_the_order_given_or_that_of_the_study(tmp_path: Path) -> None:
    for name in "abc":
        run = make_run(tmp_path / name, sequence=name)
        scores = make_scores(sequence=name) | {"provenance": {"hash": "5e771465"}}
        (run / "scores.json").write_text(json.dumps(scores), encoding="utf-8")
    page = tmp_path / "page.html"

    def order() -> list[str]:
        return re.findall("<h3>([abc])</h3>", page.read_text(encoding="utf-8").split('id="scores"')[1])[:3]

    report_command(tmp_path / "b", tmp_path / "a", output=page)
    assert order()[:2] == ["b", "a"]
    report_command(tmp_path, output=page)
    assert order() == ["a", "b", "c"]
    joined = {"version": 1, "provenance": {}, "sequences": [{"sequence": name} for name in "cab"]}
    (tmp_path / "scores.json").write_text(json.dumps(joined), encoding="utf-8")
    report_command(tmp_path, output=page)
    assert order() == ["c", "a", "b"]
