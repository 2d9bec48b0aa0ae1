"""The verdict: which technique to ship and what it costs, over all sequences of a page together.

A rule that can be said in a sentence picks from errors and times; whatever the numbers do not resolve is said so.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from swimlab.record import REFERENCE
from swimlab.report.charts import number
from swimlab.report.weighing import (
    WRONG,
    Entries,
    Entry,
    Tested,
    best_for_its_time,
    calm_but_wrong,
    nearest_of,
    seen,
    sparkles,
    unresolved_from,
    weigh,
)

YARDSTICK = "pixel-aniso"
"""What engines do: other techniques' times and errors are told as multiples of its."""

NEAREST, BEST, FASTEST = "Nearest to the truth", "Best for its time", "Fastest"
RULE = (
    "How this was chosen: nearest has the least rms error, fastest the least time a frame, and best for its time the "
    "least product of both, so that half the error is worth twice the time, among what does not sparkle: most of its "
    f"squared error is flicker, which is {WRONG:g} times the nearest's error or more. Calm but wrong is what flickers "
    f"no more than the best for its time and errs {WRONG:g} times as much or more."
)
TIMES = "Times are this run's, on the machine that rendered it, one technique after another."


TOLD = 2
"""Techniques that look calm but are wrong whose numbers are told; the others are named."""


class Pick(NamedTuple):
    """A choice: why, which technique, its numbers (what, value), and what to know about it."""

    title: str
    name: str
    facts: list[tuple[str, str]]
    notes: list[str]


@dataclass
class Verdict:
    """What the page says first. lead: one sentence. warnings: what looks calm but is wrong. notes: where it holds."""

    lead: str
    picks: list[Pick] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    rule: str = ""


def verdict(entries: Sequence[Entry], milliseconds: Mapping[str, Mapping[str, float]]) -> Verdict:
    """Weigh all techniques but the reference.

    entries: of scores.json. milliseconds: sequence -> technique -> ms a frame, what is known.
    """
    tests = [entry for entry in entries if entry["technique"] != REFERENCE]
    by_sequence: dict[str, dict[str, Entry]] = {}
    for entry in tests:
        if "budget.mse" in entry["scores"]:
            by_sequence.setdefault(entry["sequence"], {})[entry["technique"]] = entry
    if not by_sequence:
        return Verdict(_without_errors(tests))
    shared = set.intersection(*(set(mine) for mine in by_sequence.values()))
    names = [name for name in next(iter(by_sequence.values())) if name in shared]
    if not names:
        return Verdict(f"No technique was measured in every one of {_listed(by_sequence)}: there is nothing to weigh.")
    tested = [weigh(name, by_sequence, milliseconds) for name in names]
    if len(tested) > 1:
        told = _weighed(tested, by_sequence)
        told.notes += _where(told, names, by_sequence, milliseconds) + _sizes([p.name for p in told.picks[:2]], tests)
    else:
        told = _alone(tested[0])
    left = sorted({name for mine in by_sequence.values() for name in mine} - shared)
    if left:
        told.notes.append(f"Left out, for they are not in every sequence: {_listed(left)}.")
    flat = next((entry for mine in by_sequence.values() for entry in mine.values()), None)
    if flat is not None and flat["scores"].get("budget.floor") is None:
        told.notes.append("The reference's own error is not known: small differences may be its.")
    return told


def _weighed(tested: Sequence[Tested], by_sequence: Entries) -> Verdict:
    yardstick = next((t for t in tested if t.name == YARDSTICK), None)
    nearest, best = nearest_of(tested), best_for_its_time(tested)
    timed = [t for t in tested if t.time]
    close = unresolved_from(nearest, tested, by_sequence)
    near = Pick(NEAREST, nearest.name, _facts(nearest, yardstick), _about(nearest, nearest, close))
    if best is None or len(timed) < 2:
        told = Verdict(
            f"{nearest.name} is nearest to the truth: rms error {number(nearest.error)}. What it costs cannot be "
            "said: no times of a frame are known.",
            [near],
        )
        told.warnings = _warnings(nearest, tested)
    else:
        fastest = min(timed, key=lambda t: t.time or math.inf)
        close = unresolved_from(best, tested, by_sequence)
        told = Verdict(
            _lead(best, best if nearest in close else nearest, yardstick),
            [
                Pick(BEST, best.name, _facts(best, yardstick), _about(best, nearest, close)),
                near,
                Pick(FASTEST, fastest.name, _facts(fastest, yardstick), _about(fastest, nearest, [])),
            ],
            _warnings(best, tested),
            rule=f"{RULE} {TIMES}",
        )
        if len(timed) < len(tested):
            told.notes.append(f"No time is known for {_listed(t.name for t in tested if not t.time)}.")
    return told


