"""A long build measured by parts: opened and planned once, looked at anywhere, joined to the same entry."""

from collections.abc import Iterable
from itertools import accumulate
from typing import Any, NamedTuple

from metrics import Measuring
from metrics.plan import Plan
from metrics.totals import Found
from swimlab.footage.subject import Subject
from swimlab.scoring.footage import entry_of_build, rounding_of
from swimlab.scoring.score import with_others


class Part(NamedTuple):
    """Spans first..last-1 of a plan, and the numbers of the first and the last of their frames."""

    first: int
    last: int
    frames: tuple[int, int]


class Planned(NamedTuple):
    """A build that is opened, and its plan, cut in parts. It can be pickled."""

    subject: Subject
    plan: Plan
    parts: tuple[Part, ...]


def plan_build(subject: Subject, *, least: int, threads: int | None) -> Planned | None:
    """Cut a build in parts of `least` frames or more; None where that leaves it whole."""
    if len(subject.kept) < 2 * least:
        return None
    plan = _measuring(subject, threads).plan()
    numbers = [subject.test.reader.numbers[index] for index in subject.kept]
    parts = tuple(
        Part(first, last, (numbers[plan.bounds[first][0]], numbers[plan.bounds[last - 1][1] - 1]))
        for first, last in runs([stop - start for start, stop in plan.bounds], least)
    )
    return Planned(subject, plan, parts) if len(parts) > 1 else None


def runs(lengths: Iterable[int], least: int) -> list[tuple[int, int]]:
    """Runs first..last-1 of what has these lengths, each as short as it can be and not below `least`."""
    found: list[tuple[int, int]] = []
    first = before = 0
    total = 0
    for last, total in enumerate(accumulate(lengths), start=1):
        if total - before >= least:
            found.append((first, last))
            first, before = last, total
    if total > before:
        begin, _ = found.pop() if found else (0, 0)
        found.append((begin, last))
    return found


def look_at(planned: Planned, part: Part, *, threads: int | None) -> list[Found]:
    """What there is in a part, in plain values."""
    return _measuring(planned.subject, threads).look(planned.plan, slice(part.first, part.last))


def join_parts(sequence: str, name: str, planned: Planned, found: Iterable[Found]) -> dict[str, Any]:
    """The entry of scores.json of a build by what was found in all of its parts, in their order."""
    subject = planned.subject
    joined = _measuring(subject, None).join(planned.plan, found)
    measured = with_others(joined, *subject.clips(), rounding=rounding_of(subject))
    return entry_of_build(sequence, name, subject, measured)


def _measuring(subject: Subject, threads: int | None) -> Measuring:
    request = subject.request
    return Measuring(*subject.clips(), domain=request.domain, display=request.display, threads=threads)
