"""Which files a name stands for."""

import re

import pytest

from swimlab.footage.pattern import find_files, frame_range, holds_frames
from swimlab.runs.frames import FrameError


@pytest.fixture
def folder(tmp_path):
    """folder(names...) -> a folder with empty files of these names."""

    def folder(*names):
        for name in names:
            (tmp_path / name).write_bytes(b"")
        return tmp_path

    return folder


def names(files):
    return [path.name for path in files.paths]


@pytest.mark.parametrize(
    ("pattern", "files"),
    [
        ("shot.####.exr", ["shot.0001.exr", "shot.0002.exr"]),
        ("shot.#.exr", ["shot.0001.exr", "shot.0002.exr"]),
        ("shot.##.exr", ["shot.01.exr", "shot.02.exr"]),
        ("shot.%04d.exr", ["shot.0001.exr", "shot.0002.exr"]),
        ("shot.%d.exr", ["shot.9.exr", "shot.10.exr"]),
        ("####.png", ["0001.png", "0002.png"]),
        ("a#b.####.exr", ["a#b.0001.exr", "a#b.0002.exr"]),
        ("shot_v2####.exr", ["shot_v20001.exr", "shot_v20002.exr"]),
        ("shot.####.exr", ["shot.9999.exr", "shot.10000.exr"]),
    ],
)
def test_padding(folder, pattern, files):
    """Neither other names nor other numbers of digits are taken."""
    found = find_files(str(folder(*files, "shot.1.exr.bak", "other.0001.exr", "shot.00001.exr") / pattern))
    assert names(found) == files
    assert found.missing == ()


@pytest.mark.parametrize(
    ("files", "pattern"),
    [
        (["shot_020-0001.exr", "shot_020-0002.exr"], "shot_020-####.exr"),
        (["shot_020-0001.exr", "shot_020-0002.exr"], "shot_020-%04d.exr"),
        (["v-2.0001.exr", "v-2.0002.exr"], "v-2.####.exr"),
        (["2-1-0001.png", "2-1-0002.png"], "2-1-####.png"),
        (["s.-0002.exr", "s.-0001.exr", "s.0000.exr", "s.0001.exr"], "s.####.exr"),
        (["s.-002.exr", "s.-001.exr", "s.0000.exr"], "s.####.exr"),
        (["s.-2.exr", "s.-1.exr", "s.0.exr"], "s.%d.exr"),
        (["s.9.exr", "s.10.exr", "s.11.exr"], "s.%d.exr"),
        (["s.9999.exr", "s.10000.exr"], "s.####.exr"),
        (["s98.jxl", "s99.jxl", "s100.jxl"], "s##.jxl"),
        (["a_7.ppm", "a_8.ppm"], "a_%d.ppm"),
    ],
)
def test_a_sequence_is_the_same_by_pattern_and_by_folder(folder, files, pattern):
    place = folder(*files)
    for name in (place / pattern, place):
        found = find_files(str(name))
        assert names(found) == files
        assert found.missing == ()


@pytest.mark.parametrize(
    ("files", "pattern", "whole"),
    [
        (["s.8.exr", "s.9.exr", "s.10.exr"], "s.##.exr", "s.%01d.exr"),
        (["s.0999.exr", "s.1000.exr", "s.10000.exr"], "s.%d.exr", "s.%04d.exr"),
        (["s.998.exr", "s.999.exr", "s.1000.exr"], "s.####.exr", "s.%03d.exr"),
    ],
)
def test_a_pattern_is_never_a_part_of_a_sequence(folder, files, pattern, whole):
    place = folder(*files)
    with pytest.raises(
        FrameError, match=rf"leaves out \d of 3 files of one sequence, .*; write {re.escape(whole)}, or"
    ):
        find_files(str(place / pattern))
    last = files[-1].split(".")[1]
    assert names(find_files(str(place / pattern), frames=last)) == files[-1:]
    assert names(find_files(str(place))) == files or "1000" in last


@pytest.mark.parametrize(
    "files", [["s.1.exr", "s.01.exr"], ["s.0001.exr", "s.001.exr"], ["s.01.exr", "t.01.exr"], ["s.1.exr", "s.1.png"]]
)
def test_a_folder_of_two_sequences_is_an_error(folder, files):
    with pytest.raises(FrameError, match="several sequences"):
        find_files(str(folder(*files)))


def test_two_files_of_one_number_are_an_error(folder):
    place = folder("s.-0001.exr", "s.-001.exr", "s.0000.exr")
    with pytest.raises(FrameError, match=r"s\.-0001\.exr and s\.-001\.exr are both frame -1"):
        find_files(str(place / "s.####.exr"))


@pytest.mark.parametrize(
    ("pattern", "frames", "numbers"),
    [
        ("s.1-7x2####.exr", None, (1, 3, 5, 7)),
        ("s.2,4-5####.exr", None, (2, 4, 5)),
        ("s.####.exr", "1-7x3", (1, 4, 7)),
        ("s.1-2#.exr", "5-8", (1, 2)),
        ("s_1-3%04d.exr", None, (1, 2, 3)),
    ],
)
def test_ranges(folder, pattern, frames, numbers):
    place = folder(*(f"s{separator}{n:04d}.exr" for n in range(1, 9) for separator in "._"))
    found = find_files(str(place / pattern), frames=frames)
    assert found.numbers == numbers
    assert found.missing == ()
    assert all(path.is_file() for path in found.paths)


def test_gaps_are_named(folder):
    place = folder("s.0001.exr", "s.0002.exr", "s.0005.exr")
    assert find_files(str(place / "s.####.exr")).missing == (3, 4)
    assert find_files(str(place / "s.1-6####.exr")).missing == (3, 4, 6)


def test_a_folder_stands_for_its_one_sequence(folder):
    place = folder("0000.exr", "0001.exr", "run.txt", ".0002.exr.tmp")
    assert names(find_files(str(place))) == ["0000.exr", "0001.exr"]
    folder("other.0000.exr")
    with pytest.raises(FrameError, match=r"several sequences \(####\.exr, other\.####\.exr\); name one"):
        find_files(str(place))


def test_a_folder_may_hold_one_file(folder):
    assert names(find_files(str(folder("clip.mkv")))) == ["clip.mkv"]
    assert names(find_files(str(folder("clip.mkv") / "clip.mkv"))) == ["clip.mkv"]


def test_what_is_not_there_is_answered_by_what_is(folder):
    place = folder("shot.0001.exr", "shot.0002.exr")
    with pytest.raises(FrameError, match=r"shto\.####\.exr: no file matches; .* holds shot\.####\.exr"):
        find_files(str(place / "shto.####.exr"))
    with pytest.raises(FrameError, match="there is no folder"):
        find_files(str(place / "none" / "####.exr"))


def test_numbers_in_short():
    assert frame_range(range(32)) == "0-31"
    assert frame_range((1, 3, 5)) == "1-5x2"


@pytest.mark.parametrize(("name", "frames"), [("a.####.exr", True), ("a.exr", True), ("a.MP4", True), ("road", False)])
def test_names_of_frames(name, frames):
    assert holds_frames(name) is frames
