"""The configurations of a sweep: every sequence under every combination of the grid's values."""

import hashlib
import json
import re
from collections.abc import Mapping
from itertools import product
from typing import Any

from sequences import load
from sequences.problems import SequenceError
from swimlab.render.catalogue import brdf_settings, technique_settings
from swimlab.render.plan import Plan, check_samples, parse_frames
from swimlab.runs.record import RunError
from swimlab.sweep.file import Sweep, SweepError, check

LONGEST_NAME = 100


def configurations(sweep: Sweep) -> list[Plan]:
    """What to render, a plan for each sequence and combination; a plan's sequence is named after what is varied.

    Raises SweepError with every problem of the file and of every combination at once.
    """
    between = check(sweep)
    problems: dict[str, None] = dict.fromkeys(between)
    plans: dict[str, Plan] = {}
    for source, varied in points(sweep):
        try:
            plan = _plan(sweep, source, varied)
            if plan.sequence.name in plans and not between:
                problems[f"sequences: two are named {plan.sequence.name!r}; give one of them another name"] = None
            plans[plan.sequence.name] = plan
        except SequenceError as error:
            problems |= dict.fromkeys(error.problems)
        except RunError as error:
            problems[str(error).removeprefix("--")] = None
    if problems:
        raise SweepError("\n".join(f"{sweep.path}: {problem}" for problem in problems))
    return list(plans.values())


def points(sweep: Sweep) -> list[tuple[str, dict[str, Any]]]:
    """Each configuration's sequence, as the sweep names it, and value of each varied key; in the order of the plans."""
    combinations = [dict(zip(sweep.grid, values, strict=True)) for values in product(*sweep.grid.values())]
    return [(source, varied) for source in sweep.sequences for varied in combinations]


def short(key: str) -> str:
    """The last two parts of a dotted key."""
    return ".".join(key.split(".")[-2:])


def _plan(sweep: Sweep, source: str, varied: Mapping[str, Any]) -> Plan:
    changes = {"size": list(sweep.size)} if sweep.size is not None else {}
    sequence = load(
        sweep.place(source),
        technique_settings=technique_settings(),
        brdfs=brdf_settings(),
        changes=changes | dict(varied),
    )
    return Plan(
        sequence=sequence.with_changes(name=name_of(sequence.name, varied)),
        techniques=sweep.names(),
        frames=parse_frames(f"0-{sequence.frames - 1}" if sweep.frames is None else sweep.frames, sequence.frames),
        samples=check_samples(sweep.samples),
    )


def name_of(sequence: str, varied: Mapping[str, Any]) -> str:
    """A configuration's name: the sequence's, and the last two parts of each varied key with its value.

    Where that is too long or a value cannot stand in a file's name, the end is a hash of all values.
    """
    if not varied:
        return sequence
    keys = [short(key) for key in varied]
    values = [value if isinstance(value, str) else json.dumps(value, default=str) for value in varied.values()]
    name = "_".join([sequence, *(f"{key}-{value}" for key, value in zip(keys, values, strict=True))])
    if len(name) <= LONGEST_NAME and len(set(keys)) == len(keys) and re.fullmatch(r"[A-Za-z0-9._-]+", name):
        return name
    digest = hashlib.sha256(json.dumps(dict(varied), sort_keys=True, default=str).encode()).hexdigest()[:10]
    return f"{sequence[: LONGEST_NAME - 11]}-{digest}"
