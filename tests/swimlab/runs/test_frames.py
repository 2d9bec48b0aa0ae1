"""Frame files."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from swimlab.runs.files import replacing, write_json, write_text
from swimlab.runs.frames import (
    FrameError,
    Geometry,
    frame_path,
    read_channels,
    read_frame,
    read_geometry,
    write_channels,
    write_frame,
    write_geometry,
)


@pytest.fixture
def picture():
    return np.random.default_rng(0).normal(0, 10, (7, 13, 4)).astype(np.float32)


def spec_of(path):
    source = oiio.ImageInput.open(str(path))
    spec = source.spec()
    source.close()
    return spec


def test_floats_come_back_bit_by_bit(tmp_path, picture):
    picture[0, :4] = [[1e38, -1e-38, 0.0, 1.0]] * 4
    path = tmp_path / "0000.exr"
    write_frame(path, picture, half=False, metadata={})
    assert read_frame(path).tobytes() == picture.tobytes()


def test_halves_come_back_as_the_nearest_half(tmp_path, picture):
    path = tmp_path / "0000.exr"
    write_frame(path, picture, half=True, metadata={})
    assert np.array_equal(read_frame(path), picture.astype(np.float16).astype(np.float32))


@pytest.mark.parametrize("half", [False, True])
def test_pictures_hold_what_the_contract_says(tmp_path, picture, half):
    path = tmp_path / "0000.exr"
    write_frame(path, picture, half=half, metadata={"swimlab:hash": "abc"})
    spec = spec_of(path)
    assert sorted(spec.channelnames) == ["A", "B", "G", "R"]
    assert str(spec.format) == ("half" if half else "float")
    assert (spec.width, spec.height) == (13, 7)
    assert spec.get_string_attribute("compression") == "zip"
    assert spec.get_string_attribute("swimlab:hash") == "abc"


def test_geometry_is_always_float(tmp_path):
    random = np.random.default_rng(1)
    geometry = Geometry(
        coverage=random.random((5, 6), np.float32),
        motion=random.normal(0, 64, (5, 6, 2)).astype(np.float32),
        depth=random.random((5, 6), np.float32),
    )
    path = frame_path(tmp_path, "geometry", 12)
    write_geometry(path, geometry, metadata={})
    assert path == tmp_path / "geometry" / "0012.exr"
    spec = spec_of(path)
    assert sorted(spec.channelnames) == ["coverage", "depth.Z", "motion.X", "motion.Y"]
    assert str(spec.format) == "float"
    back = read_geometry(path)
    for name in ("coverage", "motion", "depth"):
        assert np.array_equal(getattr(back, name), getattr(geometry, name))


def test_channels_are_read_by_name_and_not_by_place(tmp_path, picture):
    path = tmp_path / "0000.exr"
    write_channels(path, picture, ("A", "B", "spare", "R"), half=False, metadata={})
    with pytest.raises(FrameError, match=r"0000\.exr: has no channel G; it has .*spare"):
        read_frame(path)
    write_channels(path, picture[..., [3, 2, 1, 0]], ("A", "B", "G", "R"), half=False, metadata={})
    assert np.array_equal(read_frame(path), picture)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FrameError, match=r"0003\.exr: cannot be opened"):
        read_frame(tmp_path / "0003.exr")


def test_what_is_no_picture_is_named(tmp_path):
    path = tmp_path / "0000.exr"
    path.write_text("nothing of the kind")
    with pytest.raises(FrameError, match=r"0000\.exr: cannot be opened"):
        read_geometry(path)


@pytest.mark.parametrize("kept", [0.95, 0.6])
def test_a_damaged_file_is_named(tmp_path, kept):
    picture = np.random.default_rng(0).random((64, 64, 4)).astype(np.float32)
    path = tmp_path / "0000.exr"
    write_frame(path, picture, half=False, metadata={})
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * kept)])
    with pytest.raises(FrameError, match=r"0000\.exr: is damaged"):
        read_frame(path)


def test_a_folder_that_cannot_be_written_is_named(tmp_path, picture):
    (tmp_path / "file").write_text("")
    with pytest.raises((FrameError, OSError), match="file"):
        write_frame(tmp_path / "file" / "0000.exr", picture, half=False, metadata={})


def test_a_write_that_fails_leaves_nothing(tmp_path, picture, monkeypatch):
    class FullDisk:
        def __init__(self, output):
            self.output = output

        def open(self, *arguments):
            return self.output.open(*arguments)

        def write_image(self, pixels):
            return False

        def geterror(self):
            return "no space left"

    create = oiio.ImageOutput.create
    monkeypatch.setattr(oiio.ImageOutput, "create", lambda kind: FullDisk(create(kind)))
    with pytest.raises(FrameError, match=r"0000\.exr: cannot be written: no space left"):
        write_frame(tmp_path / "0000.exr", picture, half=False, metadata={})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError, ValueError])
@pytest.mark.parametrize("existed", [False, True])
def test_an_interrupted_write_leaves_what_was_there(tmp_path, error, existed):
    path = tmp_path / "folder" / "file.txt"
    if existed:
        write_text(path, "old")

    def interrupted() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half a fi")
            raise error

    with pytest.raises(error):
        interrupted()
    assert [each.name for each in path.parent.iterdir()] == (["file.txt"] if existed else [])
    assert not existed or path.read_text() == "old"


def test_a_file_appears_whole_or_not_at_all(tmp_path):
    path = tmp_path / "file.txt"
    with replacing(path) as temporary:
        temporary.write_text("new")
        assert not path.exists()
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_json_has_no_nan(tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(Path(tmp_path / "a.json"), {"score": float("nan")})
    assert list(tmp_path.iterdir()) == []


TALL = np.random.default_rng(1).normal(0, 10, (301, 11, 5)).astype(np.float32)
"""More rows than a strip, and than a block of any compression."""


def write_tall(path, kind, compression, *, kinds=(), **given):
    spec = oiio.ImageSpec(TALL.shape[1], TALL.shape[0], 5, kind)
    spec.channelnames, spec.channelformats = ("B", "G", "R", "X", "Y"), tuple(kinds)
    spec.attribute("compression", compression)
    for name, value in given.items():
        setattr(spec, name, value)
    output = oiio.ImageOutput.create("exr")
    assert output.open(str(path), spec)
    if spec.tile_width:
        assert output.write_tiles(0, 11, 0, 301, 0, 1, TALL)
    else:
        assert output.write_image(TALL)
    assert output.close()


@pytest.mark.parametrize("kind", [oiio.HALF, oiio.FLOAT])
@pytest.mark.parametrize("compression", ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"])
def test_strips_are_the_whole_picture(tmp_path, kind, compression):
    path = tmp_path / "0000.exr"
    write_tall(path, kind, compression)
    source = oiio.ImageInput.open(str(path))
    stored, whole = list(source.spec().channelnames), source.read_image(0, 0, 0, 5, oiio.FLOAT)
    source.close()
    for names in (("R", "G", "B"), ("X", "Y"), ("Y", "B", "X"), ("G",)):
        wanted = [stored.index(name) for name in names]
        assert np.array_equal(read_channels(path, names), whole[..., wanted])
    assert np.array_equal(read_channels(path, ("X", "Y"), rows=(60, 131)), whole[60:131, :, -2:])


@pytest.mark.parametrize(
    "given",
    [
        {"kinds": [oiio.HALF] * 3 + [oiio.FLOAT] * 2},
        {"tile_width": 16, "tile_height": 16},
        {"x": -3, "y": 40},
        {"y": -70},
    ],
)
def test_strips_of_any_layout_are_the_whole_picture(tmp_path, given):
    path = tmp_path / "0000.exr"
    write_tall(path, oiio.FLOAT, "zip", **given)
    exact = TALL.copy()
    if "kinds" in given:
        exact[..., :3] = exact[..., :3].astype(np.float16)
    assert np.array_equal(read_channels(path, ("R", "G", "B")), exact[..., 2::-1])
    assert np.array_equal(read_channels(path, ("X", "Y")), exact[..., 3:])


def test_a_file_cut_short_is_damaged(tmp_path):
    path = tmp_path / "0000.exr"
    write_tall(path, oiio.HALF, "zip")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(FrameError, match=r"0000\.exr: (is damaged|cannot be opened)"):
        read_channels(path, ("R", "G", "B"))


def test_pictures_are_planes_and_vectors_are_pairs_in_memory(tmp_path):
    path = tmp_path / "0000.exr"
    write_tall(path, oiio.HALF, "zip")
    assert np.moveaxis(read_channels(path, ("R", "G", "B")), 2, 0).flags.c_contiguous
    assert read_channels(path, ("X", "Y")).flags.c_contiguous
