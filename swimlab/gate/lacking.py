"""Scores that a run does not have: why, and the rules that switch them off."""

import json
from collections.abc import Collection, Iterable
from difflib import get_close_matches
from fnmatch import fnmatchcase

from metrics import METRICS
from swimlab.gate.rules import Cell
from swimlab.runs.entries import Entry


def may_lack(metric: str, entry: Entry) -> bool:
    """Whether a metric names an existing score or a pattern that matches one, so that it is no typing error."""
    return any(fnmatchcase(name, metric) for name in (*METRICS, *entry.scores, *entry.absent))


def why_lacking(metric: str, entry: Entry) -> str:
    """Why an entry has no score of this name, or none to judge that matches this pattern."""
    if not may_lack(metric, entry):
        near = get_close_matches(metric, {*METRICS, *entry.scores})
        guess = (
            f"did you mean {' or '.join(map(repr, near))}?" if near else "`swimlab list metrics` names all there are"
        )
        return f"is no score that has been measured; {guess}"
    if metric in entry.absent:
        what = f"is absent: {entry.absent[metric]}"
    elif metric in METRICS:
        what = "has not been measured"
    else:
        reasons = {reason for name, reason in entry.absent.items() if fnmatchcase(name, metric)}
        if any(fnmatchcase(name, metric) for name in entry.scores):
            reasons.add("mere information is judged by a rule of its full name alone")
        what = f"matches nothing to judge: {'; '.join(sorted(reasons)) or 'none of it has been measured'}"
    return f"{what}; if it has to be so, switch it off with a rule"


def rules_off(lacking: Iterable[Cell], spoken_of: Collection[Cell]) -> str:
    """A [[rule]] table for each score of a sequence that is lacking; empty where none is.

    spoken_of: all that the gate speaks of: a technique is named only where others of the sequence do have the score.
    """
    techniques: dict[tuple[str, str], list[str]] = {}
    for sequence, technique, metric in lacking:
        techniques.setdefault((sequence, metric), []).append(technique)
    tables = []
    for (sequence, metric), found in techniques.items():
        all_lack_it = set(found) >= {technique for one, technique, _ in spoken_of if one == sequence}
        tables += [_table(sequence, technique, metric) for technique in (["*"] if all_lack_it else found)]
    return "\n".join(tables)


def _table(sequence: str, technique: str, metric: str) -> str:
    keys = {"sequence": sequence, "technique": technique, "metric": metric, "level": "off"}
    # TOML spells a string as JSON does.
    spelt = {key: json.dumps(value, ensure_ascii=False) for key, value in keys.items()}
    lines = [f"{key} = {value}" for key, value in spelt.items() if (key, value) != ("technique", '"*"')]
    return "\n".join(["[[rule]]", *lines])
