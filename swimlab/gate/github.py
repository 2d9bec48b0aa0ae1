"""The outcome of a gate as GitHub shows it: a step summary in Markdown, and annotations."""

from collections.abc import Iterator

from swimlab.gate.outcome import Outcome
from swimlab.gate.table import explain, number, of_base, remarks

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
    said = [f"- {_cell(line)}" for line in remarks(outcome.checks)]
    paste = (
        ["", "To switch off scores that are not available:", "```toml", outcome.paste, "```"] if outcome.paste else []
    )
    return "\n".join([*lines, "", *said, *paste, ""]) + "\n"


def annotations(outcome: Outcome) -> Iterator[str]:
    """A workflow command for each check that did not pass, or that warns; they name the gate file."""
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
