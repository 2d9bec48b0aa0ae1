"""Comparisons as tables in the terminal."""

from collections.abc import Sequence
from itertools import groupby
from math import isinf
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from metrics import METRICS
from swimlab.cli.terminal import print_whole
from swimlab.compare.change import BY_ERRORS, Change
from swimlab.compare.history import Outlook, spark
from swimlab.compare.runs import Against, Comparison, tally
from swimlab.gate.outputs import number
from swimlab.runs.counting import counted

STYLES = {"better": "green", "worse": "bold red", "changed": "yellow", "unknown": "yellow", "gone": "yellow"}
KINDS = {"settings": "OTHER SETTINGS", "names": "other names", "versions": "other versions"}
WHY = {"gone": "", "new": ", before"}
UNLIKE = "*"


def print_comparison(comparison: Comparison) -> None:
    """Print a table a sequence, the runs side by side; then what differs beside scores, and what chance would do."""
    console = Console()
    names = [f"#{index}" for index in range(1, len(comparison.runs) + 1)]
    console.print(Text(f"base: {comparison.base}"), soft_wrap=True)
    for name, run in zip(names, comparison.runs, strict=True):
        console.print(Text(f"{name}: {run.run}"), soft_wrap=True)
    rows: dict[tuple[str, str, str], dict[str, Change]] = {}
    for name, run in zip(names, comparison.runs, strict=True):
        for change in run.changes:
            rows.setdefault((change.sequence, change.technique, change.metric), {})[name] = change
    moved = {key: row for key, row in rows.items() if any(change.verdict != "same" for change in row.values())}
    for sequence, keys in groupby(moved, key=lambda key: key[0]):
        table = Table("technique", "score", "unit", title=sequence, title_justify="left", box=box.SIMPLE_HEAD)
        table.add_column("base", justify="right")
        for name in names:
            for heading in (name, "change", "%", "σ"):
                table.add_column(heading, justify="right", no_wrap=True)
            table.add_column("", no_wrap=True)
        for key in keys:
            row = moved[key]
            before = next(iter(row.values())).before
            cells = [cell for name in names for cell in _cells(row.get(name))]
            table.add_row(key[1], key[2], _unit(key[2]), number(before), *cells)
        print_whole(table)
    for name, run in zip(names, comparison.runs, strict=True):
        for line in _remarks(run, comparison.threshold):
            console.print(Text(f"{name}: {line}"), soft_wrap=True)
    console.print(_legend(), soft_wrap=True)


def print_outlook(outlook: Outlook, threshold: float) -> None:
    """Print the scores that moved since the last run of the same settings, with their trend."""
    console = Console()
    moved = [trend for trend in outlook.trends if trend.change.verdict != "same" or len(set(trend.values)) > 1]
    for sequence, trends in groupby(moved, key=lambda trend: trend.change.sequence):
        table = Table("technique", "score", "unit", title=sequence, title_justify="left", box=box.SIMPLE_HEAD)
        for heading in ("last", "now", "change", "%", "σ"):
            table.add_column(heading, justify="right", no_wrap=True)
        for heading in ("", "by", "trend"):
            table.add_column(heading, no_wrap=True)
        for trend in trends:
            change = trend.change
            row = (change.technique, change.metric, _unit(change.metric), number(change.before))
            table.add_row(*row, *_cells(change), change.by, spark(trend.values) if trend.values else "")
        print_whole(table)
    for key, others in outlook.first.items():
        earlier = f", {others} of others" if others else ""
        console.print(Text(f"{key[1]} on {key[0]}: no earlier run of the same settings{earlier}"), soft_wrap=True)
    if outlook.trends:
        since = ", ".join(dict.fromkeys(trend.since.name for trend in outlook.trends))
        console.print(Text(f"last: {since}"), soft_wrap=True)
        for line in _reasons([trend.change for trend in outlook.trends]):
            console.print(Text(line), soft_wrap=True)
        console.print(Text(_counts([trend.change for trend in outlook.trends], threshold)), soft_wrap=True)
        console.print(_legend(), soft_wrap=True)
        if any(trend.change.by != BY_ERRORS for trend in outlook.trends):
            console.print(
                "spread of n runs: the distance from their mean, as Student's t, told as the standard errors that are "
                "as improbable.",
                soft_wrap=True,
            )


def _cells(change: Change | None) -> tuple[str | Text, ...]:
    if change is None:
        return "", "", "", "", ""
    absolute = "-" if change.absolute is None else f"{change.absolute:+.3g}"
    share = "-" if change.relative is None else f"{change.relative:+.1%}".removesuffix("%")
    mark = "" if change.like else UNLIKE
    verdict = Text(change.verdict + mark, style=STYLES.get(change.verdict, ""))
    return number(change.after), absolute, share, _sigmas(change.sigmas), verdict


def _sigmas(value: float | None) -> str:
    if value is None:
        return "?"
    return ("+∞" if value > 0 else "-∞") if isinf(value) else f"{value:+.1f}"


def _unit(metric: str) -> str:
    return METRICS[metric].unit if metric in METRICS else ""


def _remarks(run: Against, threshold: float) -> list[str]:
    lines = []
    for sequence, found in run.differences.items():
        for kind, heading in KINDS.items():
            of_kind = [str(difference) for difference in found if difference.kind == kind]
            if of_kind:
                lines.append(f"{sequence}: {heading}: {'; '.join(of_kind)}")
    for where, words in (("base", "only in the base"), ("run", "not in the base")):
        keys = sorted(key for key, place in run.only.items() if place == where)
        names = [f"{name} ({', '.join(key[1] for key in group)})" for name, group in groupby(keys, lambda key: key[0])]
        lines += [f"{words}: {', '.join(names)}"] if names else []
    lines += _reasons(run.changes)
    return [*lines, _counts(run.changes, threshold)]


def _reasons(changes: Sequence[Change]) -> list[str]:
    """Why scores came or went, and how many have no standard error."""
    found: dict[tuple[str, str, str, str], list[str]] = {}
    for change in changes:
        if change.verdict in ("gone", "new"):
            why = change.sequence, change.metric, change.verdict, change.reason
            found.setdefault(why, []).append(change.technique)
    lines = [
        f"{sequence}: {metric} is {verdict} ({', '.join(techniques)}){WHY[verdict]}: {reason}"
        for (sequence, metric, verdict, reason), techniques in found.items()
    ]
    unknown = sum(change.verdict == "unknown" for change in changes)
    if unknown:
        lines.append(f"{counted(unknown, 'changed score')} without a standard error: whether by chance is unknown")
    return lines


def _counts(changes: Sequence[Change], threshold: float) -> str:
    counts: dict[str, Any] = tally(changes, threshold)
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts["verdicts"].items())
    return (
        f"{counted(len(changes), 'score')}: {verdicts}. "
        f"Beyond {threshold:g} σ: {counts['beyond']} of {counts['compared']}; "
        f"chance alone would bring {counts['expected_by_chance']:.2g}."
    )


def _legend() -> Text:
    return Text(
        "σ: the change in its standard errors, which tell how far it would move on another piece of such a surface. "
        f"{UNLIKE}: of other settings."
    )
