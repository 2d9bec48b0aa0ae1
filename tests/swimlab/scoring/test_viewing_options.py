"""What is seen of a run's flicker from nearer by or on a darker screen, without rendering it again."""

import json

import pytest

from sequences import load
from swimlab.render.plan import Plan
from swimlab.render.run import render_run
from swimlab.runs.entries import read_entries


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run folder: eight frames of a road, point sampled."""
    folder = tmp_path_factory.mktemp("viewing") / "run"
    sequence = load("road-shift").with_changes(size=(128, 72))
    render_run(Plan(sequence=sequence, techniques=("pixel-point",), frames=tuple(range(8))), folder)
    return folder


def test_viewing_on_the_command_line_replaces_the_sequences_and_is_recorded(run, swimlab, tmp_path):
    found, read = {}, {}
    for name, words in {"own": (), "near": ("--pixels-per-degree", "10", "--luminance", "9")}.items():
        code, out, err = swimlab("measure", run, *words, "--json", "-q")
        assert code == 0, err
        (found[name],) = json.loads(out)["sequences"]
        (read[name],) = read_entries(run)
    assert found["own"]["viewing"] == {"pixels_per_degree": 40, "luminance": 200}
    assert found["near"]["viewing"] == {"pixels_per_degree": 10, "luminance": 9}
    assert found["near"]["scores"].pop("visible.flicker") != found["own"]["scores"].pop("visible.flicker")
    assert found["near"]["scores"] == found["own"]["scores"]
    assert any("below daylight" in note for note in found["near"]["notes"])
    assert "pixels_per_degree 10" in read["near"].settings.difference(read["own"].settings)


def test_viewing_that_makes_no_sense_is_refused(run, swimlab):
    code, _, err = swimlab("measure", run, "--luminance", "0", "-q")
    assert code == 2
    assert "--luminance 0: must be above 0" in err


def test_the_quantisation_of_a_runs_halves_is_a_score_like_any(run, swimlab):
    code, out, _ = swimlab("measure", run, "--json", "-q")
    assert code == 0
    (entry,) = json.loads(out)["sequences"]
    assert 0 < entry["scores"]["quantisation.floor"] < 1e-3 * entry["scores"]["residual.flicker"]
    assert entry["errors"]["quantisation.floor"] > 0
    assert "quantisation.floor" in swimlab("list", "metrics")[1]
