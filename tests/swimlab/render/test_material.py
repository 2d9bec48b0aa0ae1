"""Maps from files: how they are decoded, and what is refused."""

import struct
import zlib

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from sequences import Sequence, asphalt
from swimlab.render.inputs import BOX, Maps
from swimlab.render.material import MapError, Material, load_material, read_maps

SIZE = (8, 16)
COLOUR_SPACES = {"linear": "lin_rec709_scene", "sRGB": "srgb_rec709_scene"}


def write(path, pixels, kind=oiio.FLOAT, **attributes):
    """Write pixels [h, w, c]; integers as they are."""
    pixels = np.ascontiguousarray(pixels)
    output = oiio.ImageOutput.create(str(path))
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    for key, value in attributes.items():
        spec.attribute(key.replace("__", ":"), value)
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(pixels), output.geterror()
    assert output.close()


def write_png(path, pixels):
    """Write 8- or 16-bit codes as they are, by no library that could have its own mind about alpha (PNG, RFC 2083)."""
    height, width, channels = pixels.shape
    depth, colour = 8 * pixels.itemsize, {2: 4, 3: 2, 4: 6}[channels]
    rows = b"".join(b"\0" + row.astype(pixels.dtype.newbyteorder(">")).tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    with path.open("wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in ((b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")):
            file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def flat_maps(height=SIZE[0], width=SIZE[1]):
    def filled(*values):
        return np.broadcast_to(np.float32(values), (height, width, len(values))).copy()

    return {"albedo": filled(0.2, 0.3, 0.4), "normal": filled(0, 0, 1), "gloss": filled(0.1, 30)}


@pytest.fixture
def sequence_of(tmp_path):
    """A sequence whose maps are float EXR files beside it, but for maps that are given by name."""

    def sequence_of(**names):
        for key, pixels in flat_maps().items():
            write(tmp_path / f"{key}.exr", pixels)
        table = {"version": 1, "name": "own", "scene": {"material": {k: f"{k}.exr" for k in flat_maps()} | names}}
        return Sequence.model_validate(table, context={"folder": tmp_path})

    return sequence_of


def codes(channels, kind):
    """Integers of every size over a map."""
    top = np.iinfo(kind).max
    values = np.linspace(0, top, SIZE[0] * SIZE[1] * channels).round().astype(kind)
    return np.random.default_rng(0).permutation(values).reshape(*SIZE, channels)


def test_float_maps_are_taken_as_they_are(sequence_of, tmp_path):
    random = np.random.default_rng(1)
    sequence = sequence_of()
    normal = random.normal(size=(*SIZE, 3))
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    given = {"albedo": random.random((*SIZE, 3)), "normal": normal, "gloss": random.uniform(0, 200, (*SIZE, 2))}
    for key, pixels in given.items():
        write(tmp_path / f"{key}.exr", pixels.astype(np.float32))
    for key, found in zip(given, read_maps(sequence)[:3], strict=True):
        assert np.array_equal(found, given[key].astype(np.float32)), key


def srgb_to_linear(c):
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def test_8_bit_png_albedo_is_srgb(sequence_of, tmp_path, tolerance):
    stored = codes(3, np.uint8)
    write_png(tmp_path / "a.png", stored)
    albedo = read_maps(sequence_of(albedo="a.png")).albedo
    assert np.abs(albedo - srgb_to_linear(stored / 255)).max() <= tolerance("decoded 8 bit")


def test_16_bit_tiff_albedo_is_linear(sequence_of, tmp_path, tolerance):
    stored = codes(3, np.uint16)
    write(tmp_path / "a.tif", stored, oiio.UINT16)
    albedo = read_maps(sequence_of(albedo="a.tif")).albedo
    assert np.abs(albedo - stored / 65535).max() <= tolerance("decoded 8 bit")


@pytest.mark.parametrize("space", COLOUR_SPACES)
def test_the_files_own_colour_space_comes_first(sequence_of, tmp_path, tolerance, space):
    stored = np.random.default_rng(2).random((*SIZE, 3)).astype(np.float32)
    write(tmp_path / "a.exr", stored, oiio__ColorSpace=COLOUR_SPACES[space])
    albedo = read_maps(sequence_of(albedo="a.exr")).albedo
    expected = srgb_to_linear(stored) if space == "sRGB" else stored
    assert np.abs(albedo - expected).max() <= tolerance("decoded 8 bit")


