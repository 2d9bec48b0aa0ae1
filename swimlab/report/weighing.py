"""Weighing techniques: their means over sequences, which is the best for its time, and which only look good."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from metrics.ratios import resolved

Entry = Mapping[str, Any]
Entries = Mapping[str, Mapping[str, Entry]]
"""Sequence -> technique -> entry of scores.json."""

WRONG = 2.0
"""A technique is wrong if its error is at least so many times that of the pick."""


@dataclass(frozen=True)
class Tested:
    """A technique over all sequences: rms error and flicker, visible flicker (means), and ms a frame if known."""

    name: str
    error: float
    flicker: float | None
    visible: float | None
    time: float | None


def weigh(name: str, by_sequence: Entries, milliseconds: Mapping[str, Mapping[str, float]]) -> Tested:
    """A technique's means over all sequences; what is not known in one of them is not known."""
    scores = [mine[name]["scores"] for mine in by_sequence.values()]
    times = [milliseconds.get(sequence, {}).get(name) for sequence in by_sequence]
    return Tested(
        name,
        math.sqrt(max(0.0, _mean([each["budget.mse"] for each in scores]) or 0.0)),
        _root(_mean([each.get("budget.flicker") for each in scores])),
        _mean([each.get("visible.flicker") for each in scores]),
        _mean(times),
    )


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if len(known) == len(values) and known else None


def _root(value: float | None) -> float | None:
    return None if value is None else math.sqrt(max(0.0, value))


def nearest_of(tested: Sequence[Tested]) -> Tested:
    """The least error."""
    return min(tested, key=lambda t: t.error)


def best_for_its_time(tested: Sequence[Tested]) -> Tested | None:
    """The least product of error and time, among those that do not sparkle if there are any; None without times."""
    timed = [one for one in tested if one.time]
    calm = [one for one in timed if not sparkles(one, nearest_of(tested))]
    return min(calm or timed, key=lambda t: (t.error * (t.time or 0.0), t.error), default=None)


def sparkles(one: Tested, nearest: Tested) -> bool:
    """Whether most of its squared error is flicker, and that is WRONG times what the nearest errs in all."""
    return one.flicker is not None and one.flicker**2 > one.error**2 / 2 and one.flicker >= WRONG * nearest.error


def unresolved_from(one: Tested, others: Sequence[Tested], by_sequence: Entries) -> list[Tested]:
    """Which others an error is not told from in some sequence."""
    return [
        other
        for other in others
        if other is not one
        and any(not resolved("budget.mse", mine[one.name], mine[other.name]) for mine in by_sequence.values())
        and other.error < WRONG * one.error
    ]


def calm_but_wrong(pick: Tested, tested: Sequence[Tested]) -> list[Tested]:
    """Which flicker no more than the pick, to the eye if that is known, but err WRONG times as much; worst first."""
    limit = seen(pick, pick)
    if limit is None:
        return []
    calm = [one for one in tested if one is not pick and (mine := seen(one, pick)) is not None and mine <= limit]
    return sorted((one for one in calm if one.error >= WRONG * pick.error), key=lambda one: -one.error)


def seen(one: Tested, pick: Tested) -> float | None:
    """Its visible flicker if the pick's is known, else its rms flicker."""
    return one.flicker if pick.visible is None else one.visible
