"""Motion vectors: conventions, directions, and what warping says of them."""

import numpy as np
import pytest
from scipy import ndimage

from sequences import load
from swimlab.footage.convention import PRESETS, Convention, guess
from swimlab.footage.motion import EstimatedMotion, FieldMotion, UniformMotion
from swimlab.footage.source import Box
from swimlab.footage.verify import verify
from swimlab.footage.warping import GIVEN, IDENTITY
from swimlab.runs.frames import FrameError

HEIGHT, WIDTH, COUNT = 72, 96, 6
VELOCITY = (0.8, -0.5)
TURN = np.radians(1.5)


class Fields:
    """A reader of made vectors."""

    name = "mv"

    def __init__(self, field, size=(WIDTH, HEIGHT)):
        self.numbers = tuple(range(COUNT))
        self._field = field
        self.header = type("H", (), {"size": size})()

    def label(self, index):
        return f"mv.{index:04d}.exr"

    def read(self, index, part, channels):
        return self._field(index).astype(np.float32)


def surface(t):
    """x and y on the surface that each pixel of frame t sees: a turn about the middle."""
    y, x = np.indices((HEIGHT, WIDTH)) - np.array([HEIGHT / 2, WIDTH / 2])[:, None, None]
    c, s = np.cos(TURN * t), np.sin(TURN * t)
    return c * x + s * y, c * y - s * x


def turned(t):
    """[H, W, 2]: a smooth picture on the turning surface."""
    x, y = surface(t)
    grey = np.cos(0.6 * x + 0.2 * y) + np.cos(0.5 * y - 0.3 * x + 1) + np.cos(0.33 * x + 0.4 * y + 2)
    return np.repeat(3 + grey[..., None], 3, axis=2)


def since_previous(t):
    """How far the turning surface moved since the frame before, px right and down."""
    now, before = surface(0), surface(1)
    return np.stack([now[0] - before[0], now[1] - before[1]], axis=-1)


def until_next(t):
    after, now = surface(-1), surface(0)
    return np.stack([after[0] - now[0], after[1] - now[1]], axis=-1)


def fields(field, convention, crop=None):
    return FieldMotion(Fields(field), 0, ("X", "Y"), convention, crop)


STORED = {
    "own": lambda v: v,
    "blender": lambda v: v * [-1, 1],
    "unity": lambda v: v * [1, -1] / [WIDTH, HEIGHT],
    "nuke": lambda v: v * [-1, 1],
    "ndc": lambda v: v * [1, -1] / [WIDTH / 2, HEIGHT / 2],
    "uv": lambda v: v / [WIDTH, HEIGHT],
}


@pytest.mark.parametrize("preset", STORED)
def test_presets(preset, tolerance):
    """Right and down is +x and +y whatever the vectors' convention."""
    motion = fields(lambda t: STORED[preset](since_previous(t)), PRESETS[preset])
    assert np.abs(motion.moved(2, 1) - since_previous(2)).max() < tolerance("motion")


def test_forward_vectors_are_turned_round(tolerance):
    """They are known where the surface was, not where it is now."""
    motion = fields(lambda t: until_next(t) * [1, -1], PRESETS["nuke-forward"])
    inner = (slice(8, -8), slice(8, -8))
    assert np.abs(motion.moved(3, 2) - since_previous(3))[inner].max() < tolerance("correspondence")


@pytest.mark.parametrize("direction", ["backward", "forward"])
def test_motion_over_several_frames_is_composed(direction, tolerance):
    field = since_previous if direction == "backward" else until_next
    motion = fields(field, Convention(direction=direction))
    now, before = surface(0), surface(3)
    exact = np.stack([now[0] - before[0], now[1] - before[1]], axis=-1)
    inner = (slice(14, -14), slice(14, -14))
    assert np.abs(motion.moved(4, 1) - exact)[inner].max() < tolerance("correspondence")
    assert np.allclose(UniformMotion((2.0, -1.0), (3, 4)).moved(5, 2), [6, -3])


def test_fields_are_cropped_in_px_of_the_whole_picture(tolerance):
    motion = fields(lambda t: STORED["uv"](since_previous(t)), PRESETS["uv"], Box(10, 20, 30, 40))
    assert np.abs(motion.moved(1, 0) - since_previous(1)[20:60, 10:40]).max() < tolerance("motion")


