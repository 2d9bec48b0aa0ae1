"""The worst frame, the worst region and the picture of it; and the fixture that tests use."""

import json
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from gate_files import HASH, entry, write_gate, write_scores

from swimlab.gate.evidence import ENLARGED, GAP, HEADER, Evidence, where_worst
from swimlab.report.places import SIDE
from swimlab.runs.entries import read_entries
from swimlab.runs.frames import frame_path, read_frame, write_frame
from swimlab.runs.record import Record

SIZE = (160, 96)
SPOT = (100, 84)
FRAMES = [
    {"frame": 0, "mse": 1.0},
    {"frame": 1, "mse": 3.0, "change": 1.0},
    {"frame": 2, "mse": 2.0, "change": 1.0},
    {"frame": 3, "mse": 2.5, "change": 4.0},
]


@pytest.fixture
def run(tmp_path):
    """A run of four frames; the test is brighter by .25 in 8 x 8 px, and far off where the road covers in part."""
    folder = tmp_path / "run"
    record = Record(
        sequence={"name": "road-shift", "size": list(SIZE)},
        settings={},
        hash=HASH,
        uniform_velocity=(0.0, 0.0),
        resizes=False,
        provenance={},
        frames=[0, 1, 2, 3],
    )
    record.write(folder)
    exact = np.full((SIZE[1], SIZE[0], 4), 0.25, np.float32)
    exact[..., 3] = 1.0
    exact[:16, :, 3] = 0.5
    test = exact.copy()
    test[SPOT[1] : SPOT[1] + 8, SPOT[0] : SPOT[0] + 8, :3] += 0.25
    test[:16, :, :3] = 9.0
    for frame in range(4):
        write_frame(frame_path(folder, "tsl", frame), test, half=False, metadata={})
        write_frame(frame_path(folder, "reference", frame), exact, half=False, metadata={})
    return write_scores(folder, entry(frames=FRAMES, budget_flicker=2.0, budget_mse=2.0))


def read_png(path):
    return oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)


@pytest.mark.parametrize(
    ("metric", "frame", "codes"),
    [
        ("budget.mse", 1, [188, 137, 192]),  # sRGB of .5 and of .25, and an error of half the range above the middle
        ("budget.flicker", 3, [188, 0, 1]),  # the frame before, the black one, and a change of the range
    ],
)
def test_a_failing_gate_names_frame_and_region_and_pictures_it(swimlab, run, tmp_path, metric, frame, codes):
    black = read_frame(frame_path(run, "tsl", 3))
    black[SPOT[1] : SPOT[1] + 8, SPOT[0] : SPOT[0] + 8, :3] -= 0.5
    write_frame(frame_path(run, "tsl", 3), black, half=False, metadata={})
    write_gate(tmp_path / "gate.toml", f'metric = "{metric}"\nmax = 1')
    code, out, _ = swimlab("gate", "gate.toml", "run")
    assert code == 1
    assert f"worst in frame {frame} at x " in out
    x, y = (int(out.split(f" {axis} ")[1].split()[0].rstrip(",")) for axis in "xy")
    assert x <= SPOT[0] <= x + SIDE - 8
    assert y <= SPOT[1] <= y + SIDE - 8
    picture = read_png(tmp_path / "run" / "gate" / f"road-shift-tsl-{metric}.png")
    assert picture.shape == (HEADER + ENLARGED * SIDE, 3 * ENLARGED * SIDE + 2 * GAP, 3)
    row, column = HEADER + ENLARGED * (SPOT[1] - y) + 1, ENLARGED * (SPOT[0] - x) + 1
    panels = [picture[row, column + place * (ENLARGED * SIDE + GAP)] for place in range(3)]
    assert [list(panel) for panel in panels] == [[code] * 3 for code in codes]


def test_a_warning_is_pictured_too_and_a_pass_is_not(swimlab, run, tmp_path):
    rules = ['metric = "budget.mse"\nmax = 1\nlevel = "warn"', 'metric = "budget.flicker"\nmax = 9']
    write_gate(tmp_path / "gate.toml", *rules)
    assert swimlab("gate", "gate.toml", "run")[0] == 0
    assert [path.name for path in (run / "gate").iterdir()] == ["road-shift-tsl-budget.mse.png"]


def test_without_pictures_the_frame_alone_is_named(swimlab, run, tmp_path):
    frame_path(run, "reference", 1).unlink()
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    code, out, _ = swimlab("gate", "gate.toml", "run")
    said = "worst in frame 1 (no picture of it: " in " ".join(out.split())
    assert (code, said, (run / "gate").exists()) == (1, True, False)
    assert f"{frame_path(run, 'reference', 1).name} is gone);" in out


