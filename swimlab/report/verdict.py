"""The verdict: which technique to ship and what it costs, over all sequences of a page together.

A rule of one sentence picks by error and time. Differences that the numbers do not resolve are named.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from swimlab.report.charts import number
from swimlab.report.sentences import (
    about,
    facts_of,
    lead,
    listed,
    names_of,
    other_settings,
    rivals,
    warnings_of,
)
from swimlab.report.weighing import (
    SCORE,
    WRONG,
    Entries,
    Entry,
    Tested,
    best_for_its_time,
    nearest_of,
    nearest_sparkles,
    sparkles,
    unresolved_from,
    weigh,
)
from swimlab.runs.record import REFERENCE

YARDSTICK = "pixel-aniso"
"""What engines do. The times and errors of other techniques are given as multiples of its own."""

NEAREST, BEST, FASTEST = "Closest to the reference", "Best for its time", "Fastest"
RULE = (
    "Nearest has the least rms error, fastest the least time a frame, and best for its time the "
    "least product of both, so that half the error is worth twice the time, among what does not sparkle: most of its "
    f"squared error is flicker, which is {WRONG:g} times the nearest's error or more; the nearest sparkles where "
    "most of its own is, beyond the reference's error. Calm but wrong is what flickers "
    f"no more than the best for its time and errs {WRONG:g} times as much or more."
)
TIMES = "Times are this run's, on the machine that rendered it, one technique after another."


class Pick(NamedTuple):
    """A choice: why, which technique, its numbers (what, value), and what to know about it."""

    title: str
    name: str
    facts: list[tuple[str, str]]
    notes: list[str]


@dataclass
class Verdict:
    """What the page says first.

    lead: one sentence or two. warnings: what looks calm but is wrong, and what should not have been weighed together.
    notes: where it holds. rule: how it was chosen.
    """

    lead: str
    picks: list[Pick] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    rule: str = ""


def verdict(
    entries: Sequence[Entry],
    milliseconds: Mapping[str, Mapping[str, float]],
    settings: Mapping[str, Mapping[str, Any]] | None = None,
) -> Verdict:
    """Weigh all techniques but the reference.

    entries: of scores.json. milliseconds: sequence -> technique -> ms a frame, what is known. settings: sequence ->
    technique -> its settings; where they differ from one sequence to another, the first warning says so.
    """
    tests = [entry for entry in entries if entry["technique"] != REFERENCE]
    by_sequence: dict[str, dict[str, Entry]] = {}
    for entry in tests:
        if SCORE in entry["scores"]:
            by_sequence.setdefault(entry["sequence"], {})[entry["technique"]] = entry
    if not by_sequence:
        return Verdict(_without_errors(tests))
    shared = set.intersection(*(set(mine) for mine in by_sequence.values()))
    names = [name for name in next(iter(by_sequence.values())) if name in shared]
    if not names:
        return Verdict(f"Nothing was measured in every one of {listed(by_sequence)}: there is nothing to weigh.")
    tested = [weigh(name, by_sequence, milliseconds) for name in names]
    if len(tested) > 1:
        told = _weighed(tested, by_sequence)
        told.notes += _where(told, names, by_sequence, milliseconds) + _sizes([p.name for p in told.picks[:2]], tests)
    else:
        told = _alone(tested[0])
    known = {sequence: (settings or {}).get(sequence, {}) for sequence in by_sequence}
    told.warnings[:0] = other_settings([*names, REFERENCE], known)
    left = sorted({name for mine in by_sequence.values() for name in mine} - shared)
    if left:
        told.notes.append(f"Left out, for they are not in every sequence: {listed(left)}.")
    if any("budget.floor" not in entry["scores"] for mine in by_sequence.values() for entry in mine.values()):
        told.notes.append("The reference's own error is not known: small differences may be its.")
    return told


def _weighed(tested: Sequence[Tested], by_sequence: Entries) -> Verdict:
    yardstick = next((t for t in tested if t.name == YARDSTICK), None)
    nearest, best = nearest_of(tested), best_for_its_time(tested)
    timed = [t for t in tested if t.time]
    close = unresolved_from(nearest, tested, by_sequence)
    near = Pick(NEAREST, nearest.name, facts_of(nearest, yardstick), _sparkle(nearest, nearest) + about(nearest, close))
    if best is None or len(timed) < 2:
        told = Verdict(
            f"{nearest.name} is closest to the reference: rms error {number(nearest.error)}. What it costs cannot be "
            "said: no times of a frame are known.",
            [near],
        )
        told.warnings = warnings_of(nearest, tested)
    else:
        fastest = min(timed, key=lambda t: t.time or math.inf)
        close = unresolved_from(best, tested, by_sequence)
        told = Verdict(
            lead(best, nearest, yardstick, resolved=nearest not in close, clips=len(by_sequence)),
            [
                Pick(BEST, best.name, facts_of(best, yardstick), _sparkle(best, nearest) + rivals(best, tested, close)),
                near,
                Pick(FASTEST, fastest.name, facts_of(fastest, yardstick), _sparkle(fastest, nearest)),
            ],
            warnings_of(best, tested),
            rule=f"{RULE} {TIMES}",
        )
        if len(timed) < len(tested):
            told.notes.append(f"No time is known for {names_of([t for t in tested if not t.time])}.")
    return told


def _sparkle(one: Tested, nearest: Tested) -> list[str]:
    """A warning where a choice sparkles; of the nearest, which errs least, where its own error mostly flickers."""
    found = nearest_sparkles(one) if one is nearest else sparkles(one, nearest)
    return ["It sparkles: most of its error is flicker."] if found else []


def _alone(only: Tested) -> Verdict:
    told = ", ".join(f"{what} {value}" for what, value in facts_of(only, None))
    return Verdict(f"Only {only.name} was measured, so there is nothing to choose from: {told}.")


def _without_errors(tests: Sequence[Entry]) -> str:
    calm = [entry for entry in tests if "residual.flicker" in entry["scores"]]
    if any("scale.rmse" in entry["scores"] for entry in tests):
        least = min(
            (entry for entry in tests if "scale.rmse" in entry["scores"]),
            key=lambda e: float(e["scores"]["scale.rmse"]),
        )
        return (
            f"{least['technique']} depends least on the picture's size: scale error "
            f"{number(least['scores']['scale.rmse'])}. Frames in motion were not measured: which to ship cannot be "
            "said from this alone."
        )
    if calm:
        least = min(calm, key=lambda e: float(e["scores"]["residual.flicker"]))
        return (
            f"{least['technique']} changes least on the surface: rms "
            f"{number(math.sqrt(max(0.0, least['scores']['residual.flicker'])))}. Without a reference nobody can say "
            "which is true: calm may be wrong."
        )
    return "No error is known: measure the frames against a reference for a verdict."


def _where(
    told: Verdict, names: Sequence[str], by_sequence: Entries, milliseconds: Mapping[str, Mapping[str, float]]
) -> list[str]:
    """Whether each sequence by itself would pick the same."""
    if len(by_sequence) < 2:
        return [f"Said of {next(iter(by_sequence))} alone; other content may rank otherwise."]
    picks = {pick.title: pick.name for pick in told.picks}
    notes = []
    for sequence, mine in by_sequence.items():
        here = [weigh(name, {sequence: mine}, milliseconds) for name in names]
        best, nearest = best_for_its_time(here), nearest_of(here)
        if best is not None and picks.get(BEST, best.name) != best.name:
            notes.append(f"On {sequence} by itself {best.name} is best for its time.")
        if nearest.name != picks[NEAREST]:
            notes.append(f"On {sequence} by itself {nearest.name} is nearest.")
    return [f"Means over {listed(by_sequence)}" + ("." if notes else "; each by itself picks the same."), *notes]


def _sizes(picks: Sequence[str], tests: Sequence[Entry]) -> list[str]:
    """How the picks do where pictures are resized."""
    resized: dict[str, dict[str, float]] = {}
    for entry in tests:
        if "scale.rmse" in entry["scores"]:
            resized.setdefault(entry["sequence"], {})[entry["technique"]] = float(entry["scores"]["scale.rmse"])
    notes = []
    for sequence, errors in resized.items():
        order = sorted(errors, key=lambda name: errors[name])
        placed = [
            f"{name} is {order.index(name) + 1} of {len(order)} ({number(errors[name])})"
            for name in dict.fromkeys(picks)
            if name in errors
        ]
        if placed:
            least = "" if order[0] in picks else f", {order[0]} the least ({number(errors[order[0]])})"
            notes.append(f"Independence of size on {sequence}, by scale error: {listed(placed)}{least}.")
    return notes
