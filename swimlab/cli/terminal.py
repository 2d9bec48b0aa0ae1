"""Tables on standard output, progress on standard error."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count

from rich.console import Console
from rich.measure import Measurement
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

WIDEST = 10_000


def print_whole(table: Table) -> None:
    """Print a table on standard output, as wide as its cells are: a terminal may wrap a row, a file does not."""
    console = Console()
    needed = Measurement.get(console, console.options.update(max_width=WIDEST), table).maximum
    console.width = max(console.width, needed)
    console.print(table, crop=False)


@contextmanager
def progress(what: str, total: int, *, quiet: bool, verbose: bool = False) -> Iterator[Callable[[str], None]]:
    """A bar of `total` steps; call what it yields with a word on the step just done.

    verbose: a line a step in place of the bar, for logs.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[step]}"),
    )
    console = Console(stderr=True)
    hidden = quiet or verbose or not sys.stderr.isatty()
    done = count(1)

    def advance(step: str) -> None:
        bar.update(task, advance=1, step=step)
        if verbose:
            print(f"{what}: {next(done)}/{total} {step}", file=sys.stderr)

    with Progress(*columns, console=console, transient=True, disable=hidden) as bar:
        task = bar.add_task(what, total=total, step="")
        yield advance
    if not quiet:
        print(f"{what}: done", file=sys.stderr)
