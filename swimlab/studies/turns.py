"""Times of tasks that take turns, so that what else the machine does disturbs all of them equally."""

import random
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import median
from typing import NamedTuple

from metrics.machine import waited
from swimlab.studies.trials import Stage, Variant


class Time(NamedTuple):
    """Milliseconds by the clock, and of all cores together; and those that threads were ready and had no core."""

    wall: float
    cpu: float
    waited: float = 0.0


Task = Callable[[int], Callable[[], object]]
"""Prepares, for a turn, what is then timed."""


def frame_task(stage: Stage, variant: Variant) -> Task:
    """Rendering one frame, the next of the sequence each turn. What all techniques share is made before: maps, mesh."""
    render = variant.begin()

    def prepare(turn: int) -> Callable[[], object]:
        shot = stage.shot(stage.frames[0] + turn)
        _ = shot.triangles
        return lambda: render(shot)

    return prepare


def clip_task(stage: Stage, variant: Variant) -> Task:
    """Rendering all frames of a stage from the beginning, mesh included."""
    return lambda _: lambda: stage.pictures(variant)


def in_turns(tasks: Mapping[str, Task], rounds: int) -> dict[str, list[Time]]:
    """Times of each task in each round, in an order that is shuffled, after a round that compiles and is not counted.

    The shuffle is the same each time.
    """
    times: dict[str, list[Time]] = {label: [] for label in tasks}
    order, shuffle = list(tasks), random.Random(0).shuffle
    for turn in range(rounds + 1):
        shuffle(order)
        for label in order:
            run = tasks[label](turn)
            before = waited()
            wall, cpu = time.perf_counter(), time.process_time()
            run()
            wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
            if turn:
                times[label].append(Time(1e3 * wall, 1e3 * cpu, 1e3 * (waited() - before)))
    return times


def share(times: Iterable[Sequence[Time]], cores: int) -> float:
    """Of what some cores could have given while tasks were timed, what the tasks got."""
    flat = [time for each in times for time in each]
    return sum(time.cpu for time in flat) / (cores * sum(time.wall for time in flat))


def wall(times: Sequence[Time]) -> float:
    """Median milliseconds by the clock."""
    return median(time.wall for time in times)


def cpu(times: Sequence[Time]) -> float:
    """Median milliseconds of all cores together."""
    return median(time.cpu for time in times)
