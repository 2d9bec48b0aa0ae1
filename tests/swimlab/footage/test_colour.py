"""Colour spaces by OpenColorIO: what files say, what options say, and the published curves."""

import os
import struct
import subprocess
import sys
import zlib

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from metrics import ocio
from metrics.ocio import find_space, find_view, space_names, view_names
from swimlab.footage.colour import decode, quantisation_floor, resolve
from swimlab.footage.colour_tags import space_of_codes, stated_space
from swimlab.footage.reader import open_frames
from swimlab.footage.source import Look, Source
from swimlab.runs.frames import FrameError

CODES = np.linspace(0, 1, 65)

AP1 = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
# Academy S-2014-004, AP1 to Rec.709 through the Bradford transform from D60 to D65.
AP1_TO_REC709 = np.array([[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055], [-0.02400, -0.12897, 1.15297]])


def greys(codes):
    return np.repeat(np.asarray(codes, np.float32)[None, :, None], 3, axis=2)


def pq(codes):
    """SMPTE ST 2084, in units of 100 cd/m^2."""
    m1, m2, c1, c2, c3 = 2610 / 16384, 2523 / 32, 3424 / 4096, 2413 / 128, 2392 / 128
    power = codes ** (1 / m2)
    return 100 * (np.maximum(power - c1, 0) / (c2 - c3 * power)) ** (1 / m1)


def hlg(codes):
    """ITU-R BT.2100, of greys on a display of 1000 cd/m^2, whose system gamma is 1.2; in units of 100 cd/m^2."""
    a = 0.17883277
    b, c = 1 - 4 * a, 0.5 - a * np.log(4 * a)
    scene = np.where(codes <= 0.5, codes**2 / 3, (np.exp((codes - c) / a) + b) / 12)
    return 10 * scene**1.2


def srgb(codes):
    """IEC 61966-2-1."""
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def acescct(codes):
    """Academy S-2016-001."""
    return np.where(
        codes <= 0.155251141552511, (codes - 0.0729055341958355) / 10.5402377416545, 2 ** (codes * 17.52 - 9.72)
    )


@pytest.mark.parametrize(
    ("space", "curve"),
    [
        ("Rec.2100-PQ - Display", pq),
        ("hlg_rec2020_display", hlg),
        ("acescct", acescct),
        ("Gamma 2.4 Encoded Rec.709", lambda codes: codes**2.4),
    ],
)
def test_greys_follow_the_published_curve(space, curve, tolerance):
    found = decode(greys(CODES), resolve(space, stored_as="uint16", metadata=None))
    expected = np.repeat(curve(CODES)[None, :, None], 3, axis=2)
    near = {"rel": tolerance("curve of a colour space"), "abs": tolerance("black of a colour space")}
    assert found == pytest.approx(expected, **near)


def test_srgb_is_its_closed_form_under_any_of_its_names(tolerance):
    for name in ("srgb", "SRGB", "srgb_rec709_scene", "sRGB Encoded Rec.709 (sRGB)", "sRGB - Texture"):
        space = resolve(name, stored_as="uint8", metadata=None)
        assert space == "srgb"
        assert np.abs(decode(CODES, space) - srgb(CODES)).max() < tolerance("closed form")


def test_linear_stays_as_it_is_bit_for_bit():
    values = np.random.default_rng(0).normal(size=(4, 5, 3)).astype(np.float32)
    for name in ("linear", "lin_rec709", "Linear Rec.709 (sRGB)"):
        space = resolve(name, stored_as="float", metadata=None)
        assert space == "linear"
        assert decode(values, space) is values


def test_primaries_are_brought_to_rec709(tolerance):
    colour = np.random.default_rng(1).random((3, 4, 3)).astype(np.float32)
    expected = colour @ AP1_TO_REC709.T
    assert decode(colour, resolve("acescg", stored_as="half", metadata=None)) == pytest.approx(
        expected, abs=tolerance("matrix of five digits")
    )


def test_an_unknown_name_is_told_with_those_close_to_it():
    with pytest.raises(ValueError, match=r"no colour space 'ACESgc'; close to it are .*ACEScg"):
        find_space("ACESgc")
    with pytest.raises(ValueError, match=r"sRGB - Display/ACES 2\.0 - SDR 100 nits \(Rec\.709\)"):
        find_view("sRGB/ACES 2.0 - SDR 100 nits (Rec.709)")


