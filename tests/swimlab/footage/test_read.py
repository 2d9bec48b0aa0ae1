"""Reading anyone's files as linear radiance."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from metrics.display import encode
from swimlab.footage.channels import find_colour, find_pair
from swimlab.footage.colour import decode, quantisation_floor, resolve
from swimlab.footage.header import Header, Part, read_header, read_stored
from swimlab.footage.reader import open_frames
from swimlab.footage.source import Box, Look, Source
from swimlab.runs.frames import FrameError

RANDOM = np.random.default_rng(3).random((6, 8, 4), np.float32)


def write(path, pixels, kind, *, names=None, **attributes):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    if names:
        spec.channelnames = names
    for key, value in attributes.items():
        spec.attribute(key.replace("__", ":"), value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(pixels))
    assert output.close()
    return str(path)


def write_parts(path, *parts):
    """Each part: name, channels, pixels."""
    specs = []
    for name, channels, pixels in parts:
        spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], oiio.FLOAT)
        spec.channelnames = channels
        spec.attribute("oiio:subimagename", name)
        specs.append(spec)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), tuple(specs))
    for index, (_, _, pixels) in enumerate(parts):
        assert index == 0 or output.open(str(path), specs[index], "AppendSubimage")
        assert output.write_image(np.ascontiguousarray(pixels))
    assert output.close()
    return str(path)


def picture(name, **look):
    return Source(open_frames(name), Look(**look)).picture(0)


def test_floats_come_as_they_are(tmp_path):
    for kind, exact in ((oiio.FLOAT, RANDOM), (oiio.HALF, RANDOM.astype(np.float16).astype(np.float32))):
        name = write(tmp_path / "a.exr", RANDOM[..., :3], kind)
        assert np.array_equal(picture(name), exact[..., :3])


@pytest.mark.parametrize(
    ("file", "kind", "space"),
    [
        ("a.png", oiio.UINT8, "srgb"),
        ("a.tif", oiio.UINT8, "srgb"),
        ("a.tif", oiio.UINT16, "linear"),
        ("a.tif", oiio.FLOAT, "linear"),
    ],
)
def test_integers_are_decoded_by_the_stated_rule(tmp_path, tolerance, file, kind, space):
    linear = RANDOM[..., :3]
    name = write(tmp_path / file, (encode(linear) if space == "srgb" else linear).astype(np.float32), kind)
    source = Source(open_frames(name), Look())
    assert source.space == space
    assert np.abs(source.picture(0) - linear).max() < tolerance("8 bit code")
    assert np.array_equal(picture(name, colour_space="linear"), read_stored(tmp_path / file, 0, "RGB"))


def test_16_bit_png_is_what_its_metadata_says(tmp_path):
    pixels = RANDOM[..., :3]
    assert Source(open_frames(write(tmp_path / "a.png", pixels, oiio.UINT16)), Look()).space == "srgb"
    lin = write(tmp_path / "b.png", pixels, oiio.UINT16, oiio__ColorSpace="lin_rec709_scene")
    assert Source(open_frames(lin), Look()).space == "linear"
    # Without any of the chunks that speak of colour.
    data = (tmp_path / "a.png").read_bytes()
    for chunk in (b"sRGB", b"gAMA", b"cHRM"):
        at = data.index(chunk) - 4
        data = data[:at] + data[at + 12 + int.from_bytes(data[at : at + 4], "big") :]
    (tmp_path / "c.png").write_bytes(data)
    assert Source(open_frames(str(tmp_path / "c.png")), Look()).space == "linear"


def test_resolve_states_the_rule():
    assert resolve("auto", stored_as="half", metadata="srgb_rec709_scene") == "srgb"
    assert resolve("auto", stored_as="half", metadata=None) == "linear"
    assert resolve("srgb", stored_as="float", metadata=None) == "srgb"
    assert resolve("auto", stored_as="uint16", metadata=None) == "linear"
    assert resolve("auto", stored_as="uint8", metadata="lin_rec709") == "linear"


def test_decoding_is_the_inverse_of_encoding(tolerance):
    codes = np.linspace(0, 1, 256)
    assert np.abs(encode(decode(codes, "srgb")) - codes).max() < tolerance("srgb")


def test_parts_and_layers(tmp_path):
    colour, motion = RANDOM, RANDOM[..., :2] - 1
    name = write_parts(
        tmp_path / "a.exr",
        ("rgba", ("R", "G", "B", "A"), colour),
        ("mv", ("motion.X", "motion.Y"), motion),
        ("aov", ("diffuse.R", "diffuse.G", "diffuse.B"), 2 * colour[..., :3]),
    )
    assert np.array_equal(picture(name), colour[..., :3])
    assert np.array_equal(picture(name, channels="diffuse"), 2 * colour[..., :3])
    assert np.array_equal(picture(name, channels="B,G,R"), colour[..., [2, 1, 0]])
    assert np.array_equal(picture(name, channels="motion.X"), np.repeat(motion[..., :1], 3, axis=2))
    header = read_header(tmp_path / "a.exr")
    part, pair = find_pair(header, (("u", "v"), ("motion.X", "motion.Y")), name)
    assert np.array_equal(read_stored(tmp_path / "a.exr", part, pair), motion)


def test_a_layer_alone_is_the_colour():
    header = Header(
        (8, 6), (Part("", ("View.Combined.B", "View.Combined.G", "View.Combined.R"), ("half",) * 3),), "zip"
    )
    assert find_colour(header, None, "a.exr")[1] == ("View.Combined.R", "View.Combined.G", "View.Combined.B")
    grey = Header((8, 6), (Part("", ("Y", "A"), ("half",) * 2),), "zip")
    assert find_colour(grey, None, "a.exr")[1] == ("Y",)


def test_several_layers_must_be_chosen_from():
    layers = tuple(f"{layer}.{c}" for layer in ("key", "fill") for c in "RGB")
    header = Header((8, 6), (Part("", layers, ("half",) * 6),), "zip")
    with pytest.raises(FrameError, match="which channels are the colour"):
        find_colour(header, None, "a.exr")
    assert find_colour(header, "fill", "a.exr")[1] == ("fill.R", "fill.G", "fill.B")


@pytest.mark.parametrize(("x", "y", "seen"), [(6, -1, (2, 2)), (-3, 1, (1, 3)), (-4, 1, (0, 3)), (-60, 90, (0, 0))])
def test_a_data_window_is_put_into_the_display_window(tmp_path, x, y, seen):
    """What is of it in sight, though it be nothing; the rest is 0."""
    spec = oiio.ImageSpec(4, 3, 3, oiio.FLOAT)
    spec.x, spec.y = x, y
    spec.full_x = spec.full_y = 0
    spec.full_width, spec.full_height = 8, 6
    output = oiio.ImageOutput.create("exr")
    assert output.open(str(tmp_path / "a.exr"), spec)
    assert output.write_image(np.ones((3, 4, 3), np.float32))
    output.close()
    expected = np.zeros((6, 8, 3))
    expected[max(y, 0) : max(y + 3, 0), max(x, 0) : max(x + 4, 0)] = 1
    assert np.array_equal(picture(str(tmp_path / "a.exr")), expected)
    assert expected.sum() == 3 * seen[0] * seen[1]


def test_alpha_is_used_as_asked(tmp_path):
    pixels = RANDOM.copy()
    pixels[0, :4, 3] = [0, 0.5, 1, 1]
    name = write(tmp_path / "a.exr", pixels, oiio.FLOAT)
    reader = open_frames(name)
    assert not Source(reader, Look()).has_coverage
    masked = Source(reader, Look(alpha="mask"))
    assert np.array_equal(masked.picture(0), pixels[..., :3])
    assert masked.coverage(0)[0, :4].tolist() == [0, 0, 1, 1]
    divided = Source(reader, Look(alpha="unpremultiply"))
    assert np.array_equal(divided.picture(0)[0, :3], pixels[0, :3, :3] * [[0], [2], [1]])
    assert divided.coverage(0)[0, :4].tolist() == [0, 1, 1, 1]


def test_png_colours_are_not_multiplied_by_alpha(tmp_path):
    codes = np.round(RANDOM * 255) / 255
    name = write(tmp_path / "a.png", codes, oiio.UINT8, oiio__UnassociatedAlpha=1)
    for alpha in ("ignore", "unpremultiply"):
        got = picture(name, colour_space="linear", alpha=alpha)
        assert np.array_equal(np.round(got * 255), np.round(codes[..., :3] * 255))


def test_crop(tmp_path):
    name = write(tmp_path / "a.exr", RANDOM[..., :3], oiio.FLOAT)
    source = Source(open_frames(name), Look(crop=Box(2, 1, 5, 4)))
    assert source.shape == (4, 5)
    assert np.array_equal(source.picture(0), RANDOM[1:5, 2:7, :3])


@pytest.mark.parametrize("kind", ["uint8", "uint16"])
@pytest.mark.parametrize("space", ["linear", "srgb"])
def test_quantisation_is_as_large_as_measured(tolerance, kind, space):
    """Round many values to codes: their mean squared error is the stated floor."""
    levels = {"uint8": 255, "uint16": 65535}[kind]
    exact = np.random.default_rng(0).uniform(0.1, 0.9, 200_000)
    codes = np.round(exact * levels) / levels
    error = np.mean((decode(codes, space) - decode(exact, space)) ** 2)
    floor = quantisation_floor(codes, stored_as=kind, space=space, domain="linear")
    assert floor == pytest.approx(error, rel=tolerance("noise"))


def test_quantisation_of_halves_and_of_limited_range(tolerance):
    exact = np.random.default_rng(0).uniform(0.1, 9, 200_000)
    halves = exact.astype(np.float16).astype(np.float32)
    floor = quantisation_floor(halves, stored_as="half", space="linear", domain="linear")
    assert floor == pytest.approx(np.mean((halves - exact) ** 2), rel=tolerance("noise"))
    assert quantisation_floor(halves, stored_as="float", space="linear", domain="linear") is None
    limited = quantisation_floor(exact, stored_as="uint8", space="linear", domain="linear", full_scale=219)
    assert limited == pytest.approx(1 / 219**2 / 12, rel=tolerance("closed form"))
    shown = quantisation_floor(np.full(9, 0.5), stored_as="uint8", space="srgb", domain="display")
    assert shown == pytest.approx(1 / 255**2 / 12, rel=tolerance("rounding of means"))


def test_frames_are_read_one_at_a_time_and_named(tmp_path):
    for n in range(1, 4):
        write(tmp_path / f"a.{n:04d}.exr", np.full((4, 4, 3), n, np.float32), oiio.FLOAT, FramesPerSecond=24.0)
    reader = open_frames(str(tmp_path / "a.####.exr"))
    assert reader.header.fps == 24
    assert [reader.read(i, 0, "R").max() for i in range(3)] == [1, 2, 3]
    assert reader.label(1).endswith("a.0002.exr")
