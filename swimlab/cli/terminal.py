"""Tables on standard output."""

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

WIDEST = 10_000


def print_whole(table: Table) -> None:
    """Print a table on standard output, as wide as its cells are: a terminal may wrap a row, a file does not."""
    console = Console()
    needed = Measurement.get(console, console.options.update(max_width=WIDEST), table).maximum
    console.width = max(console.width, needed)
    console.print(table, crop=False)
