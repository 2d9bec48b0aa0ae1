"""A reference that is of another moment or place than the test is told; noise, blur, aliasing and shading are not."""

import json

import numpy as np
import pytest
from scipy import ndimage
from waves import COUNT, HEIGHT, WIDTH, moved, surface

from swimlab.footage.check.placing import misplaced
from swimlab.runs.frames import write_channels

VELOCITY = (2.3, -0.7)


def look(test, reference, coverage=None):
    return misplaced(lambda t: test[t], lambda t: reference[t], coverage, list(range(len(test))))


def noisy(frames, noise=0.05):
    random = np.random.default_rng(3)
    return [frame + noise * random.standard_normal((HEIGHT, WIDTH, 1)) for frame in frames]


REFERENCE = moved(VELOCITY, COUNT + 4)


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.1])
@pytest.mark.parametrize(
    ("late", "named"),
    [(1, "one frame earlier"), (2, "two frames earlier"), (-1, "one frame later"), (-2, "two frames later")],
)
def test_a_reference_of_another_moment_is_named(late, named, noise):
    """The reference shows at frame t what the test shows at t + late."""
    test = noisy(REFERENCE[2 : 2 + COUNT], noise)
    found = look(test, REFERENCE[2 + late : 2 + late + COUNT])
    assert f"the test fits the reference {named}" in found


@pytest.mark.parametrize("velocity", [(0.0, 0.0), VELOCITY])
@pytest.mark.parametrize("shift", [(0.5, 0.5), (-0.25, 0.0), (7.0, -3.0)])
def test_a_shift_of_the_reference_is_measured(shift, velocity, tolerance):
    test = noisy(moved(velocity), 0.02)
    reference = [surface(*(np.multiply(velocity, t) + shift)) for t in range(COUNT)]
    found = look(test, reference)
    assert "the reference is shifted by about " in found
    said = [float(part) for part in found.partition("about ")[2].partition(" px")[0].split(",")]
    assert said == pytest.approx(shift, abs=tolerance("shift of a reference"))


def test_a_slow_steady_picture_tells_neither_moment_nor_place():
    frames = moved((0.5, 0.3), COUNT + 1)
    found = look(noisy(frames[:COUNT], 0.02), frames[1:])
    assert "one frame earlier" in found
    assert "(or the reference is shifted by about 0.5,0.3 px" in found


MIRRORED = {"upside down": (-1, 1), "mirrored": (1, -1), "turned by 180 degrees": (-1, -1)}


@pytest.mark.parametrize("way", MIRRORED)
def test_a_reference_the_other_way_round_is_named(way):
    down, across = MIRRORED[way]
    found = look(noisy(REFERENCE[:COUNT]), [frame[::down, ::across] for frame in REFERENCE[:COUNT]])
    assert found.startswith(f"the reference is {way} against the test")


def lagging(frames):
    """Each frame a mean over those before it, which are blurred and not brought to its place."""
    kept, found = frames[0], []
    for frame in frames:
        kept = 0.6 * frame + 0.4 * kept
        found.append(kept)
    return found


def sparkling(frames):
    """Glints that come and go on single pixels."""
    random = np.random.default_rng(1)
    return [frame + 30.0 * (random.random((HEIGHT, WIDTH, 1)) > 0.99) for frame in frames]


TESTS = {
    "equal": lambda frames: frames,
    "noise": lambda frames: noisy(frames, 0.3),
    "brighter": lambda frames: [2.5 * frame for frame in frames],
    "hazy": lambda frames: [0.3 + 0.5 * frame for frame in frames],
    "blurred": lambda frames: [ndimage.gaussian_filter(frame, (2, 2, 0)) for frame in frames],
    "blinking": lambda frames: [frame * (1 + 0.2 * (-1) ** t) for t, frame in enumerate(frames)],
    "a static error": lambda frames: [frame + 0.5 * surface(seed=4) for frame in frames],
    "a glued error": lambda frames: [
        frame + 0.5 * surface(*np.multiply(VELOCITY, t), seed=4) for t, frame in enumerate(frames)
    ],
    "sparkle": sparkling,
    "coarse": lambda frames: [np.repeat(np.repeat(frame[1::3, 1::3], 3, 0), 3, 1)[:, :WIDTH] for frame in frames],
    "history": lagging,
    "one frame off": lambda frames: [*frames[:7], np.roll(frames[7], 3, axis=1), *frames[8:]],
    "jitter": lambda frames: [
        ndimage.shift(frame, (0.4 * (-1) ** (t // 2), 0.4 * (-1) ** t, 0), mode="nearest")
        for t, frame in enumerate(frames)
    ],
    "another picture": lambda frames: [surface(seed=9) for _ in frames],
    "flat": lambda frames: [np.full_like(frame, 0.5) for frame in frames],
}


def stripes():
    """A pattern that repeats every 8 px and slides by 4 px a frame: every second frame is the same."""
    place = np.arange(WIDTH) - 4.0 * np.arange(COUNT)[:, None]
    return [np.broadcast_to(0.5 + 0.3 * np.cos(np.pi / 4 * row)[None, :, None], (HEIGHT, WIDTH, 3)) for row in place]


CONTENT = {"moving": moved(VELOCITY), "slow": moved((0.2, 0.1)), "still": moved((0.0, 0.0)), "periodic": stripes()}


@pytest.mark.parametrize("content", CONTENT)
@pytest.mark.parametrize("what", TESTS)
def test_nothing_is_said_of_a_reference_in_its_place(what, content):
    assert look(TESTS[what](CONTENT[content]), CONTENT[content]) == ""


@pytest.mark.parametrize("count", [2, 3, 4])
def test_short_clips_are_looked_at_as_far_as_they_go(count):
    assert look(noisy(REFERENCE[:count]), REFERENCE[:count]) == ""
    assert ("one frame earlier" in look(noisy(REFERENCE[:count]), REFERENCE[1 : count + 1])) == (count > 2)


def test_what_is_not_covered_is_not_compared():
    """The sky, half of the picture, is of another place; the ground is not."""
    covered = np.ones((HEIGHT, WIDTH), np.float32)
    covered[: HEIGHT // 2] = 0
    test = noisy(REFERENCE[:COUNT])
    for frame in test:
        frame[: HEIGHT // 2] = np.roll(frame[: HEIGHT // 2], 5, axis=1)
    assert look(test, REFERENCE[:COUNT], lambda t: covered) == ""
    assert look(test, REFERENCE[:COUNT], lambda t: np.zeros_like(covered)) == ""


def test_it_is_warned_of_and_no_score_moves(swimlab, tmp_path):
    test = noisy(moved(VELOCITY))
    for t in range(COUNT):
        for name, frame in (("t", test[t]), ("r", REFERENCE[t + 1])):
            write_channels(tmp_path / f"{name}.{t:04d}.exr", frame.astype("f4"), tuple("RGB"), half=False, metadata={})
    words = ("measure", "--test", "t.####.exr", "--reference", "r.####.exr", "-q", "--json", "--motion")
    code, out, err = swimlab(*words, ",".join(map(str, VELOCITY)))
    assert code == 0
    assert "warning: the test fits the reference one frame earlier far better than its own frame" in err
    entry = json.loads(out)["sequences"][0]
    assert any("one frame earlier" in text for text in entry["warnings"])
    assert any("one frame earlier" in text for text in entry["notes"])
    code, _, err = swimlab(*words, "1,1")
    assert code == 2
    assert "--reference r.####.exr: the test fits the reference one frame earlier" in err
    assert "mend the reference first" in err
