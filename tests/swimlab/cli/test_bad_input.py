"""Bad frames, patterns, motion and options, run folders and sequences: each with its exit code and a clear message."""

import json
from pathlib import Path

import numpy as np
import pytest

from swimlab.runs.frames import write_channels

WIDTH, HEIGHT = 48, 40
RGB = ("R", "G", "B")
TEST = ("measure", "--test", "good.####.exr")


def picture(t: int, *, width: int = WIDTH) -> np.ndarray:
    """[H, W, 3]: smooth, moving by a pixel to the right a frame."""
    y, x = np.indices((HEIGHT, width)).astype(np.float32)
    grey = np.cos(0.7 * (x - t) + 0.3 * y) + np.cos(0.4 * y - 0.23 * (x - t) + 1)
    return np.repeat(3 + grey[..., None], 3, axis=2)


def write(name: str, pixels: np.ndarray, channels: tuple[str, ...] = RGB) -> None:
    write_channels(Path(name), pixels.astype(np.float32), channels, half=False, metadata={})


def frames(name: str = "good", numbers: tuple[int, ...] = (0, 1, 2, 3), **changes: int) -> None:
    for t in numbers:
        write(f"{name}.{t:04d}.exr", picture(t, **changes))


def vectors(x: float, y: float, *, name: str = "mv", numbers: tuple[int, ...] = (0, 1, 2, 3)) -> None:
    for t in numbers:
        write(f"{name}.{t:04d}.exr", np.broadcast_to((x, y), (HEIGHT, WIDTH, 2)), ("motion.X", "motion.Y"))


def nothing() -> None:
    pass


def gap() -> None:
    frames("bad", (0, 1, 3))


def not_a_number() -> None:
    frames("bad")
    pixels = picture(2)
    pixels[3, 5, 1] = np.nan
    write("bad.0002.exr", pixels)


def infinite() -> None:
    frames("bad")
    write("bad.0001.exr", np.full((HEIGHT, WIDTH, 3), np.inf))


def other_size() -> None:
    frames("bad", (0, 1, 3))
    frames("bad", (2,), width=WIDTH - 1)


def other_channels() -> None:
    frames("bad", (0, 1, 3))
    write("bad.0002.exr", picture(2)[..., :2], ("R", "G"))


def truncated() -> None:
    for t in range(4):
        write(f"bad.{t:04d}.exr", np.random.default_rng(t).random((HEIGHT, WIDTH, 3)))
    path = Path("bad.0002.exr")
    path.write_bytes(path.read_bytes()[:-2000])


def no_picture() -> None:
    frames("bad", (0, 1, 2))
    Path("bad.0001.exr").write_text("nothing of the kind")


def shorter_reference() -> None:
    frames("bad", (0, 1, 2))


def smaller_reference() -> None:
    frames("bad", width=WIDTH - 8)


def several_layers() -> None:
    for t in range(4):
        names = tuple(f"{layer}.{c}" for layer in ("key", "fill") for c in "RGB")
        write(f"bad.{t:04d}.exr", np.concatenate([picture(t)] * 2, axis=2), names)


def two_sequences() -> None:
    Path("two").mkdir()
    for name in ("a", "b"):
        write(f"two/{name}.0000.exr", picture(0))


def empty_folder() -> None:
    Path("empty").mkdir()


def moving_left() -> None:
    vectors(-1, 0)


def moving_up() -> None:
    vectors(0, -9)


def vectors_with_a_gap() -> None:
    vectors(1, 0, numbers=(0, 1, 3))


def few_vectors() -> None:
    vectors(1, 0, numbers=(0, 1, 2))


def vectors_that_are_no_numbers() -> None:
    vectors(1, 0)
    write("mv.0002.exr", np.full((HEIGHT, WIDTH, 2), np.nan), ("motion.X", "motion.Y"))


def vectors_of_other_size() -> None:
    for t in range(4):
        write(f"mv.{t:04d}.exr", np.ones((HEIGHT, WIDTH - 1, 2)), ("motion.X", "motion.Y"))


def vectors_by_other_names() -> None:
    for t in range(4):
        write(f"mv.{t:04d}.exr", np.ones((HEIGHT, WIDTH, 2)), ("first", "second"))


def several_motions() -> None:
    for t in range(4):
        names = tuple(f"{layer}.{c}" for layer in ("a.Vector", "b.Vector") for c in "XY")
        write(f"mv.{t:04d}.exr", np.ones((HEIGHT, WIDTH, 4)), names)


def small_mask() -> None:
    write("mask.exr", np.ones((8, 8, 1)), ("Y",))


def standing() -> None:
    for t in range(4):
        write(f"bad.{t:04d}.exr", picture(0))


def run_of_another_version() -> None:
    Path("run").mkdir()
    Path("run/run.json").write_text('{"version": 99}')