def test_a_frame_of_which_no_vector_is_known_is_named():
    nothing = np.full((HEIGHT, WIDTH, 2), np.nan)
    motion = fields(lambda t: nothing if t == 2 else since_previous(t), Convention())
    with pytest.raises(FrameError, match=r"mv\.0002\.exr: none of its motion vectors is known: all are NaN, masked or"):
        motion.vectors.survey(range(COUNT))


def test_guesses_by_channel_names():
    assert guess(("coverage", "motion.X", "motion.Y")) == "own"
    assert guess(("View.Vector.W", "View.Vector.X", "View.Vector.Y", "View.Vector.Z")) == "blender"
    assert guess(("forward.u", "forward.v")) == "nuke-forward"
    assert guess(("R", "G", "B")) is None


def shifted(t):
    y, x = np.indices((HEIGHT, WIDTH)).astype(float)
    x, y = x - t * VELOCITY[0], y - t * VELOCITY[1]
    grey = np.cos(0.6 * x + 0.2 * y) + np.cos(0.5 * y - 0.3 * x + 1) + np.cos(0.33 * x + 0.4 * y + 2)
    return np.repeat(3 + grey[..., None], 3, axis=2)


def check(motion, picture, coverage=None):
    checked = verify(motion, picture, coverage, list(range(COUNT)))
    checked.check()
    return checked


def test_the_right_motion_leaves_only_interpolation_error(tolerance):
    for motion, picture in (
        (UniformMotion(VELOCITY, (HEIGHT, WIDTH)), shifted),
        (fields(since_previous, Convention()), turned),
        (fields(until_next, Convention(direction="forward")), turned),
    ):
        residuals = check(motion, picture).residuals
        assert residuals[GIVEN] < tolerance("warped picture")
        assert residuals[IDENTITY] > 10 * residuals[GIVEN]


WRONG = {
    "x flipped": (-0.8, -0.5, "--motion 0.8,-0.5"),
    "y flipped": (0.8, 0.5, "--motion 0.8,-0.5"),
    "both flipped": (-0.8, 0.5, "--motion 0.8,-0.5"),
}


@pytest.mark.parametrize("what", WRONG)
def test_another_sign_is_refused_by_the_setting_that_mends_it(what):
    x, y, setting = WRONG[what]
    with pytest.raises(FrameError, match=f"{what} leaves .* Use {setting}, or measure all the same"):
        check(UniformMotion((x, y), (HEIGHT, WIDTH)), shifted)


@pytest.mark.parametrize("masked", [False, True])
def test_a_still_sky_over_most_of_the_picture_hides_no_wrong_sign(masked):
    sky = 2 * HEIGHT // 3

    def picture(t):
        seen = shifted(t)
        seen[:sky] = 0.0
        return seen

    def stored(t):
        moved = np.zeros((HEIGHT, WIDTH, 2))
        moved[sky:] = VELOCITY
        return moved

    def coverage(t):
        return (np.indices((HEIGHT, WIDTH))[0] >= sky).astype(float)

    mask = coverage if masked else None
    check(fields(stored, Convention()), picture, mask)
    with pytest.raises(FrameError, match="both flipped leaves"):
        check(fields(lambda t: -stored(t), Convention()), picture, mask)


WRONG_FIELDS = {
    "both flipped": (Convention(scale=(-1, -1)), "--motion-scale 1,1"),
    "x flipped": (Convention(scale=(-1, 1)), "--motion-scale 1,1"),
    "y flipped": (Convention(y="up"), "--motion-y down"),
}


@pytest.mark.parametrize("what", WRONG_FIELDS)
def test_other_signs_of_fields_are_refused(what):
    convention, setting = WRONG_FIELDS[what]
    drifting = fields(lambda t: np.broadcast_to(VELOCITY, (HEIGHT, WIDTH, 2)), convention)
    with pytest.raises(FrameError, match=f"{what} leaves .* Use {setting}, or"):
        check(drifting, shifted)


def test_another_direction_is_refused():
    """A surface that speeds up tells directions apart: each step belongs to one pair of frames."""
    steps = np.array([0, 0.5, 3.5, 0.5, 3.5, 0.5])

    def picture(t):
        y, x = np.indices((HEIGHT, WIDTH)).astype(float)
        x = x - steps[: t + 1].sum()
        return np.repeat(3 + np.cos(0.6 * x + 0.2 * y)[..., None] + np.cos(0.23 * x + 0.7 * y)[..., None], 3, axis=2)

    def stored(t):
        return np.broadcast_to((steps[(t + 1) % COUNT], 0.0), (HEIGHT, WIDTH, 2))

    with pytest.raises(FrameError, match="forward leaves"):
        check(fields(stored, Convention()), picture)
    check(fields(stored, Convention(direction="forward")), picture)


