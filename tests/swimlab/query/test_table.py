"""Queries over runs: what the tables hold, what a query may not do, and how rows come out."""

import csv
import json
import sys
from io import StringIO
from pathlib import Path

import duckdb
import pytest
from gate_files import entry, write_scores

from swimlab.query.rows import COLUMNS, find_runs, rows_of
from swimlab.query.store import QueryError, Store
from swimlab.runs.record import Record, RunError
from swimlab.runs.scores import frames_table

HASH = "0123456789abcdef"


def write_run(folder, name="road-shift", value=1.0, *, scored=True):
    """A run folder without pictures."""
    folder.mkdir(parents=True)
    sequence = {"name": name, "size": [64, 36], "fps": 60.0, "motion": {"kind": "shift"}, "sun": {"elevation": 14.0}}
    about = {"swimlab": "0.1.0", "command": "swimlab render", "date": "2026-11-22T21:20:57Z"}
    times = {"tsl": {"ms_per_frame": 2.5, "shaded_per_frame": 100.0, "frames": 2}}
    settings = {"samples": 16, "half": True}
    Record(sequence, settings, HASH, None, False, about, ["tsl", "lean"], [0, 1], times).write(folder)
    if scored:
        tsl, lean = (entry(name, technique, budget_flicker=value, plane_on=None) for technique in ("tsl", "lean"))
        write_scores(folder, tsl | {"errors": {"budget.flicker": 0.25}}, lean)
    return folder


@pytest.fixture
def ask(tmp_path):
    """Ask a store of three runs, one of them not measured."""
    write_run(tmp_path / "study" / "road-shift")
    write_run(tmp_path / "study" / "road-hills", "road-hills", 3.0)
    write_run(tmp_path / "plain", scored=False)
    return lambda query: Store(find_runs([tmp_path])).ask(query).rows


def test_scores_are_rows(ask):
    assert ask(
        "SELECT sequence, technique, value, error, unit, better FROM scores WHERE metric = 'budget.flicker'"
    ) == [
        ("road-hills", "tsl", 3.0, 0.25, "radiance^2", "lower"),
        ("road-hills", "lean", 3.0, None, "radiance^2", "lower"),
        ("road-shift", "tsl", 1.0, 0.25, "radiance^2", "lower"),
        ("road-shift", "lean", 1.0, None, "radiance^2", "lower"),
    ]


def test_a_score_that_is_no_number_is_null(ask):
    assert ask("SELECT count(*), count(value) FROM scores WHERE metric = 'plane.on'") == [(4, 0)]


def test_means_over_runs(ask):
    query = "SELECT technique, avg(value) FROM scores WHERE metric = 'budget.flicker' GROUP BY 1 ORDER BY 1"
    assert ask(query) == [("lean", 2.0), ("tsl", 2.0)]


def test_frames_runs_and_times_are_rows(ask, tmp_path):
    assert ask("SELECT frame, metric, value FROM frames WHERE technique = 'tsl' AND sequence = 'road-shift'") == [
        (0, "mse", 1.0),
        (1, "mse", 2.0),
        (1, "change", 3.0),
    ]
    assert ask("SELECT ms_per_frame, frames FROM times WHERE run LIKE '%plain'") == [(2.5, 2)]
    (row,) = ask(
        "SELECT hash, domain, width, height, frames, samples, half, year(date), settings->>'$.sun.elevation' "
        "FROM runs WHERE run LIKE '%road-hills'"
    )
    assert row == (HASH, "linear", 64, 36, 2, 16, True, 2026, "14.0")


def test_every_row_has_every_column(tmp_path):
    write_run(tmp_path / "run")
    for found in (rows_of(tmp_path / "run"), rows_of(tmp_path / "run" / "scores.json")):
        assert set(found) == set(COLUMNS)
        for table, rows in found.items():
            assert all(len(row) == len(COLUMNS[table]) for row in rows)


def test_runs_are_found_anywhere_below_once_and_not_inside_runs(tmp_path):
    deep = write_run(tmp_path / "a" / "b" / "c")
    write_run(deep / "inside")
    assert find_runs([tmp_path, deep]) == [deep]
    with pytest.raises(RunError, match=r"holds no run\.json"):
        find_runs([tmp_path / "nowhere"])


def test_many_rows_go_in_by_batches(tmp_path, monkeypatch):
    monkeypatch.setattr("swimlab.query.store.BATCH", 3)
    runs = [write_run(tmp_path / f"{index}") for index in range(5)]
    assert [row[:2] for row in Store(runs).overview().rows] == [
        ("scores", 20),
        ("frames", 30),
        ("runs", 5),
        ("times", 5),
    ]


@pytest.mark.parametrize(
    "query",
    [
        "SELECT * FROM read_csv('/etc/hostname')",
        "SELECT * FROM '/etc/hostname'",
        "FROM read_text('{file}')",
        "FROM glob('/*')",
        "COPY scores TO '{file}'",
        "ATTACH '{file}' AS other",
        "INSTALL httpfs",
        "SET enable_external_access = true",
        "DROP TABLE scores",
        "SELECT 1; SELECT 2",
        "SELECT * FROM leaked",
        "selec 1",
        "SELECT valu FROM scores",
        " ",
    ],
)
def test_a_query_reaches_nothing_but_the_tables(ask, tmp_path, query):
    leaked = {"a": 1}
    file = tmp_path / "file"
    file.write_text("secret")
    with pytest.raises(QueryError, match=r"scores\(run, sequence"):
        ask(query.format(file=file))
    assert file.read_text() == "secret"
    assert leaked


