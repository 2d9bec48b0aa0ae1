"""Vectors as engines write them, by their own formulas: files in, px right and down out."""

import json

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from moving_wall import COUNT, HEIGHT, WIDTH, moved, ndc, picture, to_px, wall, write

from swimlab.footage.convention import PRESETS, SOURCES, guess
from swimlab.footage.request import Request
from swimlab.footage.subject import Subject

UNREAL = tuple(f"FinalImageMovieRenderQueue_MotionVectors.{channel}" for channel in "RG")


def now_and_before(t):
    """NDC of the wall seen in each pixel of frame t, then and in the frame before, y up."""
    points = wall(t)
    return ndc(points, t), ndc(points, t - 1)


def unreal(t):
    """Movie Render Queue: the velocity in NDC, a quarter of it about one half."""
    now, before = now_and_before(t)
    return (now - before) / 4 + 0.5


def godot(t):
    """Clip space of Vulkan has y down."""
    now, before = (place * [1, -1] * 0.5 for place in now_and_before(t))
    return before - now


def threejs(t):
    now, before = now_and_before(t)
    return now - before


def fsr(t):
    now, before = now_and_before(t)
    return (before - now) * [WIDTH / 2, -HEIGHT / 2]


def dlss(t):
    now, before = map(to_px, now_and_before(t))
    return before - now


def unity(t):
    now, before = now_and_before(t)
    return 0.5 * (now - before)


def blender(t):
    now, before = (place * [WIDTH / 2, HEIGHT / 2] for place in now_and_before(t))
    return before - now


ENGINES = {
    "unreal": (unreal, UNREAL),
    "godot": (godot, ("R", "G")),
    "threejs": (threejs, ("R", "G")),
    "fsr": (fsr, ("X", "Y")),
    "dlss": (dlss, ("R", "G")),
    "unity": (unity, ("R", "G")),
    "blender": (blender, ("View.Vector.X", "View.Vector.Y")),
}


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    return write(tmp_path_factory.mktemp("wall") / "test", picture)


@pytest.mark.parametrize("engine", ENGINES)
def test_vectors_of_an_engine_are_exact_and_verified(swimlab, frames, tmp_path, engine, tolerance):
    write_vectors, channels = ENGINES[engine]
    motion = write(tmp_path / "mv", write_vectors, channels)
    notes = []
    subject = Subject(
        Request(test=str(frames), motion=str(motion), convention=PRESETS[engine]), notes.append, notes.append
    )
    for t in range(1, COUNT):
        assert np.abs(subject.motion.moved(t, t - 1) - moved(t)).max() < tolerance("motion")
    assert any(note.startswith("motion verified") for note in notes)

    code, out, err = swimlab("measure", "--test", frames, "--motion", motion, "--motion-convention", engine, "--json")
    assert code == 0, err
    entry = json.loads(out)["sequences"][0]
    assert entry["scores"]["residual.flicker"] < tolerance("unwarped glued") * np.var(picture(0))


def test_a_velocity_buffer_of_unreal_4_is_read_with_an_offset_of_its_own(swimlab, frames, tmp_path, tolerance):
    """Two channels of 16 bit, 0 to 1: V * 0.2495 + 32767 / 65535."""
    for t in range(COUNT):
        now, before = now_and_before(t)
        spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, oiio.UINT16)
        output = oiio.ImageOutput.create("png")
        assert output.open(str(tmp_path / f"mv.{t:04d}.png"), spec)
        encoded = (now - before) * (0.499 * 0.5) + 32767 / 65535
        assert output.write_image(np.dstack([encoded, np.zeros((HEIGHT, WIDTH))]).astype(np.float32))
        output.close()
    words = ("measure", "--test", frames, "--motion", "mv.####.png", "--motion-convention", "ndc", "--json")
    offset = f"--motion-offset={32767 / 65535}"
    code, out, err = swimlab(*words, offset, "--motion-scale", 1 / 0.2495)
    assert code == 0, err
    assert "motion verified" in err
    assert "offset 0.499992,0.499992" in err
    content = json.loads(out)
    assert content["provenance"]["settings"]["convention"]["offset"] == [32767 / 65535] * 2
    scores = content["sequences"][0]["scores"]
    assert scores["residual.flicker"] < tolerance("unwarped glued") * np.var(picture(0))


def test_the_offset_may_differ_by_axis(swimlab, frames, tmp_path):
    write(tmp_path / "mv", lambda t: moved(t) + np.array([3, -7]), ("X", "Y"))
    words = ("measure", "--test", frames, "--motion", "mv", "--json")
    assert swimlab(*words, "--motion-offset=3,-7")[0] == 0
    assert swimlab(*words)[0] == 2
    assert swimlab(*words, "--motion-offset", "3,-7")[0] == 0


@pytest.mark.parametrize("text", ["x", "1,2,3", "nan", ""])
def test_an_offset_that_is_no_number_is_refused(swimlab, frames, text):
    code, _, err = swimlab("measure", "--test", frames, "--motion", frames, f"--motion-offset={text}")
    assert code == 2
    assert "--motion-offset" in err


def test_coarse_codes_about_an_offset_are_told(swimlab, frames, tmp_path):
    """Half floats near one half step by 2^-11; Unreal writes them unless told otherwise."""
    from swimlab.runs.frames import write_channels

    for t in range(COUNT):
        write_channels(tmp_path / f"{t:04d}.exr", unreal(t).astype(np.float32), UNREAL, half=True, metadata={})
    err = swimlab("measure", "--test", frames, "--motion", ".", "--motion-convention", "unreal")[2]
    assert f"stored as half, near no motion in steps of {2 * WIDTH / 2**11:.2g} px; store 32-bit floats" in err


def test_every_preset_names_its_source():
    assert list(SOURCES) == list(PRESETS)
    assert all(len(source) > 20 for source in SOURCES.values())


def test_conventions_are_listed(swimlab):
    rows = json.loads(swimlab("list", "conventions", "--json")[1])
    assert [row["convention"] for row in rows] == list(PRESETS)
    row = rows[list(PRESETS).index("unreal")]
    assert (row["unit"], row["direction"], row["y"]) == ("uv", "backward", "up")
    assert (row["scale"], row["offset"]) == ("2,2", "0.5,0.5")
    assert row["channels"].startswith(",".join(UNREAL))
    code, out, _ = swimlab("list", "conventions")
    assert code == 0
    assert "VelocityNode.js" in out


def test_unreal_is_known_by_its_channels():
    assert guess(("R", "G", "B", *UNREAL)) == "unreal"


FORGOTTEN = {
    "unreal as unity": ("unreal", "unity", "--motion-convention unreal"),
    "unreal as uv": ("unreal", "uv", "--motion-convention unreal"),
    "godot as unreal": ("godot", "unreal", "--motion-convention godot"),
    "threejs as unreal": ("threejs", "unreal", "--motion-convention ndc (or threejs: they mean the same here)"),
}


@pytest.mark.parametrize("case", FORGOTTEN)
def test_a_forgotten_offset_is_named_by_the_preset_that_has_it(swimlab, frames, tmp_path, case):
    truth, given, mend = FORGOTTEN[case]
    write(tmp_path / "mv", ENGINES[truth][0], ("R", "G"))
    words = ("measure", "--test", frames, "--motion", "mv")
    code, _, err = swimlab(*words, "--motion-convention", given)
    assert code == 2
    assert "leaves 0.00" in err
    assert f"Use {mend}, or" in err
