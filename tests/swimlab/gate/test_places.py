"""Where a score is worst is where what it is about is: planted errors, blinks and bands of distance."""

import json

import numpy as np
import pytest
from gate_files import HASH, entry, write_gate, write_scores

from swimlab.gate.about import LOOKED, about
from swimlab.gate.evidence import Evidence, find_evidence, where_worst
from swimlab.runs.entries import read_entries
from swimlab.runs.frames import Geometry, frame_path, write_channels, write_frame, write_geometry
from swimlab.runs.record import Record

WIDTH, HEIGHT, COUNT = 288, 160, 6
VELOCITY = (2, -1)
CELL = 8
BAD = 3
PATCHES = {
    "bias": (30, 96, 0.2),
    "detail": (100, 96, 0.3),
    "near": (20, 20, 0.05),
    "mid": (110, 20, 0.07),
    "far": (230, 20, 0.1),
    "edge": (250, 120, 0.02),
}
"""Name -> place (x, y) in frame 0, px, and amplitude; each is PATCH px wide and high and moves with the surface."""
PATCH = 24
NO_PLACE = ("plane.on", "plane.off", "moire.excess", "visible.flicker", "budget.floor", "edges.fraction", "flip.mean")


def picture(t):
    """[H, W, 4]: noise that moves by VELOCITY."""
    wide = np.random.default_rng(3).uniform(0.2, 0.6, (HEIGHT + COUNT, WIDTH + 2 * COUNT, 4)).astype(np.float32)
    wide[..., 3] = 1
    return wide[t : t + HEIGHT, 2 * (COUNT - t) :][:, :WIDTH].copy()