def broken_run() -> None:
    Path("run").mkdir()
    Path("run/run.json").write_text("{")


def run_without_frames() -> None:
    Path("run").mkdir()
    record = {
        "version": 1, "sequence": {"name": "a", "size": [8, 8], "fps": 60, "frames": 1}, "settings": {}, "hash": "",
        "uniform_velocity": None, "resizes": False, "provenance": {},
    }  # fmt: skip
    Path("run/run.json").write_text(json.dumps(record))


def run_without_a_picture() -> None:
    run_without_frames()
    record = json.loads(Path("run/run.json").read_text())
    Path("run/run.json").write_text(json.dumps(record | {"frames": [0], "techniques": ["tsl"]}))


def sequence(text: str) -> None:
    Path("bad.toml").write_text(f'version = 1\nname = "bad"\n{text}\n', encoding="utf-8")


BAD = ("measure", "--test", "bad.####.exr")
RENDER = ("render", "bad.toml", "-t", "pixel-point", "--frames", "0")

CASES = {
    # Frames
    "a missing frame": (gap, BAD, "bad.0002.exr: is missing, frame 2 of 0 to 3"),
    "a frame missing in a given range": (
        nothing, ("measure", "--test", "good.0-5####.exr"), "good.0004.exr: is missing",
    ),
    "a NaN": (not_a_number, BAD, "bad.0002.exr: holds 1 NaN or infinite values, the first at pixel x 5, y 3"),
    "an infinity": (infinite, BAD, "bad.0001.exr: holds 5760 NaN or infinite values"),
    "a frame of another size": (other_size, BAD, "bad.0002.exr: is 47x40 px, but most frames are 48x40 px"),
    "a frame with other channels": (other_channels, BAD, "bad.0002.exr: has no channels R, G, B as the others have"),
    "a truncated frame": (truncated, BAD, "bad.0002.exr: is damaged"),
    "a frame that is no picture": (no_picture, BAD, "bad.0001.exr: cannot be opened"),
    "one frame": (
        nothing, ("measure", "--test", "good.0001.exr"), "has 1 frame to measure; change in time needs at least 2",
    ),
    "nothing left after skipping": (
        nothing, ("measure", "--test", "good.3-9####.exr", "--skip-bad-frames"), "has 1 frame to measure",
    ),
    "a shorter reference": (
        shorter_reference, (*TEST, "--reference", "bad.#.exr"),
        "has 3 frames (0-2), the test 4 (0-3); they must match: measure those that both have with --frames 0-2",
    ),
    "a smaller reference": (
        smaller_reference, (*TEST, "--reference", "bad.#.exr"),
        "good.####.exr: is 48x40 px, the reference bad.#.exr 40x40 px; they must match",
    ),
    "several layers": (several_layers, BAD, "which channels are the colour? It has fill.R"),
    "a layer that is not there": (several_layers, (*BAD, "--channels", "rim"), "has no channels or layer rim"),
    "two channels": (nothing, (*TEST, "--channels", "R,G"), "--channels R,G: give three channels"),
    "alpha that is not there": (nothing, (*TEST, "--alpha", "mask"), "--alpha mask: good.####.exr has no alpha"),
    # Patterns
    "a pattern without files": (
        nothing, ("measure", "--test", "god.####.exr"), "god.####.exr: no file matches; . holds good.####.exr",
    ),
    "a folder that is not there": (nothing, ("measure", "--test", "gone/a.#.exr"), "there is no folder gone"),
    "a file that is not there": (nothing, ("measure", "--test", "gone.exr"), "gone.exr: no such file"),
    "other padding": (nothing, ("measure", "--test", "good.##.exr"), "good.##.exr: no file matches"),
    "an empty folder": (empty_folder, ("measure", "--test", "empty"), "empty: holds no image files"),
    "a folder with two sequences": (
        two_sequences, ("measure", "--test", "two"), "several sequences (a.####.exr, b.####.exr)",
    ),
    "a range that is none": (nothing, (*TEST, "--frames", "1-"), "1- is no range of frames; write 1-48"),
    "a range far away": (nothing, (*TEST, "--frames", "90-99"), "none of the frames 90-99 is there"),
    # Motion
    "motion to the other side": (nothing, (*TEST, "--motion", "-1,0"), "x flipped leaves"),
    "motion where there is none": (standing, (*BAD, "--motion", "1,0"), "no motion at all leaves 0.000"),
    "vectors to the other side": (moving_left, (*TEST, "--motion", "mv.#.exr"), "Use --motion-scale -1,1"),
    "vectors that have nothing to do with it": (
        lambda: (standing(), moving_up()), (*BAD, "--motion", "mv.#.exr"), "--motion: does not fit the frames",
    ),
    "a missing vector file": (vectors_with_a_gap, (*TEST, "--motion", "mv.#.exr"), "mv.0002.exr: is missing"),
    "too few vector files": (
        few_vectors, (*TEST, "--motion", "mv.#.exr"), "--motion mv.#.exr: has 3 frames (0-2), the test 4",
    ),
    "vectors that are NaN": (
        vectors_that_are_no_numbers, (*TEST, "--motion", "mv.#.exr"), "mv.0002.exr: none of its motion",
    ),
    "vectors of another size": (
        vectors_of_other_size, (*TEST, "--motion", "mv.#.exr"), "is 47x40 px, the frames 48x40 px: more",
    ),
    "vectors by other names": (
        vectors_by_other_names, (*TEST, "--motion", "mv.#.exr"), "it has first, second. Name them with --motion-channels",  # noqa: E501
    ),
    "several motions": (
        several_motions, (*TEST, "--motion", "mv.#.exr", "--motion-convention", "blender"),
        "choose one with --motion-channels a.Vector.X,a.Vector.Y or b.Vector.X",
    ),
    "motion with words": (nothing, (*TEST, "--motion", "fast"), "fast: no such file"),
    "motion that is no number": (nothing, (*TEST, "--motion", "1.2.3,0"), "give dx,dy in px a frame"),
    "motion as a video": (lambda: Path("v.mp4").touch(), (*TEST, "--motion", "v.mp4"), "video holds no motion"),
    "one motion channel": (nothing, (*TEST, "--motion-channels", "X"), "--motion-channels X: give two, x,y"),
    "a motion scale of 0": (nothing, (*TEST, "--motion-scale", "0"), "--motion-scale 0: give a factor other than 0"),
    "an unknown convention": (nothing, (*TEST, "--motion-convention", "maya"), "maya"),
    # Options
    "neither a run nor frames": (nothing, ("measure",), "give RUN or --test, one of them"),
    "both a run and frames": (
        empty_folder, ("measure", "empty", "--test", "good.#.exr"), "give RUN or --test, one of them",
    ),
    "options of frames with a run": (
        empty_folder, ("measure", "empty", "--fps", "30"), "--fps: is for frames of your own",
    ),
    "a frame rate of 0": (nothing, (*TEST, "--fps", "0"), "--fps 0: must be above 0"),
    "a negative angle": (nothing, (*TEST, "--pixels-per-degree=-3"), "--pixels-per-degree -3: must be above 0"),
    "a crop of three numbers": (nothing, (*TEST, "--crop", "1,2,3"), "--crop 1,2,3: give x,y,width,height"),
    "a crop outside": (
        nothing, (*TEST, "--crop", "40,0,20,20"), "--crop 40,0,20,20: does not lie within good.####.exr, 48x40",
    ),
    "a mask of another size": (
        small_mask, (*TEST, "--mask", "mask.exr"), "is 48x40 px, the mask mask.exr 8x8 px; they must match",
    ),
    "an unknown colour space": (nothing, (*TEST, "--colorspace", "acse"), "no colour space 'acse'"),
    "an unknown domain": (nothing, (*TEST, "--domain", "log"), "log"),
    "info of a pattern without files": (nothing, ("info", "god.####.exr"), "god.####.exr: no file matches"),
    "info of a file that is no picture": (no_picture, ("info", "bad.0001.exr"), "bad.0001.exr: cannot be opened"),
    # Run folders
    "a run of another version": (run_of_another_version, ("measure", "run"), "has version 99"),
    "a broken run": (broken_run, ("measure", "run"), "run.json: is not a run description"),
    "a run without frames": (run_without_frames, ("measure", "run"), "run: holds no finished frame"),
    "a run without a picture": (run_without_a_picture, ("measure", "run"), "0000.exr: is missing (2 in all)"),
    # Sequence files
    "a sequence of no frames": (lambda: sequence("frames = 0"), RENDER, "frames: should be greater than or equal to 1"),
    "a sequence of another version": (lambda: Path("bad.toml").write_text("version = 9"), RENDER, "version"),
    "an unknown motion": (lambda: sequence('[motion]\nkind = "spin"'), RENDER, "motion"),
    "a camera under the road": (lambda: sequence("[camera]\nheight = -1.0"), RENDER, "camera.height"),
    "a view of 180 degrees": (lambda: sequence("[camera]\nfov = 180.0"), RENDER, "camera.fov"),
}  # fmt: skip


@pytest.mark.parametrize("what", CASES)
def test_bad_input(swimlab, what):
    prepare, words, message = CASES[what]
    frames()
    prepare()
    code, out, err = swimlab(*words)
    assert code == 2
    assert out == ""
    assert message in " ".join(err.split())
    assert "Traceback" not in err


def test_there_are_enough_of_them():
    assert len(CASES) >= 40
