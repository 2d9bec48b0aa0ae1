"""Motion planes: how much of the picture moves with the surface, and how much is an alias of it.

The spectrum of a picture moving rigidly by v px a frame lies on w + k.v = 0 (Watson & Ahumada 1983; Adelson & Bergen
1985). Point sampling folds a frequency K to k = K - n; aliases of order n lie on w + (k + n).v = 0 (mod 1). In a
surface-locked spectrum order n therefore stands at the temporal frequency -n.v for *every* k. The 25 orders up to 2
apart are fitted there by least squares; what is left is off every plane. The mean level of each tile is removed
first. Fractions are of the spectral energy, over all spatial frequencies, and add up to 1.

T frames tell at most T temporal frequencies apart: a pure noise puts 1 / T of its energy on each order, listed as
`chance` beside the energies of single orders.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from metrics.measurement import Context, Measurement, Metric
from metrics.orders import Order, Orders, rank, separate
from metrics.spans import Span
from metrics.spectra import Batch, energy
from metrics.tiles import Level

# Projections are kept for all orders, so tiles are few: none overlap, and no more than these.
TILES = 96
FRAMES = 8

_SOURCE = "Watson & Ahumada 1983, NASA TM-84352; least squares at the frequencies -n.v"

SCORES = {
    "plane.on": Metric("1", "higher", "share of the energy that moves with the surface", _SOURCE),
    "plane.order1": Metric("1", "lower", "share of aliases of the first order", _SOURCE),
    "plane.order2": Metric("1", "lower", "share of aliases of the second order", _SOURCE),
    "plane.off": Metric("1", "lower", "share off every plane: noise, blinking, higher orders", _SOURCE),
}
RANKS = {"plane.on": 0, "plane.order1": 1, "plane.order2": 2}


class Plane:
    """Projections of the test's locked spectra on the temporal frequency of every order."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._orders = None if context.velocity is None else separate(context.velocity)
        self._energy: dict[Order, float] = {}
        self._off = 0.0
        self._blurred: set[Order] = set()
        self._chance = 0.0

    def begin(self, span: Span) -> None:
        self._level = None
        if self._orders is None or not span.levels or span.count <= len(self._orders.groups):
            return
        self._level = span.levels[0]
        self._start, self._count = span.start, span.count
        self._basis = self._orders.basis(span.count)
        self._chosen = _apart(self._level)
        shape = (len(self._chosen), 3, *self._level.spectrum_shape)
        self._level_spectrum = np.zeros(self._level.spectrum_shape, dtype=np.complex128)
        self._first = np.zeros(shape[:2])
        self._rest = np.zeros(shape[:2])
        self._held = np.zeros((FRAMES, *shape), dtype=np.complex64)
        self._fitted = np.zeros((self._basis.shape[1], *shape), dtype=np.complex64)
        self._total = np.zeros(shape[:2])

    def add(self, batch: Batch) -> None:
        if batch.level != 0 or self._level is None:
            return
        index = batch.frame - self._start
        here = np.flatnonzero((self._chosen >= batch.tiles.start) & (self._chosen < batch.tiles.stop))
        spectra = batch.test[self._chosen[here] - batch.tiles.start]
        mean = batch.mean[self._chosen[here] - batch.tiles.start]
        if index == 0:
            self._level_spectrum = batch.level_spectrum
            self._first[here] = mean
        self._rest[here] += (mean - self._first[here]) / self._count
        level = self._first[here][:, :, None, None] * batch.level_spectrum
        varied = spectra - level
        self._total[here] += energy(varied)
        self._held[index % FRAMES, here] = varied
        if batch.tiles.stop == self._level.count and (index % FRAMES == FRAMES - 1 or index == self._count - 1):
            self._project(index)

    def _project(self, last: int) -> None:
        """Add the frames held to the projections on every order."""
        first = last - last % FRAMES
        rows = np.conj(self._basis[first : last + 1]).T.astype(np.complex64)
        held = self._held[: last - first + 1].reshape(last - first + 1, -1)
        self._fitted += (rows @ held).reshape(self._fitted.shape)

    def end(self) -> None:
        if self._level is None or self._orders is None:
            return
        projections, total = self._without_mean(self._orders)
        inverse = np.linalg.inv(self._orders.gram(self._count))
        self._blurred |= self._orders.blurred(self._count)
        self._chance = max(self._chance, 1 / self._count)
        flat = projections.reshape(len(projections), -1)
        # Re(a* P) of the least-squares amplitudes a: exact for orders apart, unbiased for noise, sums to the fit.
        explained = np.real(np.einsum("ni,ni->n", np.conj(inverse @ flat), flat))
        # The stored half plane holds one of k, order n, and -k, order -n: both have the same energy.
        both = (explained + explained[self._orders.opposite()]) / 2
        for order, value in zip(self._orders.single, both, strict=True):
            self._energy[order] = self._energy.get(order, 0.0) + float(value)
        self._off += max(0.0, total - float(explained.sum()))

    def _without_mean(self, orders: Orders) -> tuple[NDArray[np.complex128], float]:
        """Projections and total energy with each tile's mean level over the span removed.

        The first frame's level went out already; the rest is linear. Order 0 is the sum over frames.
        """
        fitted = self._fitted.astype(np.complex128)
        sums = fitted[orders.single.index((0, 0))]
        shape = self._rest[:, :, None, None] * self._level_spectrum
        total = self._total.sum() - 2 * np.real(np.vdot(shape, sums)) + self._count * energy(shape).sum()
        weights = np.conj(self._basis).sum(axis=0)
        fitted -= weights[:, None, None, None, None] * shape
        return fitted, float(total)

    def finish(self) -> Measurement:
        found = Measurement()
        reason = self._reason()
        if self._orders is None or reason:
            found.absent = dict.fromkeys(SCORES, reason)
            return found
        total = sum(self._energy.values()) + self._off
        found.notes += self._orders.notes
        found.curves["plane.orders"] = {
            "order": [f"{x},{y}" for x, y in self._energy],
            "energy": [value / total for value in self._energy.values()],
            "chance": [self._chance] * len(self._energy),
        }
        for name, level in RANKS.items():
            members = [order for order in self._energy if rank(order) == level]
            why = self._orders.why_not(level) or _too_short(self._blurred.intersection(members))
            share = max(0.0, sum(self._energy[order] for order in members) / total)
            found.put(name, None if why else share, why)
        why = _too_short(self._blurred)
        found.put("plane.off", None if why else self._off / total, why)
        return found

    def _reason(self) -> str:
        """Why no score can be had; empty if some can."""
        if self._orders is None:
            return "needs a motion that is uniform over the picture and in time"
        if not any(self._orders.velocity):
            return "nothing moves, so aliases look as the surface does"
        if not self._energy:
            return f"needs tiles that stay wholly covered for more than {len(self._orders.groups)} frames"
        if sum(self._energy.values()) + self._off <= 0:
            return "the picture is flat"
        return ""


def _too_short(orders: Iterable[Order]) -> str:
    """Why orders too near to each other for the clip's length cannot be told apart."""
    names = ", ".join(str(order) for order in sorted(orders))
    return f"too few frames to tell orders {names} apart" if names else ""


def _apart(level: Level) -> NDArray[np.intp]:
    """Indices of tiles that do not overlap, at most TILES of them, spread evenly."""
    step = (level.origin - level.origin.min(axis=0)) // (level.size // 2)
    apart = np.flatnonzero((step % 2 == 0).all(axis=1))
    return np.asarray(apart[np.linspace(0, len(apart) - 1, min(TILES, len(apart))).round().astype(int)])


MEASURE = Plane