@pytest.mark.parametrize(("suffix", "code"), [("png", np.uint8), ("png", np.uint16), ("tif", np.uint16)])
def test_integer_normals_are_2c_minus_1(sequence_of, tmp_path, tolerance, suffix, code):
    stored = codes(3, code)
    if suffix == "png":
        write_png(tmp_path / "n.png", stored)
    else:
        write(tmp_path / "n.tif", stored, oiio.UINT16)
    normal = read_maps(sequence_of(normal=f"n.{suffix}")).normal
    assert np.abs(normal - (2 * (stored / np.iinfo(code).max) - 1)).max() <= tolerance("decoded 8 bit")


@pytest.mark.parametrize(("suffix", "code"), [("png", np.uint8), ("png", np.uint16), ("tif", np.uint16)])
def test_integer_gloss_holds_the_logarithm_of_the_power(sequence_of, tmp_path, tolerance, suffix, code):
    """Two-channel PNG reads as grey and alpha: Ks must not come back multiplied by the power."""
    stored = codes(2, code)
    if suffix == "png":
        write_png(tmp_path / "g.png", stored)
    else:
        write(tmp_path / "g.tif", stored, oiio.UINT16)
    gloss = read_maps(sequence_of(gloss=f"g.{suffix}")).gloss
    scaled = stored / np.iinfo(code).max
    assert np.abs(gloss[..., 0] - scaled[..., 0]).max() <= tolerance("decoded 8 bit")
    assert np.abs(gloss[..., 1] / 2 ** (1 + 12 * scaled[..., 1]) - 1).max() <= tolerance("power of two in float32")


def test_spare_channels_are_left_out(sequence_of, tmp_path, tolerance):
    stored = codes(4, np.uint8)
    write_png(tmp_path / "a.png", stored)
    albedo = read_maps(sequence_of(albedo="a.png")).albedo
    assert albedo.shape == (*SIZE, 3)
    assert np.abs(albedo - srgb_to_linear(stored[..., :3] / 255)).max() <= tolerance("decoded 8 bit")


def test_maps_are_interleaved_in_one_chain(sequence_of, tmp_path, launcher):
    sequence = sequence_of()
    chain = load_material(sequence, launcher).chain(BOX)
    assert (chain.shape.width, chain.shape.height, chain.shape.levels) == (16, 8, 5)
    assert not chain.shape.clamps
    exact = np.float32([0.2, 0.3, 0.4, 0, 0, 1, 0.1, 30])
    assert np.array_equal(chain.texels.numpy()[:128], np.broadcast_to(exact, (128, 8)))


def test_averaged_normals_keep_their_length(launcher, tolerance):
    """Their length says how much they differ."""
    normal = np.array([[[0.6, 0, 0.8], [-0.6, 0, 0.8]], [[0, 0.6, 0.8], [0, -0.6, 0.8]]], np.float32)
    maps = Maps(np.zeros((2, 2, 3), np.float32), normal, np.zeros((2, 2, 2), np.float32))
    chain = Material(launcher, maps).chain(BOX)
    assert chain.texels.numpy()[-1, 3:6] == pytest.approx([0, 0, 0.8], abs=tolerance("mip in float32"))


def test_rows_are_v_and_columns_are_u(launcher):
    albedo = np.zeros((2, 4, 3), np.float32)
    albedo[1, 2] = 1
    maps = Maps(albedo, np.ones((2, 4, 3), np.float32), np.zeros((2, 4, 2), np.float32))
    chain = Material(launcher, maps).chain(BOX)
    assert chain.texels.numpy()[:8, 0].tolist() == [0, 0, 0, 0, 0, 0, 1, 0]


def spoiled(key, channel, value):
    pixels = flat_maps()[key]
    pixels[3, 5, channel] = value
    return pixels


