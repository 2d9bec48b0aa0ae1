"""Pictures of a run of brought frames, as the report takes them."""

import numpy as np
import pytest
from small_shot import COUNT, SHOT, SIDE, write_shot

from swimlab.runs.frames import read_channels, write_channels

HIDDEN = 8
"""Rows that an alpha leaves out, in which another input is no number."""


@pytest.mark.parametrize(("table", "opaque", "bare"), [("[reference]", "ref", "one"), ("[builds.one]", "one", "ref")])
def test_what_is_not_measured_need_be_no_number_in_the_report_either(swimlab, tmp_path, table, opaque, bare):
    shot = write_shot(tmp_path)
    shot.write_text(SHOT.replace(table, table + '\nalpha = "mask"'), encoding="utf-8")
    alpha = np.ones((SIDE, SIDE, 1), np.float32)
    alpha[:HIDDEN] = 0
    for t in range(COUNT):
        path = tmp_path / opaque / f"{t}.exr"
        rgba = np.dstack([read_channels(path, ("R", "G", "B")), alpha])
        write_channels(path, rgba, ("R", "G", "B", "A"), half=False, metadata={})
        path = tmp_path / bare / f"{t}.exr"
        pixels = read_channels(path, ("R", "G", "B")).copy()
        pixels[:HIDDEN] = np.nan
        write_channels(path, pixels, ("R", "G", "B"), half=False, metadata={})
    code, _, err = swimlab("study", shot, "-t", "one", "-q", "-o", tmp_path / "run")
    assert code == 0, err
    assert (tmp_path / "run" / "report.html").is_file()
