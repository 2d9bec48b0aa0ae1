"""Weighing techniques: means over sequences, the Pareto front, the best for its time, what only looks good."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from metrics.ratios import SIGMAS, difference_error, reference_floor

Entry = Mapping[str, Any]
Entries = Mapping[str, Mapping[str, Entry]]
"""Sequence -> technique -> entry of scores.json."""

SCORE = "budget.mse"
"""The squared error by which techniques are compared."""

WRONG = 2.0
"""A technique is wrong if its error is at least so many times that of the pick."""

AS_GOOD = 1.1
"""Products of error and time up to so many times the least are as good: times of one run are no surer."""


@dataclass(frozen=True)
class Tested:
    """A technique over all sequences: rms error and flicker, visible flicker (means), and ms a frame if known.

    floor: rms of the reference's own error, if known.
    """

    name: str
    error: float
    flicker: float | None
    visible: float | None
    time: float | None
    floor: float | None = None


def weigh(name: str, by_sequence: Entries, milliseconds: Mapping[str, Mapping[str, float]]) -> Tested:
    """A technique's means over all sequences; what is not known in one of them is not known."""
    scores = [mine[name]["scores"] for mine in by_sequence.values()]
    times = [milliseconds.get(sequence, {}).get(name) for sequence in by_sequence]
    return Tested(
        name,
        math.sqrt(max(0.0, _mean([each[SCORE] for each in scores]) or 0.0)),
        _root(_mean([each.get("budget.flicker") for each in scores])),
        _mean([each.get("visible.flicker") for each in scores]),
        _mean(times),
        _root(_mean([each.get("budget.floor") for each in scores])),
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
    """The technique with the least product of error and time; techniques that sparkle only if all do. None without
    times."""
    return min(_eligible(tested), key=lambda one: (_product(one), one.error), default=None)


def as_good_for_its_time(best: Tested, tested: Sequence[Tested]) -> list[Tested]:
    """Which others' product of error and time is within AS_GOOD of the best's."""
    return [one for one in _eligible(tested) if one is not best and _product(one) <= AS_GOOD * _product(best)]


def _eligible(tested: Sequence[Tested]) -> list[Tested]:
    timed = [one for one in tested if one.time]
    return [one for one in timed if not sparkles(one, nearest_of(tested))] or timed


def _product(one: Tested) -> float:
    return one.error * (one.time or 0.0)


def sparkles(one: Tested, nearest: Tested) -> bool:
    """Whether most of its squared error is flicker, and that is WRONG times what the nearest errs in all."""
    return _mostly_flicker(one) and (one.flicker or 0.0) >= WRONG * nearest.error


def nearest_sparkles(nearest: Tested) -> bool:
    """Whether most of the nearest's own squared error is flicker, and more than the reference's own error."""
    return _mostly_flicker(nearest) and (nearest.flicker or 0.0) > (nearest.floor or 0.0)


def _mostly_flicker(one: Tested) -> bool:
    return one.flicker is not None and one.flicker**2 > one.error**2 / 2


def unresolved_from(one: Tested, others: Sequence[Tested], by_sequence: Entries) -> list[Tested]:
    """Techniques whose errors are not resolved from this one, of those below WRONG times its error."""
    rivals = [other for other in others if other is not one and other.error < WRONG * one.error]
    return [other for other in rivals if not _told_apart(one.name, other.name, by_sequence)]


def _told_apart(one: str, other: str, by_sequence: Entries) -> bool:
    """Whether two means over sequences differ by more than chance and the reference's own error explain.

    As `metrics.ratios.resolved`. Sequences may show the same surface, so their standard errors are not averaged down.
    """
    pairs = [(mine[one], mine[other]) for mine in by_sequence.values()]
    error = _mean([difference_error(SCORE, *pair) for pair in pairs])
    floor = _mean([reference_floor(SCORE, a["scores"], b["scores"]) for a, b in pairs])
    difference = _mean([a["scores"][SCORE] - b["scores"][SCORE] for a, b in pairs])
    return error is not None and abs(difference or 0.0) > max(SIGMAS * error, floor or 0.0)


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


def front(points: Sequence[tuple[float, float | None]]) -> list[bool]:
    """Which points (cost, error), less is better, lie on the Pareto front: none is as good in both and better in one.

    A point without an error is not on it. Equal points are on it together.
    """
    order = sorted((error, cost, place) for place, (cost, error) in enumerate(points) if error is not None)
    held = [False] * len(points)
    cheapest: tuple[float, float] | None = None
    for error, cost, place in order:
        if cheapest is None or cost < cheapest[1] or (error, cost) == cheapest:
            cheapest = (error, cost)
            held[place] = True
    return held