def test_a_picture_that_stands_still_refuses_motion():
    with pytest.raises(FrameError, match=r"no motion at all leaves 0\.000 .* --motion-unverified"):
        check(UniformMotion(VELOCITY, (HEIGHT, WIDTH)), lambda t: shifted(0))


@pytest.mark.parametrize("velocity", [VELOCITY, (0.61, 0.43), (-1.3, 0.85)])
def test_no_reading_is_the_given_one(velocity):
    others = UniformMotion(velocity, (HEIGHT, WIDTH)).variants()
    assert "" not in others
    assert velocity not in [other.velocity for _, other in others.values()]


def test_what_cannot_be_verified_says_so():
    flat = verify(UniformMotion(VELOCITY, (HEIGHT, WIDTH)), lambda t: np.ones((HEIGHT, WIDTH, 3)), None, [0, 1, 2])
    assert "flat" in flat.doubt
    still = check(UniformMotion((0.0, 0.0), (HEIGHT, WIDTH)), lambda t: shifted(0))
    assert "travels by 0 px" in still.note


def test_no_motion_is_refused_where_a_reference_moves():
    still = UniformMotion((0.0, 0.0), (HEIGHT, WIDTH))
    with pytest.raises(FrameError, match=r"optical flow finds a motion that leaves 0\.0"):
        verify(still, shifted, None, list(range(COUNT)), clean=True).check()
    assert "the pattern swims, or the motion is wrong" in check(still, shifted).doubt


UNITS = {
    "unity": ("own", "in uv, y flipped", "--motion-convention unity"),
    "ndc": ("unity", "in ndc", r"--motion-convention ndc \(or threejs: they mean the same here\)"),
    "uv": ("ndc", "in uv, y flipped", "--motion-convention uv"),
    "own": ("unity", "in px, y flipped", "--motion-convention own"),
}


@pytest.mark.parametrize("truth", UNITS)
def test_another_unit_is_refused_by_the_setting_that_mends_it(truth):
    """Also where the given reading hardly moves at all, or out of the picture at once."""
    given, what, setting = UNITS[truth]
    motion = fields(lambda t: STORED[truth](np.broadcast_to(VELOCITY, (HEIGHT, WIDTH, 2))), PRESETS[given])
    motion.channels = ("R", "G")
    with pytest.raises(FrameError, match=rf"{what} leaves 0\.0.* Use {setting}, or"):
        check(motion, shifted)


@pytest.mark.parametrize("given", ["own", "unity"])
def test_channels_of_an_engine_are_mended_by_its_preset(given):
    """Also where it differs from what was given by signs alone."""
    motion = fields(lambda t: STORED["blender"](np.broadcast_to(VELOCITY, (HEIGHT, WIDTH, 2))), PRESETS[given])
    motion.channels = ("View Layer.Vector.X", "View Layer.Vector.Y")
    with pytest.raises(FrameError, match="Use --motion-convention blender, or"):
        check(motion, shifted)


def test_single_options_mend_what_single_options_made():
    """A preset would not count beside the options given."""
    stored = fields(lambda t: STORED["unity"](since_previous(t)), Convention(unit="ndc", scale=(-1, 1)))
    with pytest.raises(FrameError, match="Use --motion-unit uv --motion-scale 1,-1, or"):
        check(stored, turned)


FACTORS = {
    "of half the length": (2, 2),
    "of twice the length": (0.5, 0.5),
    "in uv": (1 / WIDTH, 1 / HEIGHT),
    "in ndc, both flipped": (-2 / WIDTH, -2 / HEIGHT),
}


@pytest.mark.parametrize("what", FACTORS)
def test_another_length_of_one_vector_is_refused(what):
    x, y = np.multiply(VELOCITY, FACTORS[what])
    with pytest.raises(FrameError, match=rf"{what} leaves 0\.0.* Use --motion 0\.8,-0\.5, or"):
        check(UniformMotion((float(x), float(y)), (HEIGHT, WIDTH)), shifted)


def test_motion_beyond_belief_is_refused_even_of_flat_pictures():
    motion = UniformMotion((437.0, 0.0), (HEIGHT, WIDTH))
    with pytest.raises(FrameError, match=r"moves 437 px a frame in a picture of 96x72 px: is its unit right\? check"):
        check(motion, lambda t: np.ones((HEIGHT, WIDTH, 3)))


