"""Patterns in paths of other systems, without a file system."""

from pathlib import PurePosixPath, PureWindowsPath

import pytest

from swimlab.footage.pattern import parse_pattern
from swimlab.sweep.openjd import _place


@pytest.mark.parametrize("folder", [r"C:\shots\day 1", r"\\\\server\share\[a] 100%", r"D:\b\u00e9ton #2", r"..\shots"])
def test_a_windows_path_is_read_as_a_pattern(folder: str) -> None:
    pattern = parse_pattern(PureWindowsPath(folder) / "shot.1-48x2####.exr")
    assert pattern is not None
    assert (pattern.folder, pattern.range) == (PureWindowsPath(folder), "1-48x2")
    assert pattern.file_name(7) == "shot.0007.exr"


def test_signs_in_a_folder_are_no_pattern() -> None:
    assert parse_pattern(PurePosixPath("/takes/####/a.exr")) is None


def test_a_file_on_another_drive_has_no_relative_place() -> None:
    assert _place(PureWindowsPath(r"D:\a\s.toml"), PureWindowsPath(r"C:\a")) is None
    assert _place(PureWindowsPath(r"C:\a\b\s.toml"), PureWindowsPath(r"C:\a")) == "b/s.toml"
