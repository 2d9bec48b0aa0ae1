"""`swimlab table`."""

import csv
import json
import os
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich import box
from rich.table import Table
from rich.text import Text

from swimlab.cli.terminal import print_whole, progress
from swimlab.query.rows import find_runs
from swimlab.query.store import Answer, Store
from swimlab.runs.record import RunError

Flag = Parameter(negative="")


def table_command(
    *words: str,
    csv: Annotated[bool, Flag] = False,
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    parquet: Path | None = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Query the scores of many runs in SQL (DuckDB): swimlab table RUN... "SELECT ..."

    The tables are scores, frames, runs and times; without a query they are listed with their columns and rows. A query
    reads what the runs hold and reaches no file. A run that cannot be read is named and left out, and the command ends
    with 2.

    Parameters
    ----------
    words:
        Run folders, folders with runs anywhere in them, or scores.json files; then the query, as one word in quotes.
    csv:
        Print CSV.
    json_output:
        Print JSON, an object a row.
    parquet:
        Write the rows to this Parquet file.
    quiet:
        Show no progress.
    """
    if csv + json_output + (parquet is not None) > 1:
        raise RunError("table: give one of --csv, --json and --parquet")
    runs, query = _split(words)
    if not runs:
        raise RunError("table: name at least one run folder, or a folder with runs in it")
    if parquet is not None and query is None:
        raise RunError(f"--parquet {parquet}: needs a query whose rows to write")
    folders = find_runs(runs)
    with progress("reading runs", len(folders), quiet=quiet) as advance:
        store = Store(folders, advance=advance)
    for text in store.unread:
        print(f"swimlab: {text}; left out", file=sys.stderr)
    code = 2 if store.unread else 0
    if query is None:
        answer = store.overview()
    elif parquet is not None:
        store.write(query, parquet)
        print(parquet)
        return code
    else:
        answer = store.ask(query)
    if json_output:
        print(json.dumps(answer.as_json(), indent=1, allow_nan=False))
    elif csv:
        _print_csv(answer)
    else:
        _print_table(answer)
    return code


def _split(words: tuple[str, ...]) -> tuple[list[Path], str | None]:
    """The runs, and the query: the last word where it has blanks or is empty, and is no path."""
    *others, last = words or ("",)
    is_query = len(last.split()) != 1 and not os.path.exists(last)  # noqa: PTH110 - Path's raises for a long query
    return [Path(word) for word in (others if is_query else words)], last if is_query else None


def _print_csv(answer: Answer) -> None:
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(answer.columns)
    table.writerows(answer.rows)


def _print_table(answer: Answer) -> None:
    table = Table(box=box.SIMPLE_HEAD)
    for index, name in enumerate(answer.columns):
        numbers = all(isinstance(row[index], int | float | None) for row in answer.rows)
        table.add_column(Text(name), justify="right" if numbers else "left")
    for row in answer.rows:
        table.add_row(*(Text(_word(value)) for value in row))
    print_whole(table)


def _word(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
