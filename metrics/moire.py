"""Moire: energy that the test has and the reference has not, by frequency, and its peaks.

Power spectra are means over frames, channels and tiles of the largest tile size that fits (64 px as a
rule), under the tiles' own window. Bins nearer to 0 than DC_LOBE / L belong to the mean level.
A peak must be a local maximum that stands over the local floor, the median around it, by more than MIN_RATIO and
by more than chance allows: a mean of M independent periodograms of noise follows chi^2 with 2 M degrees of freedom
(Welch 1967); only tiles that do not overlap count as independent, for frames and channels may repeat each other.
Standard errors are a jackknife over upright strips of the picture (Efron & Stein 1981), the leading peak followed at
its bin and those around it.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, special

from metrics.levels import rows_of
from metrics.measurement import Context, Measurement, Metric
from metrics.parts import BATCH
from metrics.spans import Span
from metrics.spectra import Batch
from metrics.tiles import Level, window
from metrics.transform import add_power

DC_LOBE = 2.5
"""Bins that the window spreads the mean level over."""

MIN_RATIO = 4.0
"""Least ratio of a peak to its local floor: 6 dB."""

CHANCE = 1e-4
"""Probability that noise of this many tiles shows any peak."""

PEAKS = 8
_HALO = 7
_CORE = 2
_SOURCE = "Welch periodograms of surface-locked tiles"

SCORES = {
    "moire.excess": Metric(
        "1",
        "lower",
        "energy above the reference's, by radial frequency, over the reference's energy",
        _SOURCE,
        "sum over rings of max(0, P_test - P_reference), over sum of P_reference",
    ),
    "moire.peak_frequency": Metric(
        "cycles/px",
        "information",
        "frequency of the error's strongest spectral peak",
        _SOURCE,
        "|k| of the peak of P_error",
    ),
    "moire.peak_strength": Metric(
        "dB", "lower", "power of that peak over the local floor", _SOURCE, "10 log10(P_error / median around it)"
    ),
}

KINDS = ("test", "reference", "error")

# Upright strips of the picture: a road looks the same along them, not across.
STRIPS = 8

Power = NDArray[np.float64]
Peak = tuple[float, float, float]


class PowerFound(NamedTuple):
    """Of the largest tiles of a part of a span: how many each strip has, and their power by strip.

    size: of the tiles, px. part: which of the span's. frames: of the span.
    """

    size: int
    part: int
    frames: int
    tiles: dict[int, int]
    power: dict[int, Power]


class Moire:
    """Mean power spectra of the largest tiles, by upright strips of the picture, whose spread gives the errors."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._strips: dict[int, dict[int, Power]] = {}
        self._seen: dict[int, dict[int, int]] = {}
        self._tiles: dict[int, int] = {}
        self._here = 0

    def held(self, level: Level) -> float:
        # At worst every tile has a strip of its own, or every piece all strips.
        return level.held * min(1.0, STRIPS * level.size**2 / BATCH)

    def begin(self, span: Span) -> None:
        self._size = span.levels[0].size if span.levels else 0
        self._pieces: dict[int, dict[int, Power]] = {}
        if span.levels:
            level = span.levels[0]
            self._strip = ((level.origin[:, 1] + level.size / 2) * STRIPS / span.shape[1]).astype(int)
            self._frames, self._part = span.count, span.part

    def add(self, batch: Batch) -> None:
        if batch.level != 0 or batch.error is None:
            return
        present, place = np.unique(self._strip[batch.tiles], return_inverse=True)
        summed = np.zeros((len(present), len(KINDS), *batch.error.shape[2:]))
        add_power(batch.test, batch.error, place.astype(np.int32), summed)
        _add(self._pieces.setdefault(batch.piece, {}), dict(zip(present.tolist(), summed, strict=True)))

    def end(self) -> PowerFound | None:
        if not self._size:
            return None
        strips, counts = np.unique(self._strip, return_counts=True)
        tiles = dict(zip(strips.tolist(), counts.tolist(), strict=True))
        power: dict[int, Power] = {}
        for _, powers in sorted(self._pieces.items()):
            _add(power, powers)
        return PowerFound(self._size, self._part, self._frames, tiles, power)

    def take(self, found: PowerFound | None) -> None:
        if found is None:
            return
        size, part, frames, tiles, power = found
        self._here = sum(tiles.values()) + (self._here if part else 0)
        self._tiles[size] = max(self._here, self._tiles.get(size, 0))
        strips, seen = self._strips.setdefault(size, {}), self._seen.setdefault(size, {})
        _add(strips, power)
        if power:
            for strip, number in tiles.items():
                seen[strip] = seen.get(strip, 0) + 3 * frames * number

    def finish(self) -> Measurement:
        found = Measurement()
        reason = "needs a reference" if not self._context.has_reference else ""
        sizes = [size for size, seen in self._seen.items() if seen]
        if not reason and not sizes:
            reason = "no tile stays wholly covered"
        if reason:
            found.absent = dict.fromkeys(SCORES, reason)
            return found
        size = max(sizes)
        power = self._mean(size, self._strips[size])
        independent = self._tiles[size] / 4 if self._tiles[size] > 4 else 1
        peaks = find_peaks(power["error"], independent=independent)
        found.curves["moire.radial"] = radial(power, size)
        found.curves["moire.map"] = error_map(power["error"])
        found.curves["moire.peaks"] = {
            axis: [peak[i] for peak in peaks] for i, axis in enumerate(("x", "y", "strength"))
        }
        leading = peaks[0] if peaks else None
        values = _values(power, leading)
        left = self._replicates(size, independent, leading)
        reasons = {"moire.excess": "the reference has no detail"}
        for name in SCORES:
            why = reasons.get(name, "no peak stands over the local floor")
            found.put(name, values.get(name), why, replicates=left.get(name, ()))
        return found

    def _mean(self, size: int, strips: Iterable[int]) -> dict[str, Power]:
        chosen = list(strips)
        total = np.sum([self._strips[size][strip] for strip in chosen], axis=0)
        return dict(zip(KINDS, total / sum(self._seen[size][strip] for strip in chosen), strict=True))

    def _replicates(self, size: int, independent: float, leading: Peak | None) -> dict[str, list[float]]:
        """The scores with one strip left out at a time, where every strip leaves a value; none for a single strip."""
        strips = sorted(self._strips[size])
        if len(strips) < 2:
            return {}
        left = []
        for strip in strips:
            power = self._mean(size, [other for other in strips if other != strip])
            followed = leading and follow_peak(power["error"], leading, independent=independent)
            left.append(_values(power, followed))
        names = [name for name in left[0] if all(name in values for values in left)]
        return {name: [values[name] for values in left] for name in names}


