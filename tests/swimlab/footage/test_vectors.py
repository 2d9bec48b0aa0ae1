"""Vectors that are masked, not numbers, not written, or of another size than the frames."""

import json

import numpy as np
import pytest
from moving_wall import COUNT, HEIGHT, WIDTH, moved, picture, write

from swimlab.footage.convention import PRESETS, Convention
from swimlab.footage.fields import open_fields
from swimlab.footage.header import Header, Part
from swimlab.footage.motion import FieldMotion
from swimlab.footage.request import Request
from swimlab.footage.source import Box, Look
from swimlab.footage.subject import Subject
from swimlab.footage.vectors import resample

HALF = (WIDTH // 2, HEIGHT // 2)


class Made:
    """A reader of made vectors."""

    name = "mv"
    numbers = (0, 1, 2)

    def __init__(self, field):
        self._field = field
        height, width = field(0).shape[:2]
        self.header = type("H", (), {"size": (width, height)})()

    def label(self, index):
        return f"mv.{index:04d}.exr"

    def problems(self, part, channels):
        return {}

    def read(self, index, part, channels):
        return self._field(index)


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    return write(tmp_path_factory.mktemp("wall") / "test", picture)


def patch(t):
    """[H, W]: a block that wanders over the picture."""
    y, x = np.indices((HEIGHT, WIDTH))
    return (abs(x - 30 - 4 * t) < 7) & (abs(y - 20) < 9)


def holed(value):
    """Vectors t -> [H, W, 2] with a value instead of the vectors of the block."""
    return lambda t: np.where(patch(t)[..., None], value, moved(t))


def subject_of(frames, motion, **request):
    notes = []
    subject = Subject(Request(test=str(frames), motion=str(motion), **request), notes.append, notes.append)
    return subject, notes


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_vectors_that_are_no_numbers_are_not_measured(frames, tmp_path, value, tolerance):
    """They are left out, with a note; all others are what they were, next to the holes too."""
    subject, notes = subject_of(frames, write(tmp_path / "mv", holed(value), ("X", "Y")))
    clip = subject.clips()[0]
    for t in range(1, COUNT):
        assert np.array_equal(clip.coverage(t) == 0, patch(t))
        known = ~patch(t)
        assert np.abs(subject.motion.moved(t, t - 1) - moved(t))[known].max() < tolerance("motion")
    assert clip.coverage(0).all()
    assert any(note.startswith("motion verified") for note in notes)
    told = next(note for note in notes if note.startswith("motion is unknown"))
    assert f"in {patch(3).mean():.2%} of the pixels of motion frames 1-{COUNT - 1}" in told
    assert told in subject.notes


def test_a_mask_says_which_vectors_are_valid(swimlab, frames, tmp_path, tolerance):
    """Values under it may be anything; what is left is calm."""
    write(tmp_path / "mv", holed(25.0), ("X", "Y"))
    write(tmp_path / "valid", lambda t: 1.0 - patch(t)[..., None], ("Y",))
    words = ("measure", "--test", frames, "--motion", "mv", "--json")
    code, out, err = swimlab(*words, "--motion-mask", "valid")
    assert code == 0, err
    assert "vectors NaN, masked or not written" in err
    content = json.loads(out)
    assert content["provenance"]["settings"]["motion_mask"] is True
    scores = content["sequences"][0]["scores"]
    assert scores["residual.flicker"] < tolerance("unwarped glued") * np.var(picture(0))


def test_one_mask_may_stand_for_all_frames(frames, tmp_path):
    valid = np.ones((HEIGHT, WIDTH, 1))
    valid[:, :10] = 0.5
    mask = write(tmp_path / "valid", lambda t: valid, ("Y",)) / "0000.exr"
    motion = write(tmp_path / "mv", moved, ("X", "Y"))
    subject, _ = subject_of(frames, motion, motion_mask=str(mask))
    assert np.array_equal(subject.clips()[0].coverage(2), valid[..., 0] > 0.5)


def test_what_godot_did_not_write_is_unknown(frames, tmp_path):
    def stored(t):
        return np.where(patch(t)[..., None], -1, -moved(t) / [WIDTH, HEIGHT])

    motion = write(tmp_path / "mv", stored, ("R", "G"))
    subject, _ = subject_of(frames, motion, convention=PRESETS["godot"])
    assert np.array_equal(subject.clips()[0].coverage(4) == 0, patch(4))


def test_neighbours_of_unknown_vectors_take_nothing_from_them(tolerance):
    """Between pixels too, where vectors are interpolated: a known neighbour stands in for an unknown one."""
    stored = np.tile(np.float32([2, 1]), (8, 9, 1))
    stored[3, 4] = np.nan
    motion = FieldMotion(Made(lambda t: stored), 0, ("X", "Y"), Convention(), None)
    points = np.array([[3.0, 2.5, 3.4], [3.5, 4.2, 4.4]])
    assert np.abs(motion.back(points, 1, 0) - (points - [[1], [2]])).max() < tolerance("motion")
    assert np.argwhere(~motion.known(1, 0)).tolist() == [[3, 4]]


@pytest.mark.parametrize(
    ("direction", "holed_frame", "seen_at"), [("backward", 2, [3, 4]), ("backward", 1, [4, 6]), ("forward", 1, [4, 6])]
)
def test_a_hole_is_followed_over_frames_that_are_left_out(direction, holed_frame, seen_at):
    """What was unknown on the way is unknown, where the surface is now: everything moves by (2, 1) px a frame."""

    def stored(t):
        field = np.tile(np.float32([2, 1]), (8, 9, 1))
        if t == holed_frame:
            field[3, 4] = np.nan
        return field

    motion = FieldMotion(Made(stored), 0, ("X", "Y"), Convention(direction=direction), None)
    assert np.argwhere(~motion.known(2, 0)).tolist() == [seen_at]


def test_vectors_need_be_numbers_only_where_something_is_measured(swimlab, frames, tmp_path):
    """A sky without vectors outside the mask is no error, nor is a first frame without any."""
    inside = np.zeros((HEIGHT, WIDTH, 1))
    inside[:, 40:] = 1
    mask = write(tmp_path / "inside", lambda t: inside, ("Y",)) / "0000.exr"
    write(tmp_path / "mv", moved, ("X", "Y"))
    write(tmp_path / "sky", lambda t: np.where(inside * (t > 0) > 0, moved(t), np.nan), ("X", "Y"))
    words = ("measure", "--test", frames, "--mask", mask, "--json")
    found = [json.loads(swimlab(*words, "--motion", name)[1])["sequences"][0]["scores"] for name in ("mv", "sky")]
    assert found[0] == found[1]


def test_a_frame_without_any_vector_is_named(swimlab, frames, tmp_path):
    write(tmp_path / "mv", lambda t: moved(t) if t != 5 else np.full((HEIGHT, WIDTH, 2), np.nan), ("X", "Y"))
    code, _, err = swimlab("measure", "--test", frames, "--motion", "mv")
    assert code == 2
    assert "0005.exr: none of its motion vectors is known" in err


BAD_MASKS = {
    "another size": (lambda t: np.ones((9, 9, 1)), "is 9x9 px, the motion vectors 128x96 px"),
    "nothing valid": (lambda t: np.zeros((HEIGHT, WIDTH, 1)), "0001.exr: none of its motion vectors is known"),
}


@pytest.mark.parametrize("fault", BAD_MASKS)
def test_masks_that_cannot_be_used_are_refused(swimlab, frames, tmp_path, fault):
    mask, said = BAD_MASKS[fault]
    write(tmp_path / "mv", moved, ("X", "Y"))
    write(tmp_path / "valid", mask, ("Y",))
    code, _, err = swimlab("measure", "--test", frames, "--motion", "mv", "--motion-mask", "valid")
    assert code == 2
    assert said in err


def test_masks_of_a_motion_without_vectors_are_refused(swimlab, frames):
    for motion in (("--motion", "1,2"), ("--motion", "estimate"), ()):
        code, _, err = swimlab("measure", "--test", frames, "--motion-mask", frames, *motion)
        assert code == 2
        assert "--motion-mask" in err


SIZES = [HALF, (85, 64), (51, 38), (2 * WIDTH, 2 * HEIGHT)]


@pytest.mark.parametrize("unit", ["px", "uv"])
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_vectors_of_another_size_are_scaled_and_resampled(frames, tmp_path, size, unit, tolerance):
    """An upscaler's vectors: halves, two thirds, 2.5 times smaller to within rounding, and twice as large."""
    share = np.array([1, 1] if unit == "px" else size)
    motion = write(tmp_path / "mv", lambda t: moved(t, size) / share, ("X", "Y"))
    subject, notes = subject_of(frames, motion, convention=PRESETS["own" if unit == "px" else "uv"])
    error = np.abs(subject.motion.moved(3, 2) - moved(3))
    assert error[4:-4, 4:-4].max() < tolerance("resampled vectors")
    assert "motion vectors of {}x{} px are resampled for frames of 128x96 px".format(*size) in subject.notes
    assert any(note.startswith("motion verified") for note in notes)


def test_the_size_of_the_vectors_is_recorded(swimlab, frames, tmp_path, tolerance):
    write(tmp_path / "mv", lambda t: moved(t, HALF), ("X", "Y"))
    code, out, err = swimlab("measure", "--test", frames, "--motion", "mv", "--json")
    assert code == 0, err
    content = json.loads(out)
    assert content["provenance"]["settings"]["motion_size"] == list(HALF)
    scores = content["sequences"][0]["scores"]
    assert scores["residual.flicker"] < tolerance("unwarped glued") * np.var(picture(0))


def test_the_crop_is_in_px_of_the_frames(frames, tmp_path):
    motion = write(tmp_path / "mv", lambda t: moved(t, HALF), ("X", "Y"))
    whole, _ = subject_of(frames, motion)
    cut, _ = subject_of(frames, motion, look=Look(crop=Box(11, 7, 90, 70)))
    assert np.array_equal(cut.motion.moved(3, 2), whole.motion.moved(3, 2)[7:77, 11:101])


@pytest.mark.parametrize("factor", [2, 3, 0.5])
def test_vectors_of_two_surfaces_are_not_blended(factor):
    """A still wall beside a moving one: resampled vectors are of one of them, and unknown ones stay in place."""
    field = np.zeros((24, 32, 2), np.float32)
    field[:, 13:] = [5, -3]
    known = np.ones((24, 32), bool)
    known[6:9, 20:26] = False
    size = (int(32 * factor), int(24 * factor))
    found, seen = resample(field, known, size, edge=np.full(2, 0.25, np.float32))
    assert found.shape == (size[1], size[0], 2)
    assert {tuple(vector) for vector in found.reshape(-1, 2)} == {(0, 0), (5, -3)}
    if factor > 1:
        copies = np.ones((factor, factor))
        assert np.array_equal(found, np.kron(field, copies[..., None]))
        assert np.array_equal(seen, np.kron(known, copies))


@pytest.mark.parametrize("size", [(64, 64), (96, 128), (127, 96), (128, 97)], ids=str)
def test_vectors_of_another_view_are_refused(swimlab, frames, tmp_path, size):
    write(tmp_path / "mv", lambda t: np.ones((size[1], size[0], 2)), ("X", "Y"))
    code, _, err = swimlab("measure", "--test", frames, "--motion", "mv")
    assert code == 2
    assert "{}x{} px, the frames 128x96 px: more than rounding apart in shape".format(*size) in err


@pytest.mark.parametrize("size", [(1129, 635), (1280, 720), (853, 480), (854, 480), (1024, 576), (3840, 2160)], ids=str)
def test_sizes_of_upscalers_are_of_one_view(size):
    """1.7, 1.5, 2.25 rounded down and up, 1.875 times smaller, and twice as large as 1920x1080."""
    reader = Made(lambda t: np.zeros((size[1], size[0], 2), np.float32))
    reader.header = Header(size, (Part("", ("X", "Y"), ("float", "float")),), "zip")
    notes = []
    motion = open_fields(
        reader,
        PRESETS["own"],
        size=(1920, 1080),
        kept=[0, 1],
        crop=None,
        mask=None,
        part=None,
        places=[0, 1],
        note=notes.append,
        say=notes.append,
    )
    assert motion.moved(1, 0).shape == (1080, 1920, 2)
    assert any("resampled for frames of 1920x1080 px" in note for note in notes)


def test_a_mask_of_vectors_has_a_channel_of_its_own(frames, tmp_path):
    valid = np.ones((HEIGHT, WIDTH, 2))
    valid[:, :10, 1] = 0
    mask = write(tmp_path / "valid", lambda t: valid, ("Y", "ok")) / "0000.exr"
    motion = write(tmp_path / "mv", moved, ("X", "Y"))
    subject, _ = subject_of(frames, motion, motion_mask=str(mask), motion_mask_channels="ok")
    assert np.array_equal(subject.clips()[0].coverage(2), valid[..., 1])