WRONG = {
    "too few channels of albedo": ("albedo", flat_maps()["gloss"], r"has 2 channels; this map needs 3"),
    "too few channels of gloss": ("gloss", flat_maps()["gloss"][..., :1], r"has 1 channels; this map needs 2"),
    "width": ("normal", flat_maps(8, 12)["normal"], r"is 12x8; both sides must be powers of two"),
    "height": ("normal", flat_maps(7, 16)["normal"], r"is 16x7; both sides must be powers of two"),
    "NaN": ("albedo", spoiled("albedo", 1, np.nan), r"has a NaN or Inf, the first at column 5, row 3"),
    "Inf": ("gloss", spoiled("gloss", 1, np.inf), r"has a NaN or Inf, the first at column 5, row 3"),
    "negative albedo": ("albedo", spoiled("albedo", 0, -0.1), r"has negative albedo"),
    "zero normal": ("normal", spoiled("normal", 2, 0), r"has normals of zero length; flat is \(0, 0, 1\)"),
    "long normal": ("normal", spoiled("normal", 0, 1.5), r"float normals must lie in \[-1, 1\]"),
    "negative Ks": ("gloss", spoiled("gloss", 0, -1), r"Ks and power must not be negative"),
    "negative power": ("gloss", spoiled("gloss", 1, -1), r"Ks and power must not be negative"),
}


@pytest.mark.parametrize("what", WRONG)
def test_unfit_maps_are_refused_by_key_and_file(sequence_of, tmp_path, what):
    key, pixels, message = WRONG[what]
    write(tmp_path / "own.exr", pixels)
    with pytest.raises(MapError, match=rf"scene\.material\.{key}: .*own\.exr: {message}"):
        read_maps(sequence_of(**{key: "own.exr"}))


def test_a_missing_map_is_named(sequence_of):
    with pytest.raises(MapError, match=r"scene\.material\.gloss: .*nowhere\.exr: does not exist"):
        read_maps(sequence_of(gloss="nowhere.exr"))


@pytest.mark.parametrize("name", ["text.png", "text.exr", "text"])
def test_what_is_no_picture_is_named(sequence_of, tmp_path, name):
    (tmp_path / name).write_text("no picture at all")
    with pytest.raises(MapError, match=rf"scene\.material\.albedo: .*{name}: is not a picture that can be read: \S"):
        read_maps(sequence_of(albedo=name))


def test_a_cut_off_map_is_named(sequence_of, tmp_path):
    write(tmp_path / "own.exr", np.random.default_rng(0).random((64, 64, 3)).astype(np.float32))
    whole = (tmp_path / "own.exr").read_bytes()
    (tmp_path / "own.exr").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MapError, match=r"scene\.material\.albedo: .*own\.exr: is damaged: \S"):
        read_maps(sequence_of(albedo="own.exr"))


def test_maps_of_different_size_are_refused_with_their_sizes(sequence_of, tmp_path):
    write(tmp_path / "big.exr", flat_maps(32, 32)["normal"])
    with pytest.raises(MapError, match=r"differ in size \(albedo 16x8, normal 32x32, gloss 16x8\)"):
        read_maps(sequence_of(normal="big.exr"))


@pytest.mark.parametrize("size", [(64, 64), (32, 128), (128, 32), (16, 16)])
def test_made_maps_take_the_size_of_those_that_are_files(sequence_of, tmp_path, size, tolerance):
    write(tmp_path / "mine.exr", flat_maps(*size)["normal"])
    sequence = sequence_of(albedo="made:asphalt", gloss="made:asphalt", twist="made:brushed", normal="mine.exr")
    maps = read_maps(sequence)
    assert {plane.shape[:2] for plane in maps} == {size}
    side = max(*size, 64)
    whole = asphalt.make(sequence.seed, side)
    for found, made in ((maps.albedo, whole.albedo), (maps.gloss, whole.gloss)):
        means = (plane.mean(axis=(0, 1), dtype=np.float64) for plane in (found, made))
        assert next(means) == pytest.approx(next(means), rel=tolerance("float32"))
    if size == (64, 64):
        assert np.array_equal(maps.albedo, whole.albedo)


def test_made_normals_stay_of_unit_length(sequence_of, tmp_path, tolerance):
    write(tmp_path / "mine.exr", flat_maps(16, 64)["albedo"])
    maps = read_maps(sequence_of(albedo="mine.exr", normal="made:asphalt", gloss="made:asphalt"))
    assert np.linalg.norm(maps.normal, axis=2) == pytest.approx(1, abs=tolerance("unit in float32"))


def test_made_maps_alone_have_the_size_of_always(sequence_of):
    maps = read_maps(sequence_of(albedo="made:asphalt", normal="made:asphalt", gloss="made:asphalt"))
    assert {plane.shape[:2] for plane in maps if plane is not None} == {(1024, 1024)}
