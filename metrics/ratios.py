"""Scores that are ratios of sums over tiles, and how far chance may have moved them."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrics.tiles import window

Values = NDArray[np.float64]
Entry = Mapping[str, Any]

SIGMAS = 2.0
"""A difference must be so many of its standard errors wide to be resolved."""

BLOCKS, RUN, FEWEST = 16, 8, 4
"""Blocks of tiles that are left out in turn, runs of tiles in the order of rows being dealt out to them; with fewer
blocks that hold any tile there is no jackknife."""

# Tiles whose products are summed at a time.
_PIECE = 8192


class Ratios:
    """Sums over tiles of some parts and of a weight; every part over the weight is a score.

    The standard error is the spread of the tiles about the ratio (Cochran 1977, eq. 6.9), with the variance raised
    for the overlap of neighbours. It says how much the score would change on another piece of the same kind of surface.
    """

    def __init__(self) -> None:
        self._parts: dict[str, Values] = {}
        self._tiles = 0
        self._weight = np.zeros(2)
        self._blocks: dict[str, Values] = {}
        self._block_weight = np.zeros(BLOCKS)
        self._seen: dict[int, int] = {}

    def add(self, size: int, weight: Values, parts: Mapping[str, Values]) -> None:
        """Take in tiles of one size, each with its weight [n] and parts [n]."""
        raised = overlap(size)
        self._tiles += len(weight)
        self._weight += [weight.sum(), raised * _dot(weight, weight)]
        first = self._seen.get(size, 0)
        self._seen[size] = first + len(weight)
        block = np.arange(first, first + len(weight)) // RUN % BLOCKS
        self._block_weight += np.bincount(block, weight, BLOCKS)
        for name, part in parts.items():
            self._blocks[name] = self._blocks.get(name, np.zeros(BLOCKS)) + np.bincount(block, part, BLOCKS)
            sums = np.array([part.sum(), raised * _dot(part, part), raised * _dot(part, weight)])
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

    def replicates(self, part: str) -> list[float]:
        """The ratio with one block of tiles left out at a time, for `jackknife`; empty where there are too few."""
        held = np.flatnonzero(self._block_weight)
        if len(held) < FEWEST:
            return []
        left = self._parts[part][0] - self._blocks[part][held]
        return [float(each) for each in left / (self.weight - self._block_weight[held])]


def _dot(one: Values, other: Values) -> float:
    """one @ other, in pieces: BLAS shares long vectors out to threads, in other bits for every number of them."""
    pieces = (slice(first, first + _PIECE) for first in range(0, len(one), _PIECE))
    return float(sum(one[piece] @ other[piece] for piece in pieces))


def jackknife(replicates: Sequence[float] | Values) -> float:
    """The standard error of what is found again with each of some blocks left out (Efron & Stein 1981, eq. 1.3)."""
    return float(np.sqrt((len(replicates) - 1) * np.var(replicates)))


@lru_cache(maxsize=8)
def overlap(size: int) -> float:
    """By how much half-overlapping neighbours raise the variance of a mean over tiles.

    The energies of a white noise in two tiles correlate as their squared windows do: 1 + 2 rho along each axis.
    """
    square = window(size, 0.0) ** 2
    shared = float(square[size // 2 :] @ square[: size // 2])
    return (1 + 2 * shared / float(square @ square)) ** 2


def difference_error(score: str, one: Entry, other: Entry) -> float | None:
    """The standard error of a score's difference between two measurements; None where it is not known.

    one, other: entries of scores.json, or vars(Measurement), with the score. Where both left out the same blocks, what
    a piece of the surface does to both cancels: energies grow equally with its light, so their ratio is
    compared with 1, by the spread of its logarithm. Scores that are not all above 0 are subtracted, and without the
    same blocks both errors are combined.
    """
    pair = [entry.get("replicates", {}).get(score, []) for entry in (one, other)]
    if pair[0] and len(pair[0]) == len(pair[1]):
        values = [entry["scores"][score] for entry in (one, other)]
        if min(*values, *pair[0], *pair[1]) <= 0:
            return jackknife(np.subtract(*pair))
        return logarithmic_mean(*values) * jackknife(np.log(np.divide(*pair)))
    errors = [entry.get("errors", {}).get(score) for entry in (one, other)]
    return None if None in errors else float(np.hypot(*errors))


def logarithmic_mean(one: float, other: float) -> float:
    """(a - b) / log(a / b) of numbers above 0: what a small difference of logarithms is in units of the numbers."""
    ratio = one / other
    return one if abs(ratio - 1) < 1e-9 else (one - other) / float(np.log(ratio))


def resolved(score: str, one: Entry, other: Entry) -> bool:
    """Whether two measurements differ in a score by more than chance and the reference's own error explain.

    one, other: as for `difference_error`, with "scores". A difference must be more than SIGMAS of its standard errors,
    and for a `budget` score more than the larger `budget.floor` of the same band. Where the standard error is not known
    nothing is resolved. Raises KeyError if either lacks the score.
    """
    error = difference_error(score, one, other)
    floor = reference_floor(score, one["scores"], other["scores"])
    return error is not None and abs(one["scores"][score] - other["scores"][score]) > max(SIGMAS * error, floor)


def reference_floor(score: str, one: Mapping[str, float], other: Mapping[str, float]) -> float:
    """The reference's own error in a `budget` score of two measurements: the larger `budget.floor` of the same band.

    0 for other scores, which do not have it, and where it is not known.
    """
    family, _, band = score.partition(".")
    if family != "budget":
        return 0.0
    name = ".".join(["budget.floor", *band.split(".")[1:]])
    return max(scores.get(name, 0.0) for scores in (one, other))
