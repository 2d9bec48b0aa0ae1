"""Scores that are ratios of sums over tiles, and how far chance may have moved them."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from metrics.tiles import window

Values = NDArray[np.float64]

SIGMAS = 2.0
"""A difference must be so many combined standard errors wide to be resolved."""


class Ratios:
    """Sums over tiles of some parts and of a weight; every part over the weight is a score.

    The standard error is the spread of the tiles about the ratio (Cochran 1977, eq. 6.9), with the variance raised
    for the overlap of neighbours. It says how much the score would change on another piece of such a surface.
    """

    def __init__(self) -> None:
        self._parts: dict[str, Values] = {}
        self._tiles = 0
        self._weight = np.zeros(2)

    def add(self, size: int, weight: Values, parts: Mapping[str, Values]) -> None:
        """Take in tiles of one size, each with its weight [n] and parts [n]."""
        raised = overlap(size)
        self._tiles += len(weight)
        self._weight += [weight.sum(), raised * (weight @ weight)]
        for name, part in parts.items():
            sums = np.array([part.sum(), raised * (part @ part), raised * (part @ weight)])
            self._parts[name] = self._parts.get(name, np.zeros(3)) + sums

    @property
    def weight(self) -> float:
        return float(self._weight[0])

    def value(self, part: str) -> float:
        """The ratio; the weight must be above 0."""
        return float(self._parts[part][0] / self.weight)

    def error(self, part: str) -> float | None:
        """The ratio's standard error, or None for a single tile."""
        if self._tiles < 2:
            return None
        _, squared, crossed = self._parts[part]
        ratio = self.value(part)
        spread = squared - 2 * ratio * crossed + ratio**2 * self._weight[1]
        return float(np.sqrt(max(0.0, spread) * self._tiles / (self._tiles - 1)) / self.weight)


@lru_cache(maxsize=8)
def overlap(size: int) -> float:
    """By how much half-overlapping neighbours raise the variance of a mean over tiles.

    The energies of a white noise in two tiles correlate as their squared windows do: 1 + 2 rho along each axis.
    """
    square = window(size, 0.0) ** 2
    shared = float(square[size // 2 :] @ square[: size // 2])
    return (1 + 2 * shared / float(square @ square)) ** 2


def resolved(score: str, one: Mapping[str, Mapping[str, float]], other: Mapping[str, Mapping[str, float]]) -> bool:
    """Whether two measurements differ in a score by more than chance and the reference's own error explain.

    one, other: entries of scores.json, or vars(Measurement): "scores" and "errors" by name. A difference must be
    more than SIGMAS combined standard errors, and for a `budget` score more than the larger `budget.floor` of the
    same band. Where a standard error is not known nothing is resolved. Raises KeyError if either lacks the score.
    """
    difference = abs(one["scores"][score] - other["scores"][score])
    errors = [entry.get("errors", {}).get(score) for entry in (one, other)]
    known = [error for error in errors if error is not None]
    if len(known) < len(errors):
        return False
    family, _, band = score.partition(".")
    floor = 0.0
    if family == "budget":
        name = ".".join(["budget.floor", *band.split(".")[1:]])
        floor = max(entry["scores"].get(name, 0.0) for entry in (one, other))
    return difference > max(SIGMAS * float(np.linalg.norm(known)), floor)
