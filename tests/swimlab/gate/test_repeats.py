"""A spread is made of runs that are each named once."""

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
    ],
)
def test_one_measurement_is_not_two_runs(swimlab, runs, given, message):
    code, out, err = swimlab("baseline", "update", "gate.toml", *given, "--runs", str(len(given)))
    assert (code, out) == (2, "")
    assert message in err.replace("\\", "/")
    assert not (runs / "b.json").exists()


@pytest.mark.parametrize("other", ["two", "copy"])
def test_runs_of_their_own_are_taken(swimlab, runs, other):
    """Also such as give the same values, as of a renderer that gives the same bits each time."""
    assert swimlab("baseline", "update", "gate.toml", "one", other, "--runs", "2")[0] == 0
