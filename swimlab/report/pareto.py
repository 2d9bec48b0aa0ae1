"""What is worth having of things that cost something and err by something."""

from collections.abc import Sequence


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
