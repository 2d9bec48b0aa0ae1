"""Motion checked over every pair of frames and long baselines: what is wrong is found, named, and nothing else."""

import json
import re

import numpy as np
import pytest
from waves import COUNT, HEIGHT, WIDTH, Vectors, fields, moved, surface, uniform

from swimlab.footage.check.jitter import estimate_jitter
from swimlab.footage.check.still import verify_still
from swimlab.footage.motion import UniformMotion
from swimlab.footage.verify import verify
from swimlab.runs.frames import FrameError, write_channels


def check(motion, frames, **words):
    return verify(motion, lambda t: frames[t], None, list(range(len(frames))), **words)


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.05])
@pytest.mark.parametrize("velocity", [(2.0, 0.0), (1.3, -0.4), (0.0, 3.0), (0.1, 0.05)])
def test_right_motion_is_verified_with_its_factor(velocity, noise, tolerance):
    found = check(uniform(velocity), moved(velocity, noise=noise))
    assert (found.verdict, found.error, found.doubt) == ("verified", "", "")
    for axis, factor in enumerate(found.scale):
        if velocity[axis] > 0.2:
            assert factor == pytest.approx(1, abs=tolerance("factor of a motion"))


FACTORS = {
    "20 % short": ((2.0, 0.0), (0.8, 1)),
    "10 % short": ((2.0, 0.0), (0.9, 1)),
    "vertical axis only": ((1.2, 1.5), (1, 0.85)),
    "1 % too long": ((2.0, 1.0), (1.01, 1.01)),
    "2 % too short": ((1.6, -1.2), (0.98, 0.98)),
    "of an upscaler's input": ((2.0, 0.0), (1 / 1.7, 1 / 1.7)),
}


@pytest.mark.parametrize("what", FACTORS)
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_the_factor_that_fits_is_fitted_and_named(what, noise, tolerance):
    velocity, factor = FACTORS[what]
    found = check(uniform(tuple(np.multiply(velocity, factor))), moved(velocity, noise=noise))
    assert found.verdict in (("wrong",) if noise == 0 or abs(factor[0] - 1) > 0.011 else ("wrong", "partly"))
    for axis in (0, 1):
        if velocity[axis]:
            assert found.scale[axis] * factor[axis] == pytest.approx(1, abs=tolerance("factor of a motion"))
    named = re.findall(r"--motion ([-\d.]+),([-\d.]+)", found.error + found.doubt)[0]
    named = [float(part.rstrip(".")) for part in named]
    assert named == pytest.approx(velocity, abs=tolerance("factor of a motion") * 2)


REGIONS = {
    "sky": ((slice(0, 42), slice(None)), (0.0, 0.0)),
    "right third": ((slice(None), slice(85, None)), (0.0, 0.0)),
    "bottom, of another motion": ((slice(60, None), slice(None)), (2.4, 0.0)),
}


@pytest.mark.parametrize("what", REGIONS)
@pytest.mark.parametrize("velocity", [(1.6, 0.0), (5.0, 1.0)])
def test_a_region_that_does_not_fit_is_named(what, velocity):
    where, other = REGIONS[what]
    wrong = fields(velocity)
    for field in wrong:
        field[where] = other if velocity[0] < 2 else np.multiply(other, 0)
    found = check(Vectors(wrong), moved(velocity, noise=0.02))
    assert found.verdict == ("partly" if "another" in what and velocity[0] < 2 else "wrong")
    left, top, right, bottom = found.region.box
    inside = np.zeros((HEIGHT, WIDTH), bool)
    inside[where] = True
    box = np.zeros_like(inside)
    box[top:bottom, left:right] = True
    assert (box & inside).sum() > 0.7 * (box | inside).sum()
    assert f"x {left}-{right - 1}, y {top}-{bottom - 1}" in found.error + found.doubt
    assert "or leave the place out with --mask" in found.error + found.doubt


@pytest.mark.parametrize("bad", [[6], [5, 11], [3, 4]])
@pytest.mark.parametrize("velocity", [(1.6, 0.0), (6.0, 2.0)])
def test_frames_whose_vectors_are_wrong_are_named_by_their_numbers(bad, velocity):
    wrong = fields(velocity)
    for index in bad:
        wrong[index][:] = 0
    found = check(Vectors(wrong), moved(velocity, noise=0.02), numbers=range(1001, 1001 + COUNT))
    assert (found.verdict, list(found.frames)) == ("wrong", bad)
    assert f"does not fit frames {1001 + bad[0]}" in found.error


