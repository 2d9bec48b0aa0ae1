"""The outcome of a gate as a table in the terminal, as JUnit XML, and for GitHub."""

import re
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree

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
    for line in remarks(outcome):
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


def remarks(outcome: Outcome) -> list[str]:
    """A line for each warning, and for each check that says something: its score, the reason and where it is worst."""
    said = [f"{check.status}: {check.name}: {explain(check)}" for check in outcome.checks if explain(check)]
    return [*(f"warning: {text}" for text in outcome.warnings), *said]


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


ILLEGAL = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot hold."""


def junit(outcome: Outcome) -> str:
    """A test suite with a test case a score: what is beyond its limit is a failure, what cannot be judged an error.

    Warnings are the suite's standard error.
    """
    failures = sum(check.status == "fail" for check in outcome.checks)
    errors = sum(check.status == "unjudged" for check in outcome.checks)
    counts = {"tests": str(len(outcome.checks)), "failures": str(failures), "errors": str(errors)}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": _clean(str(outcome.gate)), **counts})
    for check in outcome.checks:
        case = ElementTree.SubElement(
            suite,
            "testcase",
            {"classname": _clean(f"{check.sequence}.{check.technique}"), "name": _clean(check.metric)},
        )
        why = _clean(explain(check))
        tag = {"fail": "failure", "unjudged": "error"}.get(check.status)
        if tag:
            ElementTree.SubElement(case, tag, {"message": why}).text = why
        base, sigma = of_base(check)
        said = f"value {number(check.value)}, limit {check.limit or '-'}, baseline {base}, sigma {sigma}"
        ElementTree.SubElement(case, "system-out").text = _clean(
            f"{check.status}: {said}" + (f"\n{why}" if why else "")
        )
    if outcome.warnings:
        ElementTree.SubElement(suite, "system-err").text = _clean("\n".join(f"warning: {t}" for t in outcome.warnings))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def junit_error(gate: Path, message: str) -> str:
    """A test suite with one error, for a gate that could not be run."""
    counts = {"tests": "1", "failures": "0", "errors": "1"}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": _clean(str(gate)), **counts})
    case = ElementTree.SubElement(suite, "testcase", {"classname": "swimlab", "name": "gate"})
    ElementTree.SubElement(case, "error", {"message": _clean(message)}).text = _clean(message)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _clean(text: str) -> str:
    return ILLEGAL.sub("?", text)


SIGNS = {"pass": "✅", "warn": "⚠️", "fail": "❌", "unjudged": "❌"}
LEVELS = {"warn": "warning", "fail": "error", "unjudged": "error"}


def summary(outcome: Outcome) -> str:
    """A Markdown table of every check, and what there is to say of them."""
    lines = [f"### {_cell(outcome.verdict)}", ""]
    lines += ["| | sequence | technique | score | value | limit | baseline | sigma |", "|-|-|-|-|-:|-:|-:|-:|"]
    for check in outcome.checks:
        cells = [f"{SIGNS[check.status]} {check.status}", check.sequence, check.technique, check.metric]
        cells += [number(check.value), check.limit or "-", *of_base(check)]
        lines.append("| " + " | ".join(map(_cell, cells)) + " |")
    said = [f"- {_cell(line)}" for line in remarks(outcome)]
    paste = (
        ["", "To switch off scores that are not available:", "```toml", outcome.paste, "```"] if outcome.paste else []
    )
    return "\n".join([*lines, "", *said, *paste, ""]) + "\n"


def annotations(outcome: Outcome) -> Iterator[str]:
    """A workflow command for each warning, and each check that did not pass or warns; they name the gate file."""
    for text in outcome.warnings:
        yield f"::warning file={_property(str(outcome.gate))},title=swimlab gate::{_data(text)}"
    for check in outcome.checks:
        if check.status in LEVELS:
            place = f"file={_property(str(outcome.gate))},title={_property('swimlab gate: ' + check.name)}"
            yield f"::{LEVELS[check.status]} {place}::{_data(explain(check))}"


def _cell(text: str) -> str:
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("\n", " ")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