def _add(to: dict[int, Power], power: Mapping[int, Power]) -> None:
    """Add power by strip."""
    for strip, found in power.items():
        to[strip] = to[strip] + found if strip in to else found


def _values(power: dict[str, Power], leading: Peak | None) -> dict[str, float]:
    """The scores that there are."""
    rings = radial(power, len(power["error"]))
    beyond = np.array(rings["frequency"]) * len(power["error"]) >= DC_LOBE
    test, reference = (np.array(rings[name])[beyond] for name in ("test", "reference"))
    found = {}
    if reference.sum() > 0:
        found["moire.excess"] = float(np.maximum(test - reference, 0).sum() / reference.sum())
    if leading is not None:
        x, y, strength = leading
        found |= {"moire.peak_frequency": float(np.hypot(x, y)), "moire.peak_strength": strength}
    return found


def radial(power: dict[str, Power], size: int) -> dict[str, list[float]]:
    """Energies of half-plane spectra [L, L/2 + 1] in rings 1/L cycles/px wide, below the pixel Nyquist."""
    radius = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :])
    ring = np.rint(radius * size).astype(int)
    rings = size // 2
    curves = {"frequency": [float(i) / size for i in range(rings)]}
    for name, values in power.items():
        curves[name] = np.bincount(ring.ravel(), values.ravel(), minlength=rings)[:rings].tolist()
    return curves


