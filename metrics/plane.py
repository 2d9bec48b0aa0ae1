"""Motion planes: how much of the picture moves with the surface, and how much is an alias of it.

The spectrum of a picture moving rigidly by v px a frame lies on w + k.v = 0 (Watson & Ahumada 1983; Adelson & Bergen
1985). Point sampling folds a frequency K to k = K - n; aliases of order n lie on w + (k + n).v = 0 (mod 1). In a
surface-locked spectrum order n therefore stands at the temporal frequency -n.v for *every* k. The 25 orders up to 2
apart are fitted there by least squares; what is left is off every plane. The mean level of each tile is removed
first. An order's energy is its squared amplitude, for which the clip's length does not matter; that orders beat
against each other in a short clip belongs to none of them. Fractions are of the sum of all these energies, over all
spatial frequencies, and add up to 1.

T frames tell at most T temporal frequencies apart: a pure noise puts 1 / T of its energy on each order, listed as
`chance` beside the energies of single orders.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics.measurement import Context, Measurement, Metric
from metrics.motion_slice import MotionSlice, SliceFound
from metrics.orders import RAISED, Order, Orders, rank, separate
from metrics.ratios import Ratios
from metrics.spans import Span
from metrics.spectra import Batch
from metrics.tiles import Level
from metrics.transform import energy

Complex = NDArray[np.complex128]

# Frames whose spectra are projected together. Projections are kept for all orders, of sampled tiles only.
FRAMES = 8

# A picture whose energy beside its mean level is less is flat: single precision leaves 1e-14.
FLAT = 1e-12

_SOURCE = "Watson & Ahumada 1983, NASA TM-84352; least squares at the frequencies -n.v"

_SHARE = "sum over {} of |a_n|^2, over all energies; X(t) = sum_n a_n exp(-2 pi i n.v t) by least squares"
SCORES = {
    "plane.on": Metric(
        "1", "higher", "share of the energy that moves with the surface", _SOURCE, _SHARE.format("n = 0")
    ),
    "plane.order1": Metric(
        "1", "lower", "share of aliases of the first order", _SOURCE, _SHARE.format("max(|nx|, |ny|) = 1")
    ),
    "plane.order2": Metric(
        "1", "lower", "share of aliases of the second order", _SOURCE, _SHARE.format("max(|nx|, |ny|) = 2")
    ),
    "plane.off": Metric(
        "1", "lower", "share off every plane: noise, blinking, higher orders", _SOURCE, "1 - on - order1 - order2"
    ),
}
RANKS = {"plane.on": 0, "plane.order1": 1, "plane.order2": 2}


class OrdersFound(NamedTuple):
    """Energies of the sampled tiles of a part of a span of so many frames.

    size: of the tiles, px. orders: [n, orders]. off: [n], off every plane. level: of the mean level, all tiles.
    """

    size: int
    frames: int
    orders: NDArray[np.float64]
    off: NDArray[np.float64]
    level: float


class Plane:
    """Projections of the test's locked spectra on the temporal frequency of every order."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._orders = None if context.velocity is None else separate(context.velocity)
        self._ratios = Ratios()
        self._blurred: set[Order] = set()
        self._chance = 0.0
        self._level_energy = 0.0
        self._slice = MotionSlice(context)

    def held(self, level: Level) -> float:
        orders = 0 if self._orders is None else len(self._orders.groups)
        return (orders + FRAMES) * level.part(level.sample).held + self._slice.held(level)

    def begin(self, span: Span) -> None:
        self._slice.begin(span)
        self._level = None
        if self._orders is None or not span.levels or span.count <= len(self._orders.groups):
            return
        self._level = span.levels[0]
        self._start, self._count = span.start, span.count
        self._basis = self._orders.basis(span.count)
        # Of every tile which of the sample it is, counted from the first.
        self._rank = np.concatenate([[0], np.cumsum(self._level.sample)])
        number, spectrum = int(self._rank[-1]), (3, *self._level.spectrum_shape)
        self._level_spectrum = np.zeros(self._level.spectrum_shape, dtype=np.complex64)
        self._first, self._rest = np.zeros((2, number, 3))
        self._total = np.zeros(number)
        self._held = np.zeros((number, FRAMES, *spectrum), dtype=np.complex64)
        self._fitted = np.zeros((number, self._basis.shape[1], *spectrum), dtype=np.complex64)

    def add(self, batch: Batch) -> None:
        self._slice.add(batch)
        if batch.level != 0 or self._level is None:
            return
        here = slice(self._rank[batch.tiles.start], self._rank[batch.tiles.stop])
        if here.start == here.stop:
            return
        chosen = self._level.sample[batch.tiles]
        index = batch.frame - self._start
        mean = batch.mean[chosen]
        if index == 0:
            self._level_spectrum = batch.level_spectrum
            self._first[here] = mean
        self._rest[here] += (mean - self._first[here]) / self._count
        varied = batch.test[chosen] - self._first[here, :, None, None].astype(np.float32) * batch.level_spectrum
        self._total[here] += energy(varied)
        self._held[here, index % FRAMES] = varied
        if index % FRAMES == FRAMES - 1 or index == self._count - 1:
            self._project(here, index)

    def _project(self, here: slice, last: int) -> None:
        """Add the frames held of some tiles to the projections on every order."""
        first = last - last % FRAMES
        rows = np.conj(self._basis[first : last + 1]).T.astype(np.complex64)
        held = self._held[here, : last - first + 1]
        for tile, frames in zip(self._fitted[here], held, strict=True):
            # Row by row: products so small that BLAS starts no threads of its own beside ours.
            tile += np.matmul(rows, frames.transpose(1, 2, 0, 3)).transpose(2, 0, 1, 3)

    def end(self) -> tuple[SliceFound | None, OrdersFound | None]:
        return self._slice.end(), self._separated()

    def _separated(self) -> OrdersFound | None:
        if self._level is None or self._orders is None or not self._level.count:
            return None
        inverse: Complex = np.asarray(np.linalg.inv(self._orders.gram(self._count)), np.complex128)
        opposite = self._orders.opposite()
        raised = self._orders.raised(self._count)
        found = np.zeros((len(self._total), len(opposite)))
        off = np.zeros(len(self._total))
        for tile in range(len(self._total)):
            projections, total = self._without_mean(tile, self._orders)
            flat = projections.reshape(len(projections), -1)
            amplitudes = self._fit(inverse, flat)
            joint = np.real(np.einsum("ni,ni->n", np.conj(amplitudes), flat))
            off[tile] = max(0.0, total - joint.sum())
            # The fit raises noise where a clip is too short to keep orders well apart: leave each the noise it has.
            noise = off[tile] / (self._count - len(flat))
            alone = self._count * np.square(np.abs(amplitudes)).sum(axis=1) + noise * (1 - raised)
            # Orders that cannot be separated have a sum only.
            each = np.where(raised > RAISED, joint, alone)
            # The stored half plane holds one of k, order n, and -k, order -n: both have the same energy.
            found[tile] = (each + each[opposite]) / 2
        level = self._count * float(np.sum(self._first**2)) * energy(self._level_spectrum[None, None])[0]
        return OrdersFound(self._level.size, self._count, found, off, level)

    def take(self, found: tuple[SliceFound | None, OrdersFound | None]) -> None:
        along, separated = found
        self._slice.take(along)
        if separated is None or self._orders is None:
            return
        size, count, each, off, level_energy = separated
        self._blurred |= self._orders.blurred(count)
        self._chance = max(self._chance, 1 / count)
        groups = np.array([rank(order) for order in self._orders.single])
        parts = {name: each[:, groups == level].sum(axis=1) for name, level in RANKS.items()}
        parts |= {f"{x},{y}": each[:, index] for index, (x, y) in enumerate(self._orders.single)}
        parts["plane.off"] = off
        self._ratios.add(size, each.sum(axis=1) + off, parts)
        self._level_energy += level_energy

    def _fit(self, inverse: Complex, flat: Complex) -> Complex:
        """inverse @ flat, [orders, bins], some bins at a time: BLAS shares no such product out to threads.

        Shared out it would be other bits for every number of them.
        """
        some = flat.reshape(len(flat), -1, self._level_spectrum.shape[0]).swapaxes(0, 1)
        return np.asarray(np.matmul(inverse, some).swapaxes(0, 1).reshape(flat.shape))

    def _without_mean(self, tile: int, orders: Orders) -> tuple[Complex, float]:
        """Projections and total energy of one sampled tile with its mean level over the span removed.

        The first frame's level went out already; the rest is linear. Order 0 is the sum over frames.
        """
        fitted = self._fitted[tile].astype(np.complex128)
        sums = fitted[orders.single.index((0, 0))]
        shape = self._rest[tile, :, None, None] * self._level_spectrum
        squared = float(np.vdot(shape, shape).real)
        total = self._total[tile] - 2 * np.real(np.vdot(shape, sums)) + self._count * squared
        weights = np.conj(self._basis).sum(axis=0)
        fitted -= weights[:, None, None, None] * shape
        return fitted, float(total)

    def finish(self) -> Measurement:
        found = Measurement()
        along = self._slice.curve()
        if along is not None:
            found.curves["plane.slice"] = along
        reason = self._reason()
        if self._orders is None or reason:
            found.absent = dict.fromkeys(SCORES, reason)
            return found
        found.notes += self._orders.notes
        single = self._orders.single
        found.curves["plane.orders"] = {
            "order": [f"{x},{y}" for x, y in single],
            "energy": [max(0.0, self._ratios.value(f"{x},{y}")) for x, y in single],
            "chance": [self._chance] * len(single),
        }
        # Chance may leave an order that is not there just below 0.
        shares = {name: max(0.0, self._ratios.value(name)) for name in SCORES}
        for name in SCORES:
            members = [order for order in single if name == "plane.off" or rank(order) == RANKS[name]]
            why = "" if name == "plane.off" else self._orders.why_not(RANKS[name])
            why = why or _too_short(self._blurred.intersection(members))
            share = None if why else shares[name] / sum(shares.values())
            found.put(name, share, why, error=self._ratios.error(name), replicates=self._ratios.replicates(name))
        return found

    def _reason(self) -> str:
        """Why no score can be measured; empty if some can."""
        if self._orders is None:
            return "needs a motion that is uniform over the picture and in time"
        if not any(self._orders.velocity):
            return "nothing moves, so aliases look as the surface does"
        if not self._chance:
            return f"needs tiles that stay wholly covered for more than {len(self._orders.groups)} frames"
        if self._ratios.weight <= FLAT * self._level_energy:
            return "the picture is flat"
        return ""


def _too_short(orders: Iterable[Order]) -> str:
    """Why the clip is too short to separate orders this near to each other."""
    names = ", ".join(str(order) for order in sorted(orders))
    return f"too few frames to tell orders {names} apart" if names else ""


MEASURE = Plane
