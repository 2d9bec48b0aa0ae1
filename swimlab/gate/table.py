"""The outcome of a gate as a table in the terminal."""

from collections.abc import Sequence
from io import StringIO

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from swimlab.gate.judge import Check
from swimlab.gate.outcome import Outcome

STYLES = {"pass": "green", "warn": "yellow", "fail": "bold red", "unjudged": "bold red"}
WIDTH = 120


def print_table(outcome: Outcome, console: Console | None = None) -> None:
    """Print every check, why each that did not pass did not, rules that may mend that, and the verdict."""
    console = console or Console(width=max(Console().width, WIDTH))
    table = Table("", "sequence", "technique", "score", box=box.SIMPLE_HEAD)
    for heading in ("value", "limit", "baseline", "sigma"):
        table.add_column(heading, justify="right")
    for check in outcome.checks:
        cells = (
            check.sequence,
            check.technique,
            check.metric,
            number(check.value),
            check.limit or "-",
            *of_base(check),
        )
        table.add_row(Text(check.status, style=STYLES[check.status]), *map(Text, cells))
    console.print(table)
    for line in remarks(outcome.checks):
        console.print(Text(line), soft_wrap=True)
    if outcome.paste:
        console.print(
            Text(f"\nto switch off scores that are not available, add at the end of {outcome.gate}:"), soft_wrap=True
        )
        console.print(Text(outcome.paste + "\n"), soft_wrap=True)
    console.print(Text(outcome.verdict), soft_wrap=True)


def table_text(outcome: Outcome) -> str:
    """The same as plain text."""
    text = StringIO()
    print_table(outcome, Console(width=WIDTH, file=text))
    return text.getvalue()


def remarks(checks: Sequence[Check]) -> list[str]:
    """A line for each check that says something: its score, the reason and where it is worst."""
    return [f"{check.status}: {check.name}: {explain(check)}" for check in checks if explain(check)]


def explain(check: Check) -> str:
    """Why a check did not pass, by which rule, and where it is worst; empty where there is nothing to say."""
    words = [check.reason] if check.reason else []
    words += [check.evidence.describe()] if check.evidence is not None else []
    return "; ".join([*words, f"rule {check.rule}"]) if words else ""


def number(value: float | None) -> str:
    """Four significant digits; "-" for none."""
    return "-" if value is None else f"{value:.4g}"


def of_base(check: Check) -> tuple[str, str]:
    """The baseline's value and its spread over runs; "?" where one run leaves that unknown."""
    if check.base is None:
        return "-", "-"
    return number(check.base), "?" if check.sigma is None else number(check.sigma)
