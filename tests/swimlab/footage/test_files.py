"""What is odd in files of frames is read right or refused by name."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from swimlab.footage.channels import find_colour, find_pair
from swimlab.footage.header import Header, Part, read_header
from swimlab.footage.reader import open_frames
from swimlab.footage.request import Request
from swimlab.footage.source import Look, Source
from swimlab.footage.subject import Subject
from swimlab.runs.frames import FrameError

CHANNELS = ("R", "G", "B")
WIDTH, HEIGHT = 12, 8


def flat_spec(name="", **traits):
    spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, "float")
    spec.channelnames = CHANNELS
    for key, value in traits.items():
        setattr(spec, key, value)
    if name:
        spec.attribute("oiio:subimagename", name)
    return spec


def deep_data(spec, value=0.25):
    data = oiio.DeepData()
    data.init(WIDTH * HEIGHT, 3, (oiio.FLOAT,) * 3, spec.channelnames)
    for pixel in range(WIDTH * HEIGHT):
        data.set_samples(pixel, 2)
        for sample in range(2):
            for channel in range(3):
                data.set_deep_value(pixel, channel, sample, value)
    return data


def test_a_deep_file_is_refused_by_name(tmp_path, swimlab):
    spec = flat_spec()
    spec.deep = True
    output = oiio.ImageOutput.create(str(tmp_path / "d.0000.exr"))
    assert output.open(str(tmp_path / "d.0000.exr"), spec)
    assert output.write_deep_image(deep_data(spec))
    output.close()
    for words in (("info", tmp_path / "d.####.exr"), ("measure", "--test", tmp_path / "d.####.exr")):
        code, _, err = swimlab(*words)
        assert code == 2
        assert "d.0000.exr: is deep" in err


@pytest.mark.parametrize("deep_first", [False, True])
def test_the_flat_part_beside_a_deep_one_is_read(deep_first):
    flat, deep = (Part(name, CHANNELS, ("float",) * 3, deep=name == "deep") for name in ("flat", "deep"))
    header = Header((8, 6), (deep, flat) if deep_first else (flat, deep), "zips")
    assert find_colour(header, None, "mixed.exr") == (int(deep_first), CHANNELS)
    assert find_pair(header, (("R", "G"),), "mixed.exr") == (int(deep_first), ("R", "G"))
    with pytest.raises(FrameError, match=r"--part deep: is a deep part of mixed\.exr; flatten it"):
        find_colour(header, None, "mixed.exr", part="deep")


@pytest.mark.parametrize("rate", [(0, 0), (0, 1), (24, 0), (-24, 1)])
def test_a_rate_of_nothing_is_no_rate(tmp_path, rate):
    spec = flat_spec()
    spec.attribute("FramesPerSecond", oiio.TypeDesc("rational"), rate)
    output = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert output.open(str(tmp_path / "a.exr"), spec)
    output.write_image(np.ones((HEIGHT, WIDTH, 3), np.float32))
    output.close()
    assert read_header(tmp_path / "a.exr").fps is None


@pytest.mark.parametrize(
    ("x", "y", "inside"),
    [(-4, 0, 8), (-12, 0, 0), (-100, 3, 0), (20, 0, 0), (500, 0, 0), (0, -8, 0), (0, 30, 0), (30, -30, 0), (11, 0, 1)],
)
def test_data_beside_the_picture_is_left_out_and_the_rest_is_empty(tmp_path, x, y, inside):
    """Data as large as the picture, shifted; the picture has its width."""
    spec = flat_spec(x=x, y=y, full_x=0, full_y=0, full_width=WIDTH, full_height=HEIGHT)
    output = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert output.open(str(tmp_path / "a.exr"), spec)
    output.write_image(np.ones((HEIGHT, WIDTH, 3), np.float32))
    output.close()
    pixels = Source(open_frames(str(tmp_path / "a.exr")), Look()).picture(0)
    assert pixels.shape == (HEIGHT, WIDTH, 3)
    assert pixels.sum() == 3 * inside * max(HEIGHT - abs(y), 0) * (inside > 0)


@pytest.mark.parametrize("suffix", ["ppm", "pfm", "bmp", "tga", "sgi", "tif", "dpx", "hdr"])
def test_a_folder_of_any_format_is_a_sequence(tmp_path, suffix):
    for number in (8, 9, 10):
        spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, "float" if suffix in ("pfm", "hdr") else "uint8")
        path = str(tmp_path / f"a{number}.{suffix}")
        output = oiio.ImageOutput.create(path)
        assert output.open(path, spec)
        output.write_image(np.full((HEIGHT, WIDTH, 3), number / 16, np.float32))
        output.close()
    (tmp_path / "notes.txt").write_text("not a picture", encoding="utf-8")
    source = Source(open_frames(str(tmp_path)), Look(colour_space="linear"))
    assert source.reader.numbers == (8, 9, 10)
    assert [round(16 * float(source.picture(index).mean()), 1) for index in range(3)] == [8, 9, 10]


def test_a_moving_picture_is_refused_as_a_still_one(tmp_path):
    spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, "uint8")
    spec.attribute("oiio:Movie", 1)
    path = str(tmp_path / "a.gif")
    output = oiio.ImageOutput.create(path)
    assert output.open(path, (spec, spec))
    for part in range(2):
        assert part == 0 or output.open(path, spec, "AppendSubimage")
        output.write_image(np.full((HEIGHT, WIDTH, 3), part, np.uint8))
    output.close()
    with pytest.raises(FrameError, match="is a moving picture"):
        read_header(tmp_path / "a.gif")


@pytest.mark.parametrize(("aspect", "said"), [(1.0, ""), (1.0004, ""), (2.0, "2 times as wide as high")])
def test_pixels_that_are_not_square_are_told(tmp_path, swimlab, aspect, said):
    spec = flat_spec()
    spec.attribute("PixelAspectRatio", aspect)
    for t in range(2):
        output = oiio.ImageOutput.create(str(tmp_path / f"a.{t}.exr"))
        assert output.open(str(tmp_path / f"a.{t}.exr"), spec)
        output.write_image(np.ones((HEIGHT, WIDTH, 3), np.float32))
        output.close()
    assert read_header(tmp_path / "a.0.exr").oblong == said
    notes = []
    Subject(Request(test=str(tmp_path / "a.%d.exr")), notes.append, notes.append)
    assert any("its pixels are" in note for note in notes) == bool(said)
    if said:
        code, _, err = swimlab("measure", "--test", tmp_path / "a.%d.exr", "--pixels-per-degree", 40)
        assert code == 2
        assert "--pixels-per-degree: " in err
        assert f"has pixels {said}, so that no one number holds" in err
