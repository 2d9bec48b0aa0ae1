"""Every input has its own channels, colour space, alpha and part; and only what is measured must be usable."""

import json

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from metrics.display import encode
from swimlab.footage.request import Request
from swimlab.footage.source import Box, Look
from swimlab.footage.subject import Subject
from swimlab.runs.frames import FrameError

HEIGHT, WIDTH, COUNT = 48, 64, 3
GREY = 0.2 + 0.6 * np.random.default_rng(0).random((6, 8)).repeat(8, 0).repeat(8, 1).astype(np.float32)


def write(path, *parts, kind="float", **attributes):
    """A file of parts, each a mapping of channels to [H, W] pictures; a part's own attributes stand under None."""
    specs = []
    for index, part in enumerate(parts):
        names = [name for name in part if name is not None]
        spec = oiio.ImageSpec(WIDTH, HEIGHT, len(names), kind)
        spec.channelnames = tuple(names)
        for key, value in ({"oiio:subimagename": f"part{index}"} | attributes | part.get(None, {})).items():
            spec.attribute(key, value)
        specs.append(spec)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), tuple(specs)) if len(specs) > 1 else output.open(str(path), specs[0])
    for index, part in enumerate(parts):
        assert index == 0 or output.open(str(path), specs[index], "AppendSubimage")
        pixels = np.dstack([picture for name, picture in part.items() if name is not None])
        assert output.write_image(np.ascontiguousarray(pixels, np.float32))
    assert output.close()


def rgb(picture, layer="", **more):
    return {f"{layer}{channel}": picture for channel in "RGB"} | more


@pytest.fixture
def clip(tmp_path):
    """clip(name, *parts, ...) -> the pattern of a clip of files that are all the same."""

    def clip(name, *parts, suffix="exr", **how):
        for t in range(COUNT):
            write(tmp_path / f"{name}.{t:04d}.{suffix}", *parts, **how)
        return str(tmp_path / f"{name}.####.{suffix}")

    return clip


def subject(test, said=None, **request):
    keep = [] if said is None else said
    return Subject(Request(test=test, **request), lambda _: None, keep.append)


def means(found):
    return tuple(float(source.picture(0).mean()) for source in (found.test, found.reference))


def test_each_has_a_layer_of_its_own(clip, tolerance):
    both = clip("both", rgb(GREY, "Noisy.") | rgb(2 * GREY, "Clean."))
    plain = clip("plain", rgb(3 * GREY))
    noisy = Look(channels="Noisy")
    level = float(GREY.mean())
    for reference, look, expected in ((both, Look("Clean"), 2), (both, Look(), 1), (plain, Look(), 3)):
        found = subject(both, reference=reference, look=noisy, reference_look=look)
        assert means(found) == pytest.approx((level, expected * level), rel=tolerance("float32"))


def test_parts_are_chosen_by_name_view_or_index(clip, tolerance):
    left, right = rgb(GREY) | {None: {"view": "left"}}, rgb(2 * GREY) | {None: {"view": "right"}}
    stereo = clip("stereo", left, right, {"Z": GREY})
    level = float(GREY.mean())
    for part, other in (("left", "right"), ("part0", "part1"), ("0", "1")):
        found = subject(stereo, reference=stereo, look=Look(part=part), reference_look=Look(part=other))
        assert means(found) == pytest.approx((level, 2 * level), rel=tolerance("float32"))
    assert means(subject(stereo, reference=stereo, look=Look(part="right")))[1] == pytest.approx(2 * level)
    with pytest.raises(FrameError, match="holds the views left, right; choose one with --part"):
        subject(stereo)
    with pytest.raises(FrameError, match=r"--reference-part middle: .* has the parts part0, part1, part2"):
        subject(stereo, reference=stereo, look=Look(part="left"), reference_look=Look(part="middle"))


def test_a_colour_that_is_passed_over_is_told(clip):
    parts = clip("parts", rgb(GREY), {"Z": GREY}, rgb(2 * GREY))
    found = subject(parts, reference=parts)
    for option in ("--part", "--reference-part"):
        assert any(f"its part part0 is measured; part2 have a colour too, which {option}" in n for n in found.notes)
    assert not any("have a colour too" in note for note in subject(parts, look=Look(part="part0")).notes)


