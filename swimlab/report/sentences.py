"""The sentences of a verdict: a technique against another, its numbers, its rivals, and what to beware of."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from swimlab.report.charts import number
from swimlab.report.weighing import AS_GOOD, Tested, as_good_for_its_time, calm_but_wrong, seen
from swimlab.runs.entries import flat

TOLD = 2
"""How many techniques that look calm but are wrong are given with numbers; the others are only named."""

SLIGHTLY = 1.1
"""A ratio of errors below which no number is given."""


def lead(best: Tested, nearest: Tested, yardstick: Tested | None, *, resolved: bool, clips: int) -> str:
    """The best and the nearest, both against the yardstick if there is one.

    resolved: whether the closest differs from the best by more than chance. clips: how many were measured.
    """
    told = (
        f"{best.name} is the best for its time: rms error {number(best.error)} in {number(best.time or 0.0)} ms a frame"
    )
    if yardstick is not None and best is not yardstick:
        told += f", {_against(best, yardstick)}"
    if best is nearest:
        return f"{told}. Nothing here measured closer to the reference."
    if not resolved:
        ratio = best.error / nearest.error if nearest.error else math.inf
        times = "slightly" if ratio < SLIGHTLY else f"{ratio:.2g} times" if math.isfinite(ratio) else "infinitely"
        here = "this clip" if clips == 1 else "these clips"
        return f"{told}. {nearest.name} measured {times} nearer on {here}; other content may differ."
    other = best if yardstick is None or nearest is yardstick else yardstick
    return f"{told}. {nearest.name} has {_against(nearest, other)}."


def _against(one: Tested, other: Tested) -> str:
    """As "62% less error than pixel-aniso in 1.06 times its time"."""
    told = _less(one.error, other.error) + f" than {other.name}"
    return told + (f" in {number(one.time / other.time)} times its time" if one.time and other.time else "")


def _less(one: float, other: float) -> str:
    if not other:
        return "no less error" if not one else "more error"
    share = 100 * abs(1 - one / other)
    digits = 1 if share < 1 or 95 < share < 100 else 0
    return f"{share:.{digits}f}% {'less' if one <= other else 'more'} error"


def facts_of(one: Tested, yardstick: Tested | None) -> list[tuple[str, str]]:
    """Its numbers (what, value), as far as they are known."""
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


def about(one: Tested, close: Sequence[Tested]) -> list[str]:
    """Techniques from which its error is not resolved, by whether they took more or less time."""
    slower = [t for t in close if t.time and one.time and t.time >= one.time]
    faster = [t for t in close if t.time and one.time and t.time < one.time]
    unknown = [t for t in close if t not in slower and t not in faster]
    alike = "Its error is not resolved from that of"
    notes = [f"{alike} {names_of(faster)}, in less time: the cheaper choice if that is enough."] if faster else []
    notes += [f"{alike} {names_of(slower)}, which took longer."] if slower else []
    return notes + ([f"{alike} {names_of(unknown)}."] if unknown else [])


def rivals(best: Tested, tested: Sequence[Tested], close: Sequence[Tested]) -> list[str]:
    """What may be taken in place of the best: close is what its error is not resolved from."""
    good = as_good_for_its_time(best, tested)
    same = [t for t in good if t in close and _as_fast(t, best)]
    rest = [t for t in good if t not in close]
    notes = []
    if same:
        verb, choice = ("is", "either") if len(same) == 1 else ("are", "any of them")
        notes.append(
            f"{names_of(same)} {verb} as good, and as fast within what times may be off by ({AS_GOOD - 1:.0%}): "
            f"{choice} will do."
        )
    notes += about(best, [t for t in close if t not in same])
    if rest:
        notes.append(
            f"Within {AS_GOOD - 1:.0%} by the same rule, no more than times of one run may be off by: {names_of(rest)}."
        )
    return notes


def _as_fast(one: Tested, other: Tested) -> bool:
    times = one.time or 0.0, other.time or 0.0
    return max(times) <= AS_GOOD * min(times)


def warnings_of(pick: Tested, tested: Sequence[Tested]) -> list[str]:
    """What flickers no more than the pick but is wrong."""
    what = "flicker" if pick.visible is None else "visible flicker"
    wrong = calm_but_wrong(pick, tested)
    return [
        f"{one.name} looks calm but is wrong: {what} {number(seen(one, pick) or 0.0)} "
        f"({pick.name} {number(seen(pick, pick) or 0.0)}), but {number(one.error)} rms error"
        + (f", {one.error / pick.error:.2g} times as much." if pick.error else ".")
        for one in wrong[:TOLD]
    ] + ([f"The same holds for {names_of(wrong[TOLD:])}."] if wrong[TOLD:] else [])


def other_settings(names: Iterable[str], settings: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Which techniques have other settings under one name, and what differs.

    settings: sequence -> technique -> its settings.
    """
    told = []
    for name in names:
        by_sequence = {sequence: dict(flat(mine[name])) for sequence, mine in settings.items() if name in mine}
        keys = dict.fromkeys(key for each in by_sequence.values() for key in each)
        unlike = [
            _values(key, by_sequence) for key in keys if len({repr(e.get(key)) for e in by_sequence.values()}) > 1
        ]
        if unlike:
            told.append(
                f"{name} has not the same settings in all that is weighed here ({'; '.join(unlike)}): its means are "
                "over different things. Report one run at a time for a verdict on each."
            )
    return told


def _values(key: str, by_sequence: Mapping[str, Mapping[str, Any]]) -> str:
    """As "size 256 on road-a, 512 on road-b and road-c"."""
    places: dict[str, list[str]] = {}
    for sequence, mine in by_sequence.items():
        places.setdefault(str(mine.get(key, "not set")), []).append(sequence)
    return f"{key} " + ", ".join(f"{value} on {listed(some)}" for value, some in places.items())


def names_of(tested: Sequence[Tested]) -> str:
    """Their names in words."""
    return listed(one.name for one in tested)


def notes_of(entries: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """The notes of a sequence's entries -> the techniques that each is of, "" where it is of all."""
    of: dict[str, list[str]] = {}
    for entry in entries:
        for note in dict.fromkeys(entry.get("notes", [])):
            of.setdefault(note, []).append(entry["technique"])
    return {note: "" if len(names) == len(entries) else listed(names) for note, names in of.items()}


def listed(names: Iterable[str]) -> str:
    """Names in words."""
    *some, last = list(names)
    return f"{', '.join(some)} and {last}" if some else str(last)
