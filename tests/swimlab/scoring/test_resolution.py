"""Which differences are printed as not resolved."""

from swimlab.cli.score_table import print_scores
from swimlab.report.table import score_table
from swimlab.scoring.resolution import MARK, unresolved


def entry(technique, mse, error, floor=0.0):
    errors = {} if error is None else {"budget.mse": error}
    scores = {"budget.mse": mse, "budget.floor": floor}
    return {"sequence": "road", "technique": technique, "scores": scores, "errors": errors, "absent": {}, "frames": []}


def test_a_difference_of_more_than_two_standard_errors_is_resolved():
    assert unresolved([entry("a", 1.0, 0.1), entry("b", 1.3, 0.1)], "budget.mse") == set()
    assert unresolved([entry("a", 1.0, 0.1), entry("b", 1.2, 0.1)], "budget.mse") == {"b"}


def test_each_technique_is_compared_with_the_next_better_one():
    entries = [entry("worst", 5.0, 0.1), entry("best", 1.0, 0.1), entry("second", 1.1, 0.1)]
    assert unresolved(entries, "budget.mse") == {"second"}


def test_nothing_below_the_references_own_error_is_resolved():
    assert unresolved([entry("a", 1.0, 0.0, floor=0.5), entry("b", 1.4, 0.0, floor=0.5)], "budget.mse") == {"b"}


def test_unknown_errors_and_mere_information_are_not_judged():
    assert unresolved([entry("a", 1.0, None), entry("b", 1.0, None)], "budget.mse") == set()
    assert unresolved([entry("a", 1.0, 0.1), entry("b", 1.0, 0.1)], "budget.floor") == set()


def test_tables_mark_what_is_not_resolved(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    entries = [entry("a", 1.0, 0.1), entry("b", 1.1, 0.1)]
    print_scores([{"provenance": {"domain": "linear"}, "sequences": entries}])
    printed = capsys.readouterr().out
    assert f"{MARK}1.0488" in printed
    assert "not resolved" in printed
    (_, cells_a), (_, cells_b) = score_table(entries, {}).rows
    assert not cells_a[0].text.startswith(MARK)
    assert cells_b[0].text.startswith(MARK)
    assert "standard error" in cells_b[0].hint