def test_vectors_come_from_the_part_that_is_named(clip, tmp_path):
    still = np.zeros((HEIGHT, WIDTH), np.float32)
    clip("mv", {"X": still + 9, "Y": still}, {"X": still, "Y": still})
    request = {"motion": str(tmp_path / "mv.####.exr"), "motion_part": "part1"}
    found = subject(clip("plain", rgb(GREY)), **request)
    assert not found.motion.moved(1, 0).any()
    with pytest.raises(FrameError, match="--motion-part part1: is for files of motion vectors"):
        subject(clip("plain", rgb(GREY)), motion_part="part1")


def test_the_reference_takes_its_files_word_then_the_tests_option(clip):
    silent = clip("silent", rgb(GREY), suffix="tif", kind="uint16")
    tagged = clip("tagged", rgb(GREY), suffix="png", kind="uint16", **{"oiio:ColorSpace": "srgb_rec709_scene"})
    floats = clip("floats", rgb(GREY))
    for test, reference, look, own, expected in (
        (silent, silent, "srgb", None, ("srgb", "srgb")),
        (silent, silent, "srgb", "auto", ("srgb", "linear")),
        (silent, tagged, "linear", None, ("linear", "srgb")),
        (silent, floats, "srgb", None, ("srgb", "linear")),
        (floats, floats, "acescg", None, ("ACEScg", "ACEScg")),
        (tagged, tagged, None, "acescct", ("srgb", "ACEScct")),
    ):
        looks = {"look": Look(colour_space=look), "reference_look": Look(colour_space=own)}
        found = subject(test, reference=reference, **looks)
        assert (found.test.space, found.reference.space) == expected


@pytest.mark.parametrize("wrong", ["test", "reference"])
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_a_curve_between_test_and_reference_is_told(clip, tmp_path, wrong, noise):
    codes = encode(GREY).astype(np.float32)
    random = np.random.default_rng(1)
    pictures = {"test": GREY, "reference": GREY} | {wrong: codes}
    files = {name: clip(name, rgb(picture)) for name, picture in pictures.items()}
    for t in range(COUNT):
        noisy = pictures["test"] + noise * random.standard_normal(GREY.shape).astype(np.float32)
        write(tmp_path / f"test.{t:04d}.exr", rgb(noisy))
    said = []
    subject(**files, said=said, unverified=True)
    prefix = "reference-" if wrong == "reference" else ""
    assert any(f"the {wrong} was taken as linear" in text and f"--{prefix}colorspace srgb" in text for text in said)


@pytest.mark.parametrize("change", [lambda x: x, lambda x: 0.7 * x, lambda x: x + 0.1, lambda x: x[::-1]])
def test_no_curve_is_told_where_there_is_none(clip, change):
    said = []
    subject(clip("test", rgb(change(GREY))), reference=clip("reference", rgb(GREY)), said=said)
    assert not any("codes" in text for text in said)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e20])