def test_other_motion_of_a_reference_is_refused_where_there_is_one():
    """Of other frames it is doubted: a pattern that swims over its surface is what there is to measure."""
    random = np.random.default_rng(1)
    kx, ky = random.uniform(-1.2, 1.2, (2, 32))
    phase = random.uniform(0, 6, 32)

    def picture(t):
        y, x = np.indices((HEIGHT, WIDTH))[..., None] - np.array([-1.5 * t, 2.4 * t])[:, None, None, None]
        return np.repeat(9 + np.cos(kx * x + ky * y + phase).sum(axis=2)[..., None], 3, axis=2)

    motion = UniformMotion((-3.3, 4.9), (HEIGHT, WIDTH))
    with pytest.raises(FrameError, match=r"optical flow finds a motion that leaves 0.* Check its channels, unit and"):
        verify(motion, picture, None, list(range(COUNT)), clean=True).check()
    assert "the pattern swims" in check(motion, picture).doubt


@pytest.mark.parametrize("blur", [0, 1, 3, 8])
@pytest.mark.parametrize("velocity", [VELOCITY, (4.0, 3.0), (2.0, 0.0)])
def test_noise_refuses_no_motion(blur, velocity):
    """Of any smoothness: nothing explains it, so nothing is verified, and nothing refused."""

    def noise(t):
        grey = ndimage.gaussian_filter(np.random.default_rng(t).standard_normal((HEIGHT, WIDTH)), blur, mode="wrap")
        return np.repeat(3 + grey[..., None] / grey.std(), 3, axis=2)

    motion = UniformMotion(velocity, (HEIGHT, WIDTH))
    verify(motion, noise, None, list(range(COUNT)), clean=True).check()
    checked = check(motion, noise)
    assert "the frames flicker much, or it is wrong" in checked.doubt
    assert not checked.note


@pytest.mark.parametrize(("amount", "said"), [(0.1, "verified"), (0.5, "verified"), (2.0, "flicker much")])
def test_frames_that_flicker_are_verified_as_far_as_they_can_be(amount, said):
    def noisy(t):
        return shifted(t) + amount * np.random.default_rng(t).standard_normal((HEIGHT, WIDTH, 1))

    checked = check(UniformMotion(VELOCITY, (HEIGHT, WIDTH)), noisy)
    assert said in checked.note + checked.doubt


def test_only_covered_pixels_are_compared(tolerance):
    """A hood fixed to the screen over the lower half does not speak for identity."""

    def picture(t):
        seen = shifted(t)
        seen[HEIGHT // 3 :] = 9 * shifted(0)[HEIGHT // 3 :]
        return seen

    def coverage(t):
        return (np.indices((HEIGHT, WIDTH))[0] < HEIGHT // 3).astype(float)

    motion = UniformMotion(VELOCITY, (HEIGHT, WIDTH))
    assert check(motion, picture, coverage).residuals[GIVEN] < tolerance("warped picture")
    with pytest.raises(FrameError, match="no motion at all"):
        check(motion, picture)


def test_estimated_motion_is_near_the_truth_but_not_at_it(shoot, render, tolerance):
    """On a rendered road: DIS flow errs by hundredths of a pixel where the reference is known exactly."""
    sequence = load("road-shift").with_changes(size=(160, 90))
    pictures = [render(shoot(sequence, frame, samples=16), "reference").rgba for frame in range(2)]
    covered = pictures[1][..., 3] == 1
    moved = EstimatedMotion(lambda index: pictures[index][..., :3]).moved(1, 0)
    velocity = sequence.motion.velocity
    inner = covered & (np.indices(covered.shape).min(axis=0) >= 4)
    error = np.hypot(*np.moveaxis(moved - np.asarray(velocity, np.float32), 2, 0))[inner]
    assert np.median(error) < tolerance("estimated motion")
    assert np.median(error) > 0


def test_what_comes_into_view_speaks_for_no_reading(tolerance):
    """A patch moves over the picture by itself; behind it is what no earlier frame has shown."""
    speed = 3

    def inside(t):
        y, x = np.indices((HEIGHT, WIDTH))
        return (np.abs(x - 30 - speed * t) < 14) & (np.abs(y - 36) < 16)

    def picture(t):
        patch = 3 * np.roll(shifted(0), speed * t, axis=1)
        return np.where(inside(t)[..., None], patch, shifted(t))

    def field(t):
        return np.where(inside(t)[..., None], (speed, 0.0), VELOCITY)

    assert check(fields(field, Convention()), picture).residuals[GIVEN] < tolerance("warped picture")
