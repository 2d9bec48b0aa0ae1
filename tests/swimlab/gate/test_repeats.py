"""A spread is made of measurements that are each their own: the same one given twice is refused."""

import shutil

import pytest
from gate_files import entry, write_gate, write_scores


@pytest.fixture
def runs(tmp_path):
    """Two runs of other values, and a copy of the first elsewhere."""
    write_gate(tmp_path / "gate.toml", 'metric = "budget.mse"\nmax_increase = 0', baseline='file = "b.json"')
    write_scores(tmp_path / "one", entry(budget_mse=1.0, budget_bias=None))
    write_scores(tmp_path / "two", entry(budget_mse=2.0))
    shutil.copytree(tmp_path / "one", tmp_path / "copy")
    return tmp_path


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("one", "one"), "one: is the same as one; name each run once"),
        (("one", "two", "one/../one"), "one/../one: is the same as one; name each run once"),
        (("one", "one/scores.json"), "one/scores.json: is the same as one; name each run once"),
        (("one", "two", "copy"), "copy: tsl on road-shift has the very values of one"),
    ],
)
def test_one_measurement_is_not_two_runs(swimlab, runs, given, message):
    code, out, err = swimlab("baseline", "update", "gate.toml", *given, "--runs", str(len(given)))
    assert (code, out) == (2, "")
    assert message in err.replace("\\", "/")
    assert not (runs / "b.json").exists()


def test_runs_of_their_own_are_taken(swimlab, runs):
    assert swimlab("baseline", "update", "gate.toml", "one", "two", "--runs", "2")[0] == 0


def test_the_same_score_of_other_frames_is_another_run(swimlab, runs):
    rows = [{"frame": 0, "mse": 1.5}, {"frame": 1, "mse": 0.5, "change": 3.0}]
    write_scores(runs / "other", entry(frames=rows, budget_mse=1.0))
    assert swimlab("baseline", "update", "gate.toml", "one", "other", "--runs", "2")[0] == 0