@pytest.mark.parametrize(
    "query", ["DESCRIBE scores", "SUMMARIZE times", "FROM runs", "SHOW TABLES", "EXPLAIN SELECT 1"]
)
def test_queries_that_read_are_answered(ask, query):
    assert ask(query)


def test_a_query_may_be_longer_than_a_file_name(swimlab, tmp_path):
    write_run(tmp_path / "run")
    query = f"SELECT 1 AS one WHERE {' AND '.join(100 * ['1 = 1'])}"
    assert swimlab("table", "run", query, "--csv", "-q")[:2] == (0, "one\n1\n")


def test_without_a_query_the_tables_are_listed(swimlab, tmp_path):
    write_run(tmp_path / "run")
    code, out, _ = swimlab("table", "run")
    assert code == 0
    assert [line.split()[:2] for line in out.splitlines() if "run, sequence" in line] == [
        ["scores", "4"],
        ["frames", "6"],
        ["runs", "1"],
        ["times", "1"],
    ]


def test_rows_come_as_table_csv_json_and_parquet(swimlab, tmp_path):
    write_run(tmp_path / "run")
    query = "SELECT technique, value, 0.5 AS half, 'nan'::DOUBLE AS none FROM scores WHERE metric = 'budget.flicker'"
    code, out, _ = swimlab("table", "run", query)
    assert code == 0
    assert out.splitlines()[3].split() == ["tsl", "1", "0.5", "nan"]
    _, out, _ = swimlab("table", "run", query, "--csv")
    assert list(csv.reader(StringIO(out)))[:2] == [["technique", "value", "half", "none"], ["tsl", "1.0", "0.5", "nan"]]
    _, out, _ = swimlab("table", "run", query, "--json")
    assert json.loads(out)[1] == {"technique": "lean", "value": 1.0, "half": 0.5, "none": None}
    code, out, _ = swimlab("table", "run", query, "--parquet", "out/it's.parquet")
    assert (code, out.strip()) == (0, "out/it's.parquet")
    written = duckdb.connect().execute("SELECT technique FROM read_parquet(?)", ["out/it's.parquet"]).fetchall()
    assert written == [("tsl",), ("lean",)]
    assert [path.name for path in Path("out").iterdir()] == ["it's.parquet"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "name at least one run"),
        (["SELECT 1"], "name at least one run"),
        (["nowhere"], "nowhere: holds no run.json"),
        (["run", "SELECT x FROM scores"], 'column "x" not found'),
        (["run", "--parquet", "x"], "needs a query"),
        (["run", "SELECT 1", "--csv", "--json"], "give one of"),
    ],
)
def test_what_cannot_be_asked_is_refused(swimlab, tmp_path, words, said):
    write_run(tmp_path / "run")
    code, out, err = swimlab("table", *words)
    assert (code, out) == (2, "")
    assert said in err


def test_a_file_that_cannot_be_written_is_named_as_it_was_given(swimlab, tmp_path, monkeypatch):
    write_run(tmp_path / "run")

    def refuse(self, *_, **__):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "touch", refuse)
    code, _, err = swimlab("table", "run", "SELECT metric FROM scores", "--parquet", "out.parquet")
    assert (code, err.splitlines()[-1]) == (2, "swimlab: out.parquet: cannot be written: Permission denied")


def test_runs_that_cannot_be_read_are_named_and_the_others_shown(swimlab, tmp_path):
    write_run(tmp_path / "good")
    (write_run(tmp_path / "cut") / "scores.json").write_text("{", encoding="utf-8")
    (write_run(tmp_path / "odd") / "run.json").write_text("[]", encoding="utf-8")
    code, out, err = swimlab("table", ".", "SELECT DISTINCT run FROM scores", "--csv", "-q")
    assert (code, out) == (2, "run\ngood\n")
    lines = err.splitlines()
    assert [line.split("/")[0] for line in lines] == ["swimlab: cut", "swimlab: odd"]
    assert all(line.endswith("; left out") for line in lines)
    code, out, err = swimlab("table", "cut", "odd", "-q")
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 2


def test_a_query_that_fails_leaves_no_file(swimlab, tmp_path):
    write_run(tmp_path / "run")
    code, _, _ = swimlab("table", "run", "SELECT x FROM scores", "--parquet", "out.parquet")
    assert code == 2
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_without_duckdb_the_extra_is_named(swimlab, tmp_path, monkeypatch):
    write_run(tmp_path / "run")
    monkeypatch.setitem(sys.modules, "duckdb", None)
    code, _, err = swimlab("table", "run")
    assert code == 2
    assert "pip install 'swimlab[table]'" in err


def test_the_table_of_frames_names_each_column_once():
    rows = list(csv.reader(StringIO(frames_table([entry(), entry(technique="lean")]))))
    assert rows[0] == ["sequence", "technique", "frame", "mse", "change"]
    assert rows[2] == ["road-shift", "tsl", "1", "2.0", "3.0"]