def error_map(power: Power) -> dict[str, list[Any]]:
    """The spectrum [L, L/2 + 1] as a picture: decibels to 1 radiance^2 of mean squared error in a bin and channel.

    x: cycles/px to the right, 0 to 1/2, one a column. y: cycles/px down, -1/2 to 1/2, one a row. The other half plane
    is its mirror image.
    """
    size = len(power)
    half = power / float(np.sum(window(size, 0.0) ** 2)) ** 2
    half[:, 1:-1] /= 2
    return {
        "x": [column / size for column in range(size // 2 + 1)],
        "y": [row / size - 0.5 for row in range(size)],
        "level": list(rows_of(np.fft.fftshift(half, axes=0))),
    }


def find_peaks(power: Power, *, independent: float) -> list[Peak]:
    """Peaks (x, y cycles/px, dB over the local floor) of a half-plane power spectrum, the strongest first.

    power: [L, L/2 + 1], mean of `independent` periodograms, with doubled energy where a bin stands for k and -k.
    Places are refined by a parabola through the logarithm of three bins along each axis.
    """
    size = len(power)
    plane = _whole_plane(power)
    floor = _floor(plane, independent)
    freedom = 2 * independent
    by_chance = special.chdtri(freedom, CHANCE / (size * size / 2)) / freedom
    highest = ndimage.maximum_filter(plane, size=2 * _CORE + 1, mode="wrap") == plane
    radius = np.hypot(*np.meshgrid(np.arange(size) - size // 2, np.arange(size) - size // 2, indexing="ij"))
    high = plane > floor * max(MIN_RATIO, by_chance)
    rows, columns = np.nonzero(highest & high & (radius >= DC_LOBE) & (radius < size / 2))
    half = (columns > size // 2) | ((columns == size // 2) & (rows >= size // 2))
    found = [_peak(plane, floor, row, column) for row, column in zip(rows[half], columns[half], strict=True)]
    return sorted(found, key=lambda peak: -peak[2])[:PEAKS]


def follow_peak(power: Power, near: Peak, *, independent: float) -> Peak:
    """The peak of another spectrum of the same size in the bin of a known one or next to it, however low it is."""
    size = len(power)
    plane = _whole_plane(power)
    column, row = (round(place * size) + size // 2 for place in near[:2])
    reach = np.arange(-1, 2)
    rows, columns = (row + reach) % size, (column + reach) % size
    down, right = np.unravel_index(np.argmax(plane[np.ix_(rows, columns)]), (3, 3))
    return _peak(plane, _floor(plane, independent), int(rows[down]), int(columns[right]))


def _floor(plane: Power, independent: float) -> Power:
    """Mean power around each bin, from the median of what `independent` periodograms of noise have."""
    reach = np.arange(-_HALO, _HALO + 1)
    ring = np.hypot(reach[:, None], reach[None, :])
    freedom = 2 * independent
    median = ndimage.median_filter(plane, footprint=(ring <= _HALO) & (ring > _CORE), mode="wrap")
    # The median of chi-square; scipy.stats, which gives the same bits, takes long to load.
    return np.asarray(median / (2 * special.gammaincinv(freedom / 2, 0.5) / freedom))


def _peak(plane: Power, floor: Power, row: int, column: int) -> Peak:
    """The peak at a bin, its place refined."""
    size = len(plane)
    strength = 10 * np.log10(plane[row, column] / max(floor[row, column], np.finfo(float).tiny))
    down = _vertex(plane[np.arange(row - 1, row + 2) % size, column])
    right = _vertex(plane[row, np.arange(column - 1, column + 2) % size])
    y, x = row - size // 2, column - size // 2
    return float((x + right) / size), float((y + down) / size), float(min(strength, 300.0))


def _whole_plane(power: Power) -> Power:
    """[L, L] with frequency 0 at (L/2, L/2), from the half plane."""
    size = len(power)
    half = power.copy()
    half[:, 1:-1] /= 2
    mirrored = half[(-np.arange(size)) % size][:, -2:0:-1]
    return np.asarray(np.fft.fftshift(np.concatenate([half, mirrored], axis=1)))


def _vertex(three: Power) -> float:
    """Offset in -1/2..1/2 of the top of a parabola through the logarithms of three values."""
    left, middle, right = np.log(np.maximum(three, np.finfo(float).tiny))
    bend = left - 2 * middle + right
    return float(np.clip(0.5 * (left - right) / bend, -0.5, 0.5)) if bend < 0 else 0.0


MEASURE = Moire
