"""Moire: energy that the test has and the reference has not, by frequency, and its peaks.

Power spectra are means over frames, channels and tiles of the largest tile size that fits (64 px as a
rule), under the tiles' own window. Bins nearer to 0 than DC_LOBE / L belong to the mean level.
A peak must be a local maximum that stands over the local floor, the median around it, by more than MIN_RATIO and
by more than chance allows: a mean of M independent periodograms of noise follows chi^2 with 2 M degrees of freedom
(Welch 1967); only tiles that do not overlap count as independent, for frames and channels may repeat each other.
"""

import numpy as np
from numpy.typing import NDArray

from metrics.measurement import Context, Measurement, Metric
from metrics.spans import Span
from metrics.spectra import Batch

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
    ),
    "moire.peak_frequency": Metric(
        "cycles/px", "information", "frequency of the error's strongest spectral peak", _SOURCE
    ),
    "moire.peak_strength": Metric("dB", "lower", "power of that peak over the local floor", _SOURCE),
}

Power = NDArray[np.float64]


class Moire:
    """Mean power spectra of the largest tiles."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._power: dict[int, dict[str, Power]] = {}
        self._tiles: dict[int, float] = {}
        self._seen: dict[int, int] = {}

    def begin(self, span: Span) -> None:
        self._size = span.levels[0].size if span.levels else 0
        if span.levels:
            level = span.levels[0]
            self._radius = level.radius()
            apart = level.count / 4 if level.count > 4 else 1
            self._tiles[self._size] = max(apart, self._tiles.get(self._size, 1))
            zero = {name: np.zeros(level.spectrum_shape) for name in ("test", "reference", "error")}
            self._power.setdefault(self._size, zero)

    def add(self, batch: Batch) -> None:
        if batch.level != 0 or batch.error is None or batch.reference is None:
            return
        power = self._power[self._size]
        parts = {"test": batch.test, "reference": batch.reference, "error": batch.error}
        for name, spectra in parts.items():
            real = spectra.reshape(-1, *spectra.shape[-2:])
            power[name] += np.einsum("nij,nij->ij", real.real, real.real)
            power[name] += np.einsum("nij,nij->ij", real.imag, real.imag)
        self._seen[self._size] = self._seen.get(self._size, 0) + batch.test.shape[0] * 3

    def end(self) -> None:
        """Spans need no alignment with each other here."""

    def finish(self) -> Measurement:
        found = Measurement()
        reason = "needs a reference" if not self._context.has_reference else ""
        if not reason and not self._seen:
            reason = "no tile stays wholly covered"
        if reason:
            found.absent = dict.fromkeys(SCORES, reason)
            return found
        size = max(self._seen)
        mean = {name: power / self._seen[size] for name, power in self._power[size].items()}
        found.curves["moire.radial"] = radial(mean, size)
        beyond = np.array(found.curves["moire.radial"]["frequency"]) * size >= DC_LOBE
        test, reference = (np.array(found.curves["moire.radial"][n])[beyond] for n in ("test", "reference"))
        excess = float(np.maximum(test - reference, 0).sum())
        total = float(reference.sum())
        found.put("moire.excess", excess / total if total > 0 else None, "the reference has no detail")
        peaks = find_peaks(mean["error"], independent=self._tiles[size])
        found.curves["moire.peaks"] = {
            axis: [peak[i] for peak in peaks] for i, axis in enumerate(("x", "y", "strength"))
        }
        none = "no peak stands over the local floor"
        found.put("moire.peak_frequency", float(np.hypot(*peaks[0][:2])) if peaks else None, none)
        found.put("moire.peak_strength", peaks[0][2] if peaks else None, none)
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


def find_peaks(power: Power, *, independent: float) -> list[tuple[float, float, float]]:
    """Peaks (x, y cycles/px, dB over the local floor) of a half-plane power spectrum, the strongest first.

    power: [L, L/2 + 1], mean of `independent` periodograms, with doubled energy where a bin stands for k and -k.
    Places are refined by a parabola through the logarithm of three bins along each axis.
    """
    from scipy import ndimage, stats

    size = len(power)
    plane = _whole_plane(power)
    reach = np.arange(-_HALO, _HALO + 1)
    ring = np.hypot(reach[:, None], reach[None, :])
    floor = ndimage.median_filter(plane, footprint=(ring <= _HALO) & (ring > _CORE), mode="wrap")
    freedom = 2 * independent
    floor /= stats.chi2.median(freedom) / freedom
    by_chance = stats.chi2.isf(CHANCE / (size * size / 2), freedom) / freedom
    highest = ndimage.maximum_filter(plane, size=2 * _CORE + 1, mode="wrap") == plane
    radius = np.hypot(*np.meshgrid(np.arange(size) - size // 2, np.arange(size) - size // 2, indexing="ij"))
    high = plane > floor * max(MIN_RATIO, by_chance)
    kept = highest & high & (radius >= DC_LOBE) & (radius < size / 2)
    rows, columns = np.nonzero(kept)
    found = []
    for row, column in zip(rows, columns, strict=True):
        y, x = row - size // 2, column - size // 2
        if x < 0 or (x == 0 and y < 0):
            continue
        strength = 10 * np.log10(plane[row, column] / max(floor[row, column], np.finfo(float).tiny))
        down = _vertex(plane[np.arange(row - 1, row + 2) % size, column])
        right = _vertex(plane[row, np.arange(column - 1, column + 2) % size])
        found.append((float((x + right) / size), float((y + down) / size), float(min(strength, 300.0))))
    return sorted(found, key=lambda peak: -peak[2])[:PEAKS]


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
