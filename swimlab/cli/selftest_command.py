"""`swimlab selftest`."""

import json
from dataclasses import asdict
from typing import Annotated

from cyclopts import Parameter
from rich import box
from rich.console import Console
from rich.table import Table

from swimlab.studies.selftest import Check, checks


def selftest_command(
    *,
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Measure clips made in memory whose scores are known, and show both. Exit code 1 if one is off.

    Parameters
    ----------
    json_output:
        Print the checks as JSON instead of a table.
    quiet:
        Show only the checks that are off.
    """
    done = list(checks())
    if json_output:
        print(json.dumps([{**asdict(check), "ok": check.good} for check in done], indent=1, allow_nan=False))
    else:
        _print_table([check for check in done if not check.good] if quiet else done)
        off = sum(not check.good for check in done)
        print(f"{len(done)} checks, all as expected" if not off else f"{len(done)} checks, {off} OFF")
    return 0 if all(check.good for check in done) else 1


def _print_table(done: list[Check]) -> None:
    table = Table("clip", "score", box=box.SIMPLE_HEAD)
    for heading in ("measured", "expected", "within", ""):
        table.add_column(heading, justify="right")
    for index, check in enumerate(done):
        again = index > 0 and done[index - 1].clip == check.clip
        table.add_row(
            "" if again else check.clip,
            check.score,
            _words(check.value),
            _words(check.expected),
            f"{check.tolerance:.2g}" if check.tolerance else "",
            "ok" if check.good else "OFF",
        )
    if done:
        Console(width=max(Console().width, 110)).print(table)


def _words(value: float | None) -> str:
    if value is None:
        return "none"
    return f"{value:.6f}" if value == 0 or abs(value) >= 1e-4 else f"{value:.1e}"