def planted(t):
    """[H, W, 3]: the error of frame t: patches that stay, one in stripes, and patches that blink."""
    error = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    for name, (x, y, amplitude) in PATCHES.items():
        x, y = x + VELOCITY[0] * t, y + VELOCITY[1] * t
        patch = error[y : y + PATCH, x : x + PATCH]
        if name == "bias":
            patch += amplitude
        elif name == "detail":
            patch += (amplitude * (-1.0) ** (np.arange(PATCH) // 2))[:, None].astype(np.float32)
        else:
            patch += amplitude * (-1.0) ** t
    error[HEIGHT - 1, 80:120] += 0.5  # comes into view in the last row
    return error


def write_run(folder, error, **changes):
    """A run of `tsl` whose error in each frame is as told, and of its geometry: three bands of distance."""
    about_run = {"name": "road-shift", "size": [WIDTH, HEIGHT]}
    told = {"uniform_velocity": VELOCITY, "resizes": False, "provenance": {}, "frames": list(range(COUNT))}
    Record(sequence=about_run, settings={}, hash=HASH, **told | changes).write(folder)
    depth = np.repeat([3.0, 10.0, 20.0], WIDTH // 3).astype(np.float32)[None].repeat(HEIGHT, axis=0)
    motion = np.broadcast_to(np.array(VELOCITY, np.float32), (HEIGHT, WIDTH, 2))
    for t in range(COUNT):
        exact = picture(t)
        write_frame(frame_path(folder, "reference", t), exact, half=False, metadata={})
        exact[..., :3] += error(t)
        write_frame(frame_path(folder, "tsl", t), exact, half=False, metadata={})
        write_geometry(frame_path(folder, "geometry", t), Geometry(np.ones_like(depth), motion, depth), metadata={})
    return folder


def class_map():
    """The map of the frame: edges in the lower right corner, new pixels in the last row, tiles elsewhere."""
    shares = {name: np.zeros((HEIGHT // CELL, WIDTH // CELL), int) for name in ("measured", "edges", "new")}
    shares["measured"][:] = 100
    for name, place in (("edges", np.s_[12:19, 28:]), ("new", np.s_[19:, :])):
        shares[name][place], shares["measured"][place] = 100, 0
    return {"cell": [CELL]} | {name: [" ".join(map(str, row)) for row in share] for name, share in shares.items()}


def scores_of(folder, rows=None, **scores):
    """The entry of a run with such rows by frame: all frames alike."""
    each = {"mse": 1.0, "frame_mse": 1.0, "edges_mse": 1.0, "new_mse": 1.0}
    pairs = {"change": 1.0, "edges_flicker": 1.0}
    rows = [{"frame": t, **each, **(pairs if t else {})} for t in range(COUNT)] if rows is None else rows
    content = entry(frames=rows, **scores) | {"curves": {"frame.map": class_map()}}
    return read_entries(write_scores(folder, content))[0]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("places") / "run", planted)


def surrounds(region, box):
    """Whether a region (x, y, width, height) has a box (left, top, right, bottom) in it."""
    x, y, width, height = region
    left, top, right, bottom = box
    return x <= left and right <= x + width and y <= top and bottom <= y + height


def holds(region, patch, frame):
    """Whether a region of a frame holds a planted patch."""
    left, top = (PATCHES[patch][axis] + VELOCITY[axis] * frame for axis in (0, 1))
    return surrounds(region, (left, top, left + PATCH, top + PATCH))


@pytest.mark.parametrize(
    ("metric", "patch"),
    [
        ("budget.mse", "detail"),
        ("budget.bias", "bias"),
        ("budget.detail", "detail"),
        ("budget.flicker", "far"),
        ("budget.flicker.near", "near"),
        ("budget.flicker.mid", "mid"),
        ("budget.flicker.far", "far"),
        ("budget.mse.near", "bias"),
        ("budget.mse.far", "far"),
        ("edges.flicker", "edge"),
        ("edges.mse", "edge"),
        ("residual.flicker", "far"),
    ],
)
def test_a_score_is_worst_where_what_it_is_about_is_planted(run, metric, patch):
    found = find_evidence(scores_of(run), [metric])[metric]
    assert found.region is not None, found.describe()
    assert holds(found.region, patch, found.frame)
    assert found.crop == run / "gate" / f"road-shift-tsl-{metric}.png"


def test_what_comes_into_view_is_where_it_does(run):
    x, y, width, height = find_evidence(scores_of(run), ["new.mse"])["new.mse"].region
    assert x <= 80
    assert x + width >= 120
    assert y + height == HEIGHT


def test_all_scores_are_found_as_each_alone(run):
    metrics = ["budget.mse", "budget.bias", "budget.flicker", "budget.flicker.mid", "edges.flicker"]
    scores = scores_of(run)
    assert find_evidence(scores, metrics) == {metric: find_evidence(scores, [metric])[metric] for metric in metrics}


def test_of_what_is_static_no_frame_is_said_to_be_worst(run):
    said = find_evidence(scores_of(run), ["budget.bias"])["budget.bias"].describe()
    assert said.startswith("worst at x ")
    assert "px of frame " in said


@pytest.mark.parametrize("metric", NO_PLACE)
def test_a_score_without_a_place_has_none(run, metric):
    assert about(metric) is None
    assert find_evidence(scores_of(run), [metric]) == {}


@pytest.mark.parametrize("worse", [BAD, BAD + 1])
def test_the_bad_frame_of_a_flicker_is_named_by_the_place_alone(tmp_path, worse):
    """Elsewhere the errors fall from frame to frame, so that of all of them the earlier frame is always the worse."""

    def error(t):
        found = np.zeros((HEIGHT, WIDTH, 3), np.float32)
        if t == BAD:
            found[60 : 60 + PATCH, 150 : 150 + PATCH] = 0.25
        return found

    rows = [{"frame": t, "mse": 9.0 - t, **({"change": float(t == worse)} if t else {})} for t in range(COUNT)]
    scores = scores_of(write_run(tmp_path / "run", error), rows)
    found = find_evidence(scores, ["budget.flicker"])["budget.flicker"]
    assert (found.frame, found.before) == (BAD, None)
    assert surrounds(found.region, (150, 60, 150 + PATCH, 60 + PATCH))


def test_the_band_finds_its_own_frame(tmp_path):
    """By the rows frame 5 is worst of all bands; near changes in frame 2 alone."""

    def error(t):
        found = np.zeros((HEIGHT, WIDTH, 3), np.float32)
        found[40:64, 230:254] = 0.3 * (t == 5)
        found[40:64, 20:44] = 0.1 * (t == 2)
        return found

    rows = [{"frame": t, "mse": 1.0, **({"change": float(t)} if t else {})} for t in range(COUNT)]
    scores = scores_of(write_run(tmp_path / "run", error), rows)
    found = find_evidence(scores, ["budget.flicker", "budget.flicker.near"])
    assert {metric: each.frame for metric, each in found.items()} == {"budget.flicker": 5, "budget.flicker.near": 2}
    assert found["budget.flicker.near"].region[0] <= 20
    assert COUNT <= LOOKED


def test_without_a_reference_a_change_lies_between_two_frames(tmp_path):
    folder = write_run(tmp_path / "run", planted)
    for t in range(COUNT):
        frame_path(folder, "reference", t).unlink()
    rows = [{"frame": t, **({"change": 1.0 + t} if t else {})} for t in range(COUNT)]
    found = find_evidence(scores_of(folder, rows), ["residual.flicker"])["residual.flicker"]
    assert (found.frame, found.before) == (COUNT - 1, COUNT - 2)
    assert holds(found.region, "far", COUNT - 1)


def test_what_cannot_be_read_is_told_in_place_of_a_guess(tmp_path):
    folder = write_run(tmp_path / "run", planted)
    for t in range(COUNT):
        frame_path(folder, "geometry", t).unlink()
    found = find_evidence(scores_of(folder), ["budget.flicker", "budget.flicker.near"])
    assert found["budget.flicker"].region is not None
    assert found["budget.flicker.near"].frame is None
    assert found["budget.flicker.near"].describe().startswith("where it is worst is not known: ")


def test_without_a_map_nothing_is_said_of_edges(run):
    content = entry(frames=[{"frame": t, "mse": 1.0, "edges_flicker": float(t)} for t in range(COUNT)])
    (scores,) = read_entries(write_scores(run, content))
    found = find_evidence(scores, ["edges.flicker"])["edges.flicker"]
    assert (found.region, found.crop) == (None, None)
    assert "hold no map of edges" in found.describe()


@pytest.mark.parametrize(("metric", "frame"), [("scale.rmse", 1), ("scale.self_rmse", 2), ("scale.mean_drift", 3)])
def test_each_score_of_scales_has_its_own_worst_scale(run, metric, frame):
    content = entry(frames=[])
    content["curves"]["scale"] = {
        "scale": [1.0, 0.8, 0.6, 0.5, 0.4, 0.3],
        "rmse": [0.9, 0.8, 0.1, 0.1, 0.1, 0.1],
        "self_rmse": [0.0, 0.1, 0.8, 0.1, 0.1, 0.1],
        "mean_drift": [0.0, 1.0, 2.0, -8.0, 3.0, None],
    }
    (scores,) = read_entries(write_scores(run, content))
    assert where_worst(scores, metric) == Evidence(frame)
    assert where_worst(scores, "scale.slope") is None


def test_brought_frames_that_stand_still_are_found_where_they_blink(swimlab, tmp_path):
    """A patch that is off by far more than the blinking one is, and does not change. Depth has numbers of its own."""
    depth = np.repeat([3.0, 20.0], 96).astype(np.float32)[None, :, None].repeat(128, axis=0)
    rng = np.random.default_rng(4)
    exact = rng.uniform(0.3, 0.6, (128, 192, 3)).astype(np.float32)
    for t in range(4):
        test = exact.copy()
        test[70:110, 10:50] += 0.4
        test[20:50, 140:170] += 0.05 * (-1) ** t
        for name, pixels in (("ref", exact), ("test", test)):
            path = tmp_path / name / f"f.{t:04d}.exr"
            write_channels(path, pixels, ("R", "G", "B"), half=False, metadata={})
        write_channels(tmp_path / "depth" / f"z.{t + 100}.exr", depth, ("Z",), half=False, metadata={})
    words = ("--test", "test", "--reference", "ref", "--depth", "depth", "-o", "run", "-q")
    assert swimlab("measure", *words)[0] == 0
    metrics = ("budget.mse", "budget.mse.near", "budget.mse.far", "budget.flicker", "budget.bias")
    write_gate(tmp_path / "gate.toml", *(f'metric = "{metric}"\nmax = 1e-9' for metric in metrics))
    assert swimlab("gate", "gate.toml", "run", "--json", "gate.json")[0] == 1
    checks = json.loads((tmp_path / "gate.json").read_text(encoding="utf-8"))["checks"]
    regions = {check["metric"]: check["evidence"]["region"] for check in checks}
    for metric, box in {
        "budget.flicker": (140, 20, 170, 50),
        "budget.mse": (10, 70, 50, 110),
        "budget.mse.near": (10, 70, 50, 110),
        "budget.mse.far": (140, 20, 170, 50),
        "budget.bias": (10, 70, 50, 110),
    }.items():
        assert surrounds(regions[metric], box), metric