def test_frames_of_ones_own_have_no_picture(swimlab, run, tmp_path):
    content = json.loads((run / "scores.json").read_text(encoding="utf-8"))
    content["provenance"]["settings"] = {"fps": 60.0}
    (tmp_path / "own.json").write_text(json.dumps(content), encoding="utf-8")
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    code, out, _ = swimlab("gate", "gate.toml", "own.json")
    assert code == 1
    assert "worst in frame 1 (no picture of it: your own frames are not in a run folder);" in out


def test_scores_older_than_their_run_are_refused(swimlab, run, tmp_path):
    record = Record.read(run)
    record.hash = "f" * 16
    record.write(run)
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 9')
    code, out, err = swimlab("gate", "gate.toml", "run")
    assert (code, out) == (2, "")
    assert "rendered again since it was measured" in err


def test_the_worst_scale_is_the_frame_of_the_largest_error(run):
    content = entry(frames=[], scale_rmse=1.0)
    content["curves"] = {"scale": {"scale": [1.0, 0.7, 0.5, 0.4], "rmse": [0.1, 0.4, 0.3, 0.2]}}
    (found,) = read_entries(write_scores(run, content))
    assert found.settings.extent == "4 scales"
    assert where_worst(found, "scale.rmse") == Evidence(1)


@pytest.mark.parametrize("into", [0.9, 1.1])
def test_of_a_flicker_the_bad_frame_is_named_whichever_of_its_changes_is_larger(tmp_path, into):
    rows = [{"frame": t, "mse": 4.0 if t == 3 else 0.1, "change": {3: into, 4: 1.0}.get(t, 0.0)} for t in range(6)]
    (found,) = read_entries(write_scores(tmp_path / "run", entry(frames=rows, budget_flicker=1.0)))
    assert where_worst(found, "budget.flicker") == Evidence(3)


def test_without_errors_a_change_is_between_two_frames(tmp_path):
    rows = [{"frame": t, "change": float(t == 4)} for t in range(6)]
    (found,) = read_entries(write_scores(tmp_path / "run", entry(frames=rows, budget_flicker=1.0)))
    assert where_worst(found, "budget.flicker").describe() == "worst between frames 3 and 4"


def test_a_picture_that_cannot_be_written_costs_no_verdict(swimlab, run, tmp_path):
    (run / "gate").write_text("in the way", encoding="utf-8")
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    code, out, _ = swimlab("gate", "gate.toml", "run")
    said = " ".join(out.split())
    assert code == 1
    assert "worst in frame 1 at x " in said
    assert "(no picture of it: " in said
    assert "FAILED: 1 fail" in said


def test_the_fixture_takes_a_run(swimlab_gate, run, tmp_path):
    gate = write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 9')
    assert [check.status for check in swimlab_gate(run, gate).checks] == ["pass"]


def test_the_fixture_fails_with_the_table(swimlab_gate, run, tmp_path):
    gate = write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    with pytest.raises(pytest.fail.Exception, match=r"fail +road-shift +tsl +budget\.mse") as failure:
        swimlab_gate(run, gate)
    assert f"swimlab baseline update {gate} {run}" in str(failure.value)


@pytest.mark.parametrize(
    ("gate", "message"), [("max_increase = 1", "max_increase compares with a baseline"), ("maxx = 1", "unknown key")]
)
def test_the_fixture_fails_where_the_gate_cannot_run(swimlab_gate, run, tmp_path, gate, message):
    path = write_gate(tmp_path / "gate.toml", f'metric = "budget.mse"\n{gate}')
    with pytest.raises(pytest.fail.Exception, match=message):
        swimlab_gate(run, path)


def test_the_fixture_fails_for_an_unknown_technique(swimlab_gate, tmp_path):
    path = write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax = 1')
    with pytest.raises(pytest.fail.Exception, match="technique 'tls': is not known; there are"):
        swimlab_gate("road-shift", path, techniques=["tls"])


def test_the_plugin_loads_nothing_heavy():
    """pytest imports it in every project where swimlab is installed."""
    script = """
import sys
import swimlab.pytest_plugin
heavy = {"warp", "numpy", "scipy", "cv2", "OpenImageIO", "pydantic", "rich", "metrics", "sequences"}
print(sorted(heavy & set(sys.modules)))
"""
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert result.stdout == "[]\n"