def halton(index, base):
    share, found = 1.0, 0.0
    while index:
        share /= base
        found += share * (index % base)
        index //= base
    return found


def offsets(period):
    return np.array([[halton(t % period + 1, base) - 0.5 for base in (2, 3)] for t in range(COUNT)])


@pytest.mark.parametrize("period", [8, 16])
@pytest.mark.parametrize("velocity", [(1.3, 0.4), (0.0, 0.0)])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_jitter_in_the_vectors_is_found_and_can_be_taken_out(period, velocity, noise, tolerance):
    jitter = offsets(period)
    vectors = fields(velocity)
    for t in range(1, COUNT):
        vectors[t] += jitter[t] - jitter[t - 1]
    frames = moved(velocity, noise=noise)
    found = check(Vectors(vectors), frames)
    assert found.verdict == "wrong"
    assert "--motion-jitter" in found.error
    exact = jitter - jitter.mean(axis=0)
    assert found.jitter == pytest.approx(np.sqrt((exact**2).sum(axis=1).mean()), abs=tolerance("jitter"))
    estimated = estimate_jitter(Vectors(vectors), lambda t: frames[t], None, list(range(COUNT)), COUNT)
    assert np.abs(estimated - exact).max() < tolerance("jitter")


@pytest.mark.parametrize(("shown", "named"), [((0, 0, 1, 1), "every 2nd frame"), ((0, 1, 1), "every 3rd frame")])
def test_repeated_frames_are_found_with_their_pattern(shown, named):
    """Motion that is right on average is measured, with a warning."""
    steps = [t // len(shown) * (max(shown) + 1) + shown[t % len(shown)] for t in range(18)]
    velocity = 1.5 * steps[-1] / 17
    if named == "every 2nd frame":
        velocity = 0.75
    content = moved((1.5, 0.0), count=max(steps) + 1)
    frames = [content[step] for step in steps]
    found = check(uniform((velocity, 0.0)), frames)
    repeated = [t for t in range(1, 18) if steps[t] == steps[t - 1]]
    assert list(found.repeated) == repeated
    assert f"{named} repeats the one before" in found.doubt + found.error
    assert found.verdict != "verified"
    if named == "every 2nd frame":
        assert found.verdict == "partly"


PULLDOWN = [0, 0, 0, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5, 5]
THRICE = [t // 3 for t in range(15)]


@pytest.mark.parametrize(("order", "average"), [(PULLDOWN, 1.0), (THRICE, 2.5 / 3)])
def test_film_at_the_rate_of_video_is_measured_by_its_mean_motion(order, average):
    """24 and 20 frames a second shown at 60: each new frame moves by 2.5 px, whatever was shown before it."""
    content = moved((2.5, 0.0), max(order) + 1)
    frames = [content[k] for k in order]
    found = check(uniform((average, 0.0)), frames)
    assert (found.verdict, found.error, found.jitter) == ("partly", "", 0.0)
    assert "repeats the one before" in found.doubt
    if order is PULLDOWN:
        assert "moves by 2.5,0 px with each new frame, however long the one before was shown" in found.doubt
    refused = check(uniform((2.5, 0.0)), frames)
    assert refused.verdict == "wrong"
    assert f"Use --motion {average:.4g},0" in refused.error


def test_frames_that_are_repeated_without_order_are_listed():
    order = [0, 1, 2, 3, 3, 4, 5, 6, 7, 8, 9, 9, 9, 10, 11, 12]
    content = moved((1.5, 0.0))
    frames = [content[t] for t in order]
    stored = [np.full((HEIGHT, WIDTH, 2), (1.5, 0.0)) for _ in order]
    found = check(Vectors(stored), frames)
    assert list(found.repeated) == [4, 11, 12]


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("velocity", [(1.5, 0.5), (4.0, 0.0)])
def test_a_cut_ends_a_shot_and_motion_on_both_sides_is_verified(noise, velocity):
    frames = moved(velocity, 9, noise) + [surface(*np.multiply(velocity, t), seed=7) for t in range(9)]
    found = check(Vectors(fields(velocity, 18)), frames, numbers=range(10, 28))
    assert (found.verdict, found.cuts) == ("verified", (9,))
    assert "a new shot begins with frame 19" in found.note
    still = verify_still(lambda t: frames[t], None, list(range(18)), given=False)
    assert still.cuts == (9,)


def test_a_strange_frame_is_flicker_and_no_cut():
    frames = moved((1.5, 0.5))
    frames[7] = surface(seed=9)
    assert check(uniform((1.5, 0.5)), frames).cuts == ()


@pytest.mark.parametrize("clean", [False, True])
def test_content_that_moves_without_motion_is_told(clean):
    frames = moved((2.0, 0.0))
    found = verify_still(lambda t: frames[t], None, list(range(COUNT)), clean=clean)
    assert "content moves by about 2,0 px a frame: give --motion 2,0 or estimate" in found.error + found.doubt
    assert found.verdict == ("wrong" if clean else "partly")
    if clean:
        with pytest.raises(FrameError, match="is not given"):
            found.check()


@pytest.mark.parametrize("clean", [False, True])
@pytest.mark.parametrize("how", ["calm", "noise", "blinks", "fades"])
def test_still_pictures_that_flicker_pass(how, clean):
    amount = {"calm": lambda t: 0.0, "noise": lambda t: 0.0, "blinks": lambda t: t % 2, "fades": lambda t: t / COUNT}
    noise = 0.05 * (how == "noise")
    frames = [
        surface() * (1 + 0.3 * amount[how](t)) + noise * np.random.default_rng(t).standard_normal((HEIGHT, WIDTH, 1))
        for t in range(COUNT)
    ]
    found = verify_still(lambda t: frames[t], None, list(range(COUNT)), clean=clean)
    assert (found.error, found.doubt) == ("", "")


def test_jitter_that_is_estimated_is_what_the_vectors_have_too_much(tolerance):
    """Vectors of frame t hold jitter[t] - jitter[t - 1]; frames that are left out keep the one before."""
    frames = moved((1.3, 0.4))
    jitter = offsets(8)
    vectors = fields((1.3, 0.4))
    for t in range(1, COUNT):
        vectors[t] += jitter[t] - jitter[t - 1]
    kept = [t for t in range(COUNT) if t != 5]
    found = estimate_jitter(Vectors(vectors), lambda t: frames[t], None, kept, COUNT)
    assert found.shape == (COUNT, 2)
    assert np.abs(found.mean(axis=0)).max() < tolerance("rounding")
    assert np.array_equal(found[5], found[4])
    assert np.abs((found[6] - found[4]) - (jitter[6] - jitter[4])).max() < tolerance("jitter")


def test_what_is_wrong_stands_in_scores_with_a_picture(swimlab, tmp_path):
    """The sky has no vectors while the picture moves: refused, and measured all the same if that is asked for."""
    frames = moved((1.6, 0.0))
    stored = fields((1.6, 0.0))
    for t in range(COUNT):
        stored[t][:48] = 0
        write_channels(tmp_path / f"f.{t:04d}.exr", frames[t].astype("f4"), tuple("RGB"), half=False, metadata={})
        write_channels(tmp_path / f"v.{t:04d}.exr", stored[t].astype("f4"), tuple("XY"), half=False, metadata={})
    words = ("measure", "--test", "f.####.exr", "--motion", "v.####.exr", "-o", "out", "--json")
    code, _, err = swimlab(*words)
    assert code == 2
    assert "does not fit at x 0-127, y 0-47 (" in err
    assert "while the picture moves by 1.6,0 px a frame" in err
    assert (tmp_path / "out" / "motion_check.png").exists()
    code, out, err = swimlab(*words, "--motion-unverified", "-q")
    assert code == 0
    assert "does not fit at x 0-127, y 0-47 (" in err
    entry = json.loads(out)["sequences"][0]["motion_check"]
    assert entry["verdict"] == "wrong"
    assert entry["scale"] == [pytest.approx(1, abs=0.01), None]
    assert 0.4 < entry["unfit_fraction"] < 0.6
    assert [row.count("1") for row in entry["unfit"]] == 4 * [12] + 4 * [0]
    assert (entry["frames"], entry["jitter"], entry["cuts"], entry["repeated"]) == ([], 0.0, [], [])


def test_content_that_moves_without_motion_is_said_even_quietly(swimlab, tmp_path):
    for t, frame in enumerate(moved((2.0, 0.0))):
        write_channels(tmp_path / f"f.{t:04d}.exr", frame.astype("f4"), tuple("RGB"), half=False, metadata={})
    code, out, err = swimlab("measure", "--test", "f.####.exr", "-q", "--json")
    assert code == 0
    assert "content moves by about 2,0 px a frame: give --motion 2,0 or estimate" in err
    assert json.loads(out)["sequences"][0]["motion_check"]["verdict"] == "partly"
    code, _, err = swimlab("measure", "--test", "f.####.exr", "--reference", "f.####.exr", "-q")
    assert code == 2
    assert "--motion: is not given, but content moves" in err


def test_of_readings_that_are_better_the_best_is_named():
    """The first that is clearly better left .04 here, the best one nothing."""

    class Told(UniformMotion):
        def variants(self):
            return {"near": ("--near", uniform((1.5, 0.35))), "best": ("--best", uniform((1.5, 0.5)))}

    with pytest.raises(FrameError, match=r"best leaves 0\.0.* Use --best, or"):
        check(Told((-1.5, 0.5), (HEIGHT, WIDTH)), moved((1.5, 0.5), noise=0.01)).check()


@pytest.mark.parametrize("clean", [False, True])
@pytest.mark.parametrize("hard", ["occlusion", "wires", "highlights", "noise"])
def test_what_renderers_draw_refuses_no_right_motion(hard, clean):
    """Patches that hide others, wires of whole pixels, highlights and glints that move against the surface, noise."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    frames, vectors = [], []
    for t in range(COUNT):
        picture, field = surface(1.0 * t, 0.2 * t), np.full((HEIGHT, WIDTH, 2), (1.0, 0.2))
        for middle, velocity, seed in (((30, 30), (3.0, 1.0), 2), ((100, 70), (-2.0, 0.0), 3)):
            across, down = np.add(middle, np.multiply(velocity, t))
            patch = (np.abs(x - across) < 16) & (np.abs(y - down) < 14)
            picture[patch], field[patch] = 1.5 * surface(*np.multiply(velocity, t), seed=seed)[patch], velocity
        random = np.random.default_rng(t)
        if hard == "wires":
            for k in range(6):
                wire = np.floor((x - 20 * k - 2.3 * t) % WIDTH) == 0
                picture[wire], field[wire] = 2.0, (2.3, 0.0)
        if hard == "highlights":
            far = (x - 64 - 0.1 * t) ** 2 + (y - 60 + 0.7 * t) ** 2
            picture += np.exp(-far / 162)[..., None] + 30 * (random.random((HEIGHT, WIDTH, 1)) > 0.995)
        noise = {"noise": 0.1}.get(hard, 0.01)
        frames.append(picture + noise * random.standard_normal((HEIGHT, WIDTH, 1)))
        vectors.append(field)
    found = check(Vectors(vectors), frames, clean=clean)
    assert found.error == ""
    assert (found.cuts, found.repeated, found.frames, found.jitter) == ((), (), (), 0.0)
    assert hard == "wires" or found.verdict == "verified"


def test_shots_of_one_frame_are_doubted():
    found = check(uniform((1.0, 0.0)), [surface(seed=1), surface(seed=2)])
    assert found.verdict == "unchecked"
    assert found.doubt


@pytest.mark.parametrize(("change", "said"), [(0.0, True), (0.2, False)])
def test_a_direction_that_steady_motion_does_not_tell_is_said(change, said):
    """Vectors of frame t hold the step from t - 1; read as forward, those of the next frame do."""
    steps = [1.5 + change * t for t in range(COUNT)]

    class Told(Vectors):
        def variants(self):
            later = [*fields_of(steps[1:]), self._fields[-1]]
            return {"forward": ("--motion-direction forward", Vectors(later))}

    def fields_of(speeds):
        return [np.full((HEIGHT, WIDTH, 2), (speed, 0.0)) for speed in speeds]

    found = check(Told(fields_of(steps)), [surface(place) for place in np.cumsum(steps)])
    assert found.verdict == "verified"
    assert ("forward vectors would fit as well" in found.note) == said


def test_a_jump_of_the_reference_that_nothing_explains_is_told():
    """As where a clip loops: what is smooth stays alike, so that it is no cut, and what is fine is another."""
    fine = np.random.default_rng(3).standard_normal((2, HEIGHT, WIDTH + COUNT, 1))
    frames = [surface(t) + 0.05 * fine[int(t >= 9), :, COUNT - t : COUNT - t + WIDTH] for t in range(COUNT)]
    found = check(uniform((1.0, 0.0)), frames, clean=True)
    assert (found.error, found.cuts, found.frames) == ("", (), ())
    assert "the reference jumps with frame 9" in found.note
    assert "jumps" not in check(uniform((1.0, 0.0)), frames).note
