"""Visible flicker: the surface-locked flicker weighted by what the eye, following the surface, is sensitive to."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics.measurement import Context, Measurement, Metric
from metrics.ratios import Ratios, Values
from metrics.spans import Span
from metrics.spectra import Batch
from metrics.tiles import Level

SEGMENT = 8
"""Frames whose temporal spectrum is taken at a time: sensitivity changes little over fps / 8."""

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)
"""Relative luminance of linear R, G, B (ITU-R BT.709)."""

PHOTOPIC = 10.0
"""Mean luminance, cd/m^2, below which sensitivity falls below that of the formula."""

SCORES = {
    "visible.flicker": Metric(
        "thresholds",
        "lower",
        "flicker of luminance contrast on the surface over the threshold of an eye that follows it, pooled by squares",
        "contrast sensitivity: Kelly 1979, Motion and vision II, eq. 8",
        "sqrt(2 sum S(f_t, f_s)^2 |Y|^2) / mean luminance; Y of luminance, in segments of 8 frames less their mean",
    ),
}


def kelly(temporal: NDArray[np.float64], spatial: NDArray[np.float64]) -> NDArray[np.float64]:
    """Contrast sensitivity at temporal (Hz) and spatial (cycles/degree) frequencies >= 0, photopic (Kelly 1979, eq. 8).

    a = 2 pi f_s, v = f_t/f_s, G = (6.1 + 7.3 |log10(v/3)|^3) v a^2 exp(-2 a (v + 2)/45.9). Where either frequency is 0
    its limit, 0.
    """
    temporal, spatial = np.broadcast_arrays(np.asarray(temporal, np.float64), np.asarray(spatial, np.float64))
    seen = (temporal > 0) & (spatial > 0)
    a = 2 * np.pi * spatial
    velocity = np.divide(temporal, spatial, out=np.ones_like(a), where=seen)
    gain = 6.1 + 7.3 * np.abs(np.log10(velocity / 3)) ** 3
    return np.where(seen, gain * velocity * a**2 * np.exp(-2 * a * (velocity + 2) / 45.9), 0.0)


class LevelFound(NamedTuple):
    """Of the tiles of one size: their weight [n] in whole segments, and there the flicker seen, times the weight.

    bright, lit: mean luminance and weight [n] in all frames.
    """

    size: int
    weight: Values
    seen: Values
    bright: Values
    lit: Values


class VisibleFlicker:
    """Temporal spectra, segment by segment, of the luminance of the error (of the test without a reference)."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._ratios = Ratios()
        self._light = np.zeros(2)
        # A Hann taper of unit power keeps slow changes out of the higher frequencies.
        taper = np.sin(np.pi * (np.arange(SEGMENT) + 0.5) / SEGMENT) ** 2
        self._taper = (taper / np.sqrt(SEGMENT * np.sum(taper**2))).astype(np.float32)

    def held(self, level: Level) -> float:
        return 8.0 * SEGMENT * level.count * np.prod(level.spectrum_shape) if self._able else 0.0

    @property
    def _able(self) -> bool:
        return self._context.pixels_per_degree is not None

    def begin(self, span: Span) -> None:
        self._span = span
        if not self._able:
            return
        shapes = [(level.count, SEGMENT, *level.spectrum_shape) for level in span.levels]
        self._held = [np.zeros(shape, dtype=np.complex64) for shape in shapes]
        self._seen, self._weight, self._bright, self._lit = (
            [np.zeros(level.count) for level in span.levels] for _ in range(4)
        )
        self._squared_sensitivity = [self._sensitivity(level) for level in span.levels]

    def add(self, batch: Batch) -> None:
        if not self._able:
            return
        index = batch.frame - self._span.start
        spectra = batch.test if batch.error is None else batch.error
        held = self._held[batch.level][batch.tiles]
        held[:, index % SEGMENT] = np.einsum("c,nckl->nkl", LUMINANCE, spectra)
        self._bright[batch.level][batch.tiles] += batch.weight * (batch.mean @ LUMINANCE)
        self._lit[batch.level][batch.tiles] += batch.weight
        if index % SEGMENT < SEGMENT - 1:
            return
        varied = (held - held.mean(axis=1, keepdims=True)) * self._taper[:, None, None]
        power = np.abs(np.fft.fft(varied, axis=1)) ** 2
        weighed = np.einsum("nfkl,fkl->n", power, self._squared_sensitivity[batch.level])
        # A sinusoid of contrast m has the mean square m^2 / 2.
        self._seen[batch.level][batch.tiles] += 2 * weighed
        self._weight[batch.level][batch.tiles] += batch.weight

    def end(self) -> list[LevelFound]:
        if not self._able:
            return []
        return [
            LevelFound(level.size, *values)
            for level, *values in zip(self._span.levels, self._weight, self._seen, self._bright, self._lit, strict=True)
        ]

    def take(self, found: list[LevelFound]) -> None:
        for size, weight, seen, bright, lit in found:
            if weight.any():
                self._ratios.add(size, weight, {"seen": seen})
            self._light += [bright.sum(), lit.sum()]

    def finish(self) -> Measurement:
        found = Measurement()
        reason = self._reason()
        if reason:
            found.absent["visible.flicker"] = reason
            return found
        light = float(self._light[0] / self._light[1])
        value = np.sqrt(self._ratios.value("seen")) / light
        error = self._ratios.error("seen")
        if error is not None and value > 0:
            error = error / (2 * value * light**2)
        replicates = [np.sqrt(each) / light for each in self._ratios.replicates("seen")]
        found.put("visible.flicker", value, "", error=error, replicates=replicates)
        luminance = self._context.luminance
        if luminance is not None and light * luminance < PHOTOPIC:
            found.notes.append(
                f"visible.flicker: a mean of {light * luminance:.2g} cd/m^2 is below daylight vision; the eye sees less"
            )
        return found

    def _sensitivity(self, level: Level) -> NDArray[np.float32]:
        """[SEGMENT, L, L/2 + 1], squared sensitivity at the temporal and spatial frequency of each bin."""
        temporal = np.abs(np.fft.fftfreq(SEGMENT, 1 / self._context.fps))
        spatial = level.radius() * (self._context.pixels_per_degree or 0.0)
        return np.asarray(kelly(temporal[:, None, None], spatial[None]) ** 2, np.float32)

    def _reason(self) -> str:
        if not self._able:
            return "needs pixels per degree, and the linear domain"
        if self._context.count < SEGMENT:
            return f"needs at least {SEGMENT} frames"
        if self._ratios.weight == 0:
            return f"no tile stays wholly covered for {SEGMENT} frames"
        return "" if self._light[0] > 0 else "the picture is black"


MEASURE = VisibleFlicker