def test_every_listed_name_is_found():
    assert all(find_space(name).name == name for name in space_names())
    assert all("/".join(find_view(name)[1:]) == name for name in view_names())


def test_a_broken_configuration_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(ocio, "CONFIGURATIONS", (str(tmp_path / "none.ocio"),))
    with pytest.raises(ValueError, match=r"none\.ocio.*mend the configuration, or unset OCIO"):
        find_space("acescg")


OWN = """ocio_profile_version: 2
roles: {scene_linear: flat, default: flat}
displays: {screen: [!<View> {name: plain, colorspace: half}]}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace> {name: flat, aliases: [lin_rec709_scene]}
  - !<ColorSpace> {name: half, to_scene_reference: !<MatrixTransform> {matrix: [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]}}
"""


def test_the_users_configuration_comes_first_and_the_built_in_one_fills_its_gaps(tmp_path):
    (tmp_path / "own.ocio").write_text(OWN, encoding="utf-8")
    code = (
        "import numpy as np\n"
        "from metrics.ocio import find_space, find_view, show, to_working\n"
        "grey = np.full((2, 2, 3), .25, np.float32)\n"
        "print(to_working(grey, find_space('half')).max(), show(grey, find_view('screen/plain')).max())\n"
        "print(find_space('acescg').configuration)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=os.environ | {"OCIO": str(tmp_path / "own.ocio")},
        check=True,
    )
    assert done.stdout.split() == ["0.5", "0.125", "ocio://studio-config-latest"]


