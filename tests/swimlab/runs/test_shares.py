"""Percents of nothing say nothing."""

import pytest
from gate_files import entry, write_gate, write_scores

from swimlab.compare.change import Change
from swimlab.runs.shares import ROUND_OFF, share


def test_a_share_is_of_what_was_before(tolerance):
    assert share(2.0, 3.0) == pytest.approx(0.5, rel=tolerance("closed form"))
    assert share(-2.0, -3.0) == pytest.approx(-0.5, rel=tolerance("closed form"))
    assert share(1e-9, 2e-9) == pytest.approx(1.0, rel=tolerance("closed form"))


@pytest.mark.parametrize(("before", "after"), [(0.0, 1.0), (4e-15, 0.0025), (4e-15, 8e-15), (-4e-15, 0.1), (1e-9, 1.0)])
def test_of_round_off_there_is_none(before, after):
    assert share(before, after) is None
    assert Change("road", "tsl", "budget.flicker", before, after).as_json()["share"] is None


@pytest.mark.parametrize("base", [0.0, ROUND_OFF / 250])
def test_gate_and_compare_tell_the_amount(swimlab, tmp_path, base):
    write_gate(tmp_path / "gate.toml", 'metric = "budget.flicker"\nmax_increase = "5%"', baseline='file = "b.json"')
    write_scores(tmp_path / "before", entry(budget_flicker=base))
    write_scores(tmp_path / "after", entry(budget_flicker=0.0025))
    assert swimlab("baseline", "update", "gate.toml", "before")[0] == 0
    code, out, _ = swimlab("gate", "gate.toml", "after")
    assert code == 1
    assert f"+0.0025 against the baseline's {base:.4g}, which is as good as 0" in out
    assert "%" not in out
    code, out, _ = swimlab("compare", "before", "after")
    (row,) = [line.split() for line in out.splitlines() if line.lstrip().startswith("tsl")]
    assert (code, row[3:7]) == (0, [f"{base:.4g}", "0.0025", "+0.0025", "-"])
