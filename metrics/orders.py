"""Alias orders n = (nx, ny) of a uniform motion: which of them time can distinguish."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

HIGHEST = 2
"""Orders up to this one, either way, are separated."""

RAISED = 20.0
"""Noise of one order may be raised this much by its neighbours (diagonal of the inverse Gram matrix)."""

# Temporal frequencies nearer than this are the same, cycles a frame.
_SAME = 1e-6

_RIDGE = 1e-10

# Frames multiplied at a time: BLAS shares larger products out to threads, in other bits for every number of them.
_FRAMES = 100

# Groups named in a message.
_LISTED = 3

Order = tuple[int, int]


def rank(order: Order) -> int:
    """How far an order is from the picture itself, |n|_inf."""
    return max(abs(order[0]), abs(order[1]))


@dataclass(frozen=True)
class Orders:
    """Groups of orders that share a temporal frequency n.v (mod 1)."""

    velocity: tuple[float, float]
    groups: list[list[Order]]
    notes: list[str] = field(default_factory=list)

    @property
    def single(self) -> list[Order]:
        """One order, the lowest, for every group."""
        return [group[0] for group in self.groups]

    def opposite(self) -> list[int]:
        """For every group the index of the group of the orders -n."""
        place = {order: index for index, group in enumerate(self.groups) for order in group}
        return [place[-x, -y] for x, y in self.single]

    def basis(self, count: int) -> NDArray[np.complex128]:
        """[count, groups], exp(-2 pi i n.v t): how each order's locked spectrum turns with time."""
        frequency = np.array(self.single, dtype=float) @ np.array(self.velocity)
        return np.asarray(np.exp(-2j * np.pi * np.arange(count)[:, None] * frequency[None, :]))

    def gram(self, count: int) -> NDArray[np.complex128]:
        """Gram matrix of the basis, with a trace of a ridge so that it can be inverted always."""
        basis = self.basis(count)
        some = [basis[first : first + _FRAMES] for first in range(0, count, _FRAMES)]
        products = sum(np.conj(part).T @ part for part in some)
        return np.asarray(products + count * _RIDGE * np.eye(basis.shape[1]))

    def raised(self, count: int) -> NDArray[np.float64]:
        """[groups], by how much a fit to so many frames raises the energy of noise in each order, 1 and more."""
        return np.asarray(count * np.real(np.diag(np.linalg.inv(self.gram(count)))))

    def blurred(self, count: int) -> set[Order]:
        """Orders whose fit to so many frames would raise noise too much."""
        raised = self.raised(count)
        return {order for order, much in zip(self.single, raised, strict=True) if much > RAISED}

    def why_not(self, level: int) -> str:
        """Why the share of a rank cannot be measured, naming the orders; empty if it can."""
        mixed = [g for g in self.groups if {rank(n) for n in g} >= {level} and len({rank(n) for n in g}) > 1]
        if not mixed:
            return ""
        return (
            f"at {_words(self.velocity)} px a frame these orders look the same: {_listed(mixed)}; choose another "
            "motion, such as (23/32, 19/32)"
        )


def separate(velocity: tuple[float, float]) -> Orders:
    """Group the orders by temporal frequency for a motion (dx, dy), px a frame.

    Along an axis in which nothing moves aliases cannot be seen: orders are separated along the other axis only.
    """
    spread = range(-HIGHEST, HIGHEST + 1)
    axes = [spread if speed else range(1) for speed in velocity]
    groups: list[list[Order]] = []
    for order in sorted(product(axes[0], axes[1]), key=lambda n: (rank(n), n)):
        for group in groups:
            gap = float(np.dot(np.subtract(order, group[0]), velocity))
            if abs(gap - round(gap)) < _SAME:
                group.append(order)
                break
        else:
            groups.append([order])
    return Orders(velocity, groups, list(_notes(velocity, groups)))


def _words(velocity: tuple[float, float]) -> str:
    return f"({velocity[0]:g}, {velocity[1]:g})"


def _notes(velocity: tuple[float, float], groups: list[list[Order]]) -> Iterator[str]:
    for axis, speed in zip("xy", velocity, strict=True):
        if speed == 0 and any(velocity):
            yield f"nothing moves along {axis}: aliases along it are hidden and count as on the plane"
    alike = [group for group in groups if len(group) > 1]
    if alike:
        yield f"orders that look the same at {_words(velocity)} px a frame: {_listed(alike)}"


def _listed(groups: list[list[Order]]) -> str:
    """Orders of the first few groups."""
    words = "; ".join(" and ".join(str(order) for order in group) for group in groups[:_LISTED])
    return words + (f" and {len(groups) - _LISTED} more such groups" if len(groups) > _LISTED else "")