def _alone(only: Tested) -> Verdict:
    facts = _facts(only, None)
    told = ", ".join(f"{what} {value}" for what, value in facts)
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


def _lead(best: Tested, nearest: Tested, yardstick: Tested | None) -> str:
    """nearest: the best itself if nothing is told from it that errs less."""
    told = f"{best.name} is the best for its time: rms error {number(best.error)} in {_ms(best)} a frame"
    if yardstick is not None and best is not yardstick and yardstick.time:
        told += f", {_ratio(best, yardstick)}"
    if best is nearest:
        return f"{told}. Nothing here is nearer to the truth by more than the standard errors leave open."
    slower = (nearest.time or 0.0) / (best.time or math.inf)
    how = f" in {slower:.3g} times its time" if slower else ""
    closer = f"{best.error / nearest.error:.2g} times nearer to the truth" if nearest.error else "the truth itself"
    return f"{told}. {nearest.name} is {closer}{how}."


def _ratio(one: Tested, yardstick: Tested) -> str:
    told = f"{number((one.time or 0.0) / (yardstick.time or math.inf))} times {yardstick.name}'s time"
    return told + (f" for {number(one.error / yardstick.error)} of its error" if yardstick.error else "")


def _facts(one: Tested, yardstick: Tested | None) -> list[tuple[str, str]]:
    facts = [("rms error", number(one.error))]
    if one.flicker is not None:
        facts.append(("rms flicker", number(one.flicker)))
    if one.visible is not None:
        facts.append(("visible flicker", number(one.visible)))
    if one.time:
        facts.append(("ms a frame", number(one.time)))
    if one.time and yardstick is not None and yardstick.time and one is not yardstick:
        facts.append((f"× {yardstick.name}'s time", number(one.time / yardstick.time)))
    return facts


def _ms(one: Tested) -> str:
    return f"{number(one.time or 0.0)} ms"


def _about(one: Tested, nearest: Tested, close: Sequence[Tested]) -> list[str]:
    notes = ["It sparkles: most of its error is flicker."] if sparkles(one, nearest) else []
    if not close:
        return notes
    notes.append(f"Its error is not resolved from that of {_listed(t.name for t in close)}.")
    cheaper = [t for t in close if t.time and one.time and t.time < one.time]
    return notes + ([f"Of these {_listed(t.name for t in cheaper)} took less time."] if cheaper else [])


def _warnings(pick: Tested, tested: Sequence[Tested]) -> list[str]:
    what = "flicker" if pick.visible is None else "visible flicker"
    wrong = calm_but_wrong(pick, tested)
    return [
        f"{one.name} looks calm but is wrong: {what} {number(seen(one, pick) or 0.0)} "
        f"({pick.name} {number(seen(pick, pick) or 0.0)}), but {number(one.error)} rms error"
        + (f", {one.error / pick.error:.2g} times as much." if pick.error else ".")
        for one in wrong[:TOLD]
    ] + ([f"The same holds for {_listed(one.name for one in wrong[TOLD:])}."] if wrong[TOLD:] else [])


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
    return [f"Means over {_listed(by_sequence)}" + ("." if notes else "; each by itself picks the same."), *notes]


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
            notes.append(f"Independence of size on {sequence}, by scale error: {_listed(placed)}{least}.")
    return notes


def _listed(names: Any) -> str:
    """Names in words."""
    *some, last = list(names)
    return f"{', '.join(some)} and {last}" if some else str(last)