def png16(path, codes, *chunks):
    """A PNG of 16-bit codes 0..1 [H, W, 3] with (name, data) chunks before its pixels."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, _ = codes.shape
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in np.rint(65535 * codes))
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0))
    body = b"".join(chunk(*each) for each in chunks) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + head + body)
    return str(path)


@pytest.mark.parametrize(
    ("chunks", "curve"),
    [
        ([(b"cICP", bytes((9, 16, 0, 1)))], pq),
        ([(b"cICP", bytes((9, 18, 0, 1)))], hlg),
        ([(b"cICP", bytes((12, 13, 0, 1)))], srgb),
        ([(b"gAMA", struct.pack(">I", 45455))], lambda codes: codes**2.2),
        ([(b"gAMA", struct.pack(">I", 100000))], lambda codes: codes),
        ([(b"sRGB", b"\0")], srgb),
        ([], lambda codes: codes),
    ],
)
def test_a_png_is_what_its_chunks_say(tmp_path, chunks, curve, tolerance):
    codes = np.rint(65535 * greys(CODES)) / 65535
    found = Source(open_frames(png16(tmp_path / "a.png", codes, *chunks)), Look()).picture(0)
    near = {"rel": tolerance("curve of a colour space"), "abs": tolerance("black of a colour space")}
    assert found == pytest.approx(curve(codes.astype(np.float64)), **near)


@pytest.mark.parametrize(
    ("chunk", "said"),
    [
        ((b"gAMA", struct.pack(">I", 38462)), "g26_rec709_scene"),
        ((b"cICP", bytes((1, 9, 0, 1))), "H.273 primaries 1, transfer 9"),
        ((b"cICP", bytes((10, 16, 0, 1))), "H.273 primaries 10, transfer 16"),
    ],
)
def test_what_is_not_known_is_refused_by_name(tmp_path, chunk, said):
    name = png16(tmp_path / "a.png", greys(CODES), chunk)
    with pytest.raises(FrameError, match=rf"a\.png: says that it is in {said}, which is not known: .*--colorspace"):
        Source(open_frames(name), Look())
    assert Source(open_frames(name), Look(colour_space="linear")).picture(0).shape == (1, 65, 3)


def exr(path, pixels, **attributes):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "float")
    for key, value in attributes.items():
        if isinstance(value, tuple):
            spec.attribute(key, oiio.TypeDesc("float[8]"), value)
        else:
            spec.attribute(key.replace("__", ":"), value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(pixels, np.float32))
    output.close()
    return str(path)


@pytest.mark.parametrize(
    ("attributes", "space"),
    [
        ({"chromaticities": AP1}, "ACEScg"),
        ({"chromaticities": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)}, "linear"),
        ({"chromaticities": (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329)}, "Linear Rec.2020"),
        ({"oiio__ColorSpace": "lin_ap1_scene"}, "ACEScg"),
        ({"oiio__ColorSpace": "srgb_rec709_scene"}, "srgb"),
        ({}, "linear"),
    ],
)
def test_an_exr_is_what_its_attributes_say(tmp_path, attributes, space):
    assert Source(open_frames(exr(tmp_path / "a.exr", greys(CODES), **attributes)), Look()).space == space


def test_chromaticities_of_nothing_known_are_refused(tmp_path):
    name = exr(tmp_path / "a.exr", greys(CODES), chromaticities=(0.7, 0.3, 0.2, 0.7, 0.13, 0.05, 0.31, 0.33))
    with pytest.raises(FrameError, match=r"in chromaticities 0\.7 0\.3 0\.2 .*, which is not known"):
        Source(open_frames(name), Look())


def test_a_frame_of_another_colour_space_is_bad(tmp_path):
    png16(tmp_path / "a.0001.png", greys(CODES), (b"sRGB", b"\0"))
    png16(tmp_path / "a.0002.png", greys(CODES), (b"cICP", bytes((9, 16, 0, 1))))
    source = Source(open_frames(str(tmp_path / "a.####.png")), Look())
    assert "a.0002.png: says that it is in pq_rec2020_display, the first frame srgb" in source.problems()[1]


def test_code_points_of_ordinary_video_are_taken_as_srgb():
    assert {space_of_codes(p, t) for p in (1, 2, 5, 6, 9) for t in (1, 2, 6, 14, 15)} == {"srgb"}


def test_grey_files_are_decoded_too(tmp_path, tolerance):
    name = exr(tmp_path / "a.exr", np.full((2, 3, 1), 0.5, np.float32))
    found = Source(open_frames(name), Look(colour_space="acescct")).picture(0)
    assert found == pytest.approx(np.full((2, 3, 3), acescct(np.array(0.5))), rel=tolerance("curve of a colour space"))


def test_quantisation_of_pq_is_as_large_as_measured(tolerance):
    exact = np.random.default_rng(0).uniform(0.2, 0.7, 60_000)
    codes = np.round(exact * 255) / 255
    space = resolve("pq_rec2020_display", stored_as="uint8", metadata=None)
    error = np.mean((pq(codes) - pq(exact)) ** 2)
    floor = quantisation_floor(greys(codes), stored_as="uint8", space=space, domain="linear")
    assert floor == pytest.approx(error, rel=tolerance("noise"))


@pytest.mark.parametrize(
    ("described", "said"),
    [
        ("sRGB IEC61966-2.1", "srgb"),
        ("GIMP built-in sRGB", "srgb"),
        ("Display P3", "srgb_p3d65_scene"),
        ("Adobe RGB (1998)", "g22_adobergb_scene"),
        ("GIMP built-in Linear sRGB", "ICC profile GIMP built-in Linear sRGB"),
        ("Dot Gain 20%", "ICC profile Dot Gain 20%"),
    ],
)
def test_an_icc_profile_counts_by_what_it_calls_itself(tmp_path, described, said):
    spec = oiio.ImageSpec(2, 2, 3, "uint8")
    spec.attribute("ICCProfile:profile_description", described)
    spec.attribute("oiio:ColorSpace", "srgb_rec709_scene")
    assert stated_space(tmp_path / "a.tif", spec) == said


@pytest.mark.parametrize(
    ("file", "attribute", "value", "said"),
    [
        ("a.dpx", "dpx:Transfer", "Printing density", "Printing density"),
        ("a.dpx", "dpx:Transfer", "User defined", None),
        ("a.dpx", "oiio:ColorSpace", "KodakLog", "KodakLog"),
        ("a.ppm", "oiio:ColorSpace", "Rec709", "srgb"),
        ("a.pfm", "oiio:ColorSpace", "Rec709", None),
        ("a.exr", "oiio:ColorSpace", "unknown", None),
    ],
)
def test_what_other_files_say(tmp_path, file, attribute, value, said):
    spec = oiio.ImageSpec(2, 2, 3, "uint16")
    spec.attribute(attribute, value)
    assert stated_space(tmp_path / file, spec) == said
