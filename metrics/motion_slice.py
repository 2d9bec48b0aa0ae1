"""The motion-plane slice: the error's energy by spatial frequency along the motion and by temporal frequency.

A picture moving rigidly by v px a frame lies on w = -k.v, its aliases of order n on w = -(k + n).v (Watson & Ahumada
1983). Along the motion, k = s v/|v|, these are straight lines of one slope, -|v|. Spectra are taken from a slab of
SLAB / L cycles/px to both sides of that direction, of sampled tiles, under a Hann window over time.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from metrics.levels import rows_of
from metrics.measurement import Context
from metrics.spans import Span
from metrics.spectra import Batch
from metrics.tiles import Level

SLAB = 1.5
"""Half the slab's thickness in bins of 1/L cycles/px: the bins that the window spreads a frequency over."""

SHORTEST, LONGEST = 16, 64
"""Frames of a span that are needed, and that are looked at, at most."""

STEPS = 32
"""Steps of the temporal frequency in a cycle a frame."""

Frequencies = NDArray[np.float64]
Places = NDArray[np.intp]


class SliceFound(NamedTuple):
    """The slab's energy [frequencies, bins] in a part of a span.

    screen: its temporal frequency, cycles a frame. columns: of each bin, k in 1/size cycles/px. weight: sum of w^2.
    """

    size: int
    screen: Frequencies
    columns: Places
    energy: NDArray[np.float64]
    weight: float


class MotionSlice:
    """Collects the error's locked spectra along the motion; the measure of motion planes feeds it."""

    def __init__(self, context: Context) -> None:
        moving = context.velocity is not None and any(context.velocity)
        self._velocity = context.velocity if moving and context.has_reference else None
        self._found: dict[int, NDArray[np.float64]] = {}
        self._weight: dict[int, float] = {}

    def held(self, level: Level) -> float:
        if self._velocity is None:
            return 0.0
        return 24.0 * LONGEST * int(level.sample.sum()) * len(_slab(level.size, self._velocity)[1])

    def begin(self, span: Span) -> None:
        self._level = None
        if self._velocity is None or not span.levels or span.count < SHORTEST:
            return
        self._level, self._start = span.levels[0], span.start
        self._bins, self._along = _slab(self._level.size, self._velocity)
        self._rank = np.concatenate([[0], np.cumsum(self._level.sample)])
        shape = (int(self._rank[-1]), min(span.count, LONGEST), 3, len(self._along))
        self._seen = np.zeros(shape, dtype=np.complex64)
        self._energy = 0.0

    def add(self, batch: Batch) -> None:
        if batch.level != 0 or self._level is None or batch.error is None:
            return
        here = slice(self._rank[batch.tiles.start], self._rank[batch.tiles.stop])
        index = batch.frame - self._start
        if here.start < here.stop and index < self._seen.shape[1]:
            self._energy = batch.weight
            chosen = np.flatnonzero(self._level.sample[batch.tiles])
            flat = batch.error.reshape(*batch.error.shape[:2], -1)
            self._seen[here, index] = flat[chosen[:, None, None], np.arange(3)[:, None], self._bins]

    def end(self) -> SliceFound | None:
        if self._level is None or self._velocity is None or not len(self._seen):
            return None
        tiles, count = self._seen.shape[:2]
        hann = np.sin(np.pi * (np.arange(count) + 0.5) / count) ** 2
        turned = fft.fft(self._seen * hann.astype(np.float32)[:, None, None], axis=1, overwrite_x=True)
        energy = (turned.real**2 + turned.imag**2).sum(axis=(0, 2), dtype=np.float64) / np.sum(hann**2)
        # A bin against the motion stands for its opposite: -k, -w.
        forward = np.where(self._along < 0, -1.0, 1.0)
        locked = np.fft.fftfreq(count)[:, None] * forward
        screen = locked - np.abs(self._along) * np.hypot(*self._velocity)
        size = self._level.size
        columns = np.rint(np.abs(self._along) * size).astype(int)
        return SliceFound(size, screen, columns, energy, 3 * tiles * count * self._energy)

    def take(self, found: SliceFound | None) -> None:
        """Add what was found in the next part."""
        if found is None:
            return
        picture = self._found.setdefault(found.size, np.zeros((STEPS, found.size // 2 + 1)))
        _spread(picture, found.screen, found.columns, found.energy)
        self._weight[found.size] = self._weight.get(found.size, 0.0) + found.weight

    def curve(self) -> dict[str, list[object]] | None:
        """The slice, in decibels to 1 radiance^2 of mean squared error; None where there is none.

        k: cycles/px along the motion, one a column. w: cycles a frame on the screen, one a row. velocity: px a frame.
        """
        if not self._weight or self._velocity is None:
            return None
        size = max(self._weight)
        return {
            "k": [float(column) / size for column in range(size // 2 + 1)],
            "w": [row / STEPS - 0.5 for row in range(STEPS)],
            "velocity": list(self._velocity),
            "level": list(rows_of(self._found[size] / self._weight[size])),
        }


@lru_cache(maxsize=8)
def _slab(size: int, velocity: tuple[float, float]) -> tuple[Places, Frequencies]:
    """Which of a half plane's bins are in the slab, and their frequency along the motion, cycles/px."""
    down, right = np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :]
    speed = np.hypot(*velocity)
    along = (right * velocity[0] + down * velocity[1]) / speed
    across = (down * velocity[0] - right * velocity[1]) / speed
    inside = np.flatnonzero((np.abs(across) <= SLAB / size) & (np.rint(np.abs(along) * size) <= size // 2))
    return inside, along.ravel()[inside]


def _spread(picture: NDArray[np.float64], screen: Frequencies, columns: Places, energy: NDArray[np.float64]) -> None:
    """Add energies [frequencies, bins] to the two rows next to their temporal frequency."""
    place = (screen + 0.5) * STEPS
    low = np.floor(place).astype(int)
    across = np.broadcast_to(columns, place.shape)
    np.add.at(picture, (low % STEPS, across), energy * (low + 1 - place))
    np.add.at(picture, ((low + 1) % STEPS, across), energy * (place - low))
