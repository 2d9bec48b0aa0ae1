"""The tables in an in-memory DuckDB that a query cannot leave."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from decimal import Decimal
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swimlab.query.rows import COLUMNS, Row, rows_of
from swimlab.runs.files import replacing
from swimlab.runs.record import RunError

if TYPE_CHECKING:
    from duckdb import DuckDBPyConnection

SEALED = {
    "enable_external_access": "false",
    "autoload_known_extensions": "false",
    "autoinstall_known_extensions": "false",
    "python_enable_replacements": "false",
    "lock_configuration": "true",
}
"""No file, network, extension or variable of this program can be reached from a query, nor can a query undo this."""

BATCH = 100_000
"""Rows that go into a table at a time."""


class QueryError(RunError):
    """A query that DuckDB does not run; the message has its words and the tables that there are."""


@dataclass(frozen=True)
class Answer:
    """Rows of a query, under the names of its columns."""

    columns: list[str]
    rows: list[Row]

    def as_json(self) -> list[dict[str, Any]]:
        """A dictionary a row, ready for JSON: numbers that JSON does not have become null, dates text."""
        return [dict(zip(self.columns, map(_plain, row), strict=True)) for row in self.rows]


class Store:
    """Tables of runs, in memory: two stores do not meet, and nothing is left behind. Asked or written once."""

    def __init__(self, runs: Iterable[Path], *, advance: Callable[[str], None] = lambda _: None) -> None:
        """Read all runs that can be read. Raises RunError where DuckDB is not installed, or no run can be read."""
        try:
            import duckdb  # an extra
        except ImportError as error:
            raise RunError(f"table: needs DuckDB ({error}); pip install 'swimlab[table]'") from error
        self._error = duckdb.Error
        self._kinds = {duckdb.StatementType.SELECT, duckdb.StatementType.EXPLAIN, duckdb.StatementType.MULTI}
        self._connection: DuckDBPyConnection = duckdb.connect(":memory:")
        for table, columns in COLUMNS.items():
            listed = ", ".join(f"{name} {kind}" for name, kind in columns.items())
            self._connection.execute(f"CREATE TABLE {table} ({listed})")
        waiting: dict[str, list[Row]] = {table: [] for table in COLUMNS}
        self.unread: list[str] = []
        """What is wrong with the runs that cannot be read."""
        read = 0
        for run in runs:
            try:
                found = rows_of(run)
            except RunError as error:
                self.unread.append(str(error))
                found = {}
            read += bool(found)
            for table, rows in found.items():
                waiting[table] += rows
                if len(waiting[table]) > BATCH:
                    self._insert(table, waiting.pop(table))
                    waiting[table] = []
            advance(str(run))
        if not read:
            raise RunError("\n".join(self.unread))
        for table, rows in waiting.items():
            self._insert(table, rows)

    def overview(self) -> Answer:
        """Every table with its number of rows and its columns."""
        counts = {
            table: self._connection.execute(f"SELECT count(*) FROM {table}").fetchall()[0][0] for table in COLUMNS
        }
        return Answer(
            ["table", "rows", "columns"], [(table, counts[table], ", ".join(COLUMNS[table])) for table in COLUMNS]
        )

    def ask(self, query: str) -> Answer:
        """The rows of one SELECT. Raises QueryError for anything else, and for what DuckDB refuses."""
        try:
            self._seal()
            found = self._connection.execute(self._checked(query))
            return Answer([column[0] for column in found.description], found.fetchall())
        except self._error as error:
            raise _refused(error) from error

    def write(self, query: str, path: Path) -> None:
        """Write the rows of one SELECT to a Parquet file. Raises QueryError as `ask` does."""
        with replacing(path) as temporary:
            # DuckDB would name this file and not `path` where it cannot be written.
            temporary.touch()
            temporary.unlink()
            try:
                self._seal(temporary)
                self._connection.sql(self._checked(query)).write_parquet(str(temporary))
            except self._error as error:
                raise _refused(error) from error

    def _checked(self, query: str) -> str:
        statements = self._connection.extract_statements(query)
        if len(statements) != 1 or statements[0].type not in self._kinds:
            raise _refused("give one SELECT: a query reads, it changes nothing")
        return query

    def _seal(self, *allowed: Path) -> None:
        """Close the connection, for good, to all but the files to be written."""
        paths = ", ".join("'" + str(path.absolute()).replace("'", "''") + "'" for path in allowed)
        self._connection.execute(f"SET allowed_paths = [{paths}]")
        for setting, value in SEALED.items():
            self._connection.execute(f"SET {setting} = {value}")

    def _insert(self, table: str, rows: list[Row]) -> None:
        """Columns as lists: hundreds of times as fast as row by row."""
        if rows:
            columns = [list(column) for column in zip(*rows, strict=True)]
            listed = ", ".join(f"unnest(${i}::{kind}[])" for i, kind in enumerate(COLUMNS[table].values(), 1))
            self._connection.execute(f"INSERT INTO {table} SELECT {listed}", columns)


def describe_tables() -> str:
    """Every table with its columns, a line each."""
    return "\n".join(f"{table}({', '.join(columns)})" for table, columns in COLUMNS.items())


def _refused(error: object) -> QueryError:
    return QueryError(f"{error}\nthe tables are\n{describe_tables()}")


def _plain(value: Any) -> Any:
    if isinstance(value, Decimal):
        value = float(value)
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, dict):
        return {str(key): _plain(each) for key, each in value.items()}
    return value if isinstance(value, int | str) or value is None else str(value)