def test_only_what_is_measured_must_be_usable(clip, tmp_path, value):
    broken = GREY.copy()
    broken[5, 9] = value
    half = (np.arange(HEIGHT)[:, None] >= HEIGHT // 2) * np.ones((1, WIDTH), np.float32)
    test, reference = clip("test", rgb(broken, A=half)), clip("reference", rgb(GREY))
    write(tmp_path / "mask.exr", {"Y": half})
    for request in (
        {"mask": str(tmp_path / "mask.exr")},
        {"look": Look(alpha="mask")},
        {"look": Look(alpha="unpremultiply")},
        {"look": Look(crop=Box(0, 24, 64, 24))},
    ):
        found = subject(test, reference=reference, skip_bad_frames=True, **request)
        assert found.kept == [0, 1, 2]
        assert np.isfinite(found.test.picture(1)).all()
    with pytest.raises(FrameError, match=r"test\.000\d\.exr: holds 3 .*the first at pixel x 9, y 5; .*--mask"):
        subject(test, reference=reference, look=Look(alpha="ignore"))


def test_the_largest_values_that_are_taken_give_finite_scores(swimlab, clip):
    bright = clip("bright", rgb(GREY * 1e12))
    code, out, err = swimlab("measure", "--test", bright, "--json")
    assert code == 0, err
    assert "Infinity" not in out


@pytest.mark.parametrize(("alpha", "whole"), [(1.0, True), (0.9995, True), (1 - 2**-11, True), (254 / 255, False)])
def test_alpha_is_whole_where_8_bit_could_not_tell_it_from_one(clip, alpha, whole):
    test = clip("test", rgb(GREY, A=np.full_like(GREY, alpha)))
    if whole:
        assert subject(test, look=Look(alpha="mask")).test.coverage(0).all()
    else:
        with pytest.raises(FrameError, match="no pixel is to be measured"):
            subject(test, look=Look(alpha="mask"))


def test_settings_name_what_is_said_of_each_input_and_no_more(swimlab, clip):
    """A default that is new adds nothing, so that scores of one version can be compared with those of the next."""

    def settings(*words):
        code, out, err = swimlab("measure", "--test", test, "--reference", test, "--json", *words)
        assert code == 0, err
        return json.loads(out)["provenance"]["settings"]

    test = clip("test", rgb(GREY))
    plain = settings()
    assert plain["look"] == {"channels": None, "colour_space": "auto", "alpha": "ignore", "crop": None}
    assert not {"reference_look", "motion_part"} & set(plain)
    said = settings("--part", "0", "--reference-part", "0")
    assert (said["look"]["part"], said["reference_look"]) == ("0", {"part": "0"})


def test_options_of_what_is_not_given_are_refused(swimlab, clip):
    test = clip("test", rgb(GREY))
    code, _, err = swimlab("measure", "--test", test, "--reference-channels", "Clean")
    assert (code, "--reference-channels Clean: is for a reference" in err) == (2, True)
    code, _, err = swimlab("measure", "--test", test, "--reference", test, "--reference-alpha", "mask")
    assert (code, "has no alpha" in err) == (2, True)
    code, _, err = swimlab("measure", "--test", test, "--colorspace", "ACESgc")
    assert (code, "--colorspace ACESgc: " in err and "ACEScg" in err) == (2, True)


def test_a_mask_has_a_channel_and_a_part_of_its_own(clip, tmp_path):
    test = clip("test", rgb(GREY))
    left = np.zeros((HEIGHT, WIDTH), np.float32)
    left[:, : WIDTH // 2] = 1
    mask = tmp_path / "mask.exr"
    write(mask, {"Y": np.ones_like(left)}, {"Y": 1 - left, "inside": left, None: {"oiio:subimagename": "mattes"}})
    for own, there in (
        ({}, np.ones_like(left)),
        ({"mask_channels": "inside"}, left),
        ({"mask_part": "mattes"}, 1 - left),
        ({"mask_part": "mattes", "mask_channels": "inside"}, left),
    ):
        assert np.array_equal(subject(test, mask=str(mask), **own).mask.coverage(0), there)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--mask", "mask.exr", "--mask-channels", "A"), "--mask-channels A: mask.exr has Y; name one of them"),
        (("--mask", "mask.exr", "--mask-part", "none"), "--mask-part none: mask.exr has the parts"),
        (("--mask-part", "0"), "--mask-part: is for an input that is not given; give --mask"),
        (("--motion", "1,0", "--motion-mask-channels", "A"), "give --motion-mask, or leave it out"),
        (("--depth-part", "0"), "give --depth, or leave it out"),
        (("--depth", "z.####.exr", "--depth-channels", "Z"), "It has Y; name one with --depth-channels"),
        (("--depth", "z.####.exr", "--depth-part", "none"), "--depth-part none: z.####.exr has the parts"),
    ],
)
def test_channels_and_parts_of_masks_that_are_not_there_are_refused(swimlab, clip, tmp_path, words, said):
    clip("z", {"Y": GREY})
    write(tmp_path / "mask.exr", {"Y": GREY})
    code, _, err = swimlab("measure", "--test", clip("test", rgb(GREY)), *words)
    assert (code, said in err) == (2, True), err


@pytest.mark.parametrize("motion", ["3", "nan,inf", "-2.5", "1,2,3", "1,-inf"])
def test_what_is_meant_as_a_vector_is_no_name_of_files(swimlab, tmp_path, motion):
    code, _, err = swimlab("measure", "--test", ".", f"--motion={motion}")
    assert code == 2
    assert f"--motion {motion}: give dx,dy in px a frame, as 0.5,-0.25" in err
