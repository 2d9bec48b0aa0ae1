"""Flicker without a reference: what changes in time at the same place of the surface."""

import numpy as np

from metrics.measurement import Context, Measurement, Metric
from metrics.octaves import OCTAVES
from metrics.ratios import Ratios, Values
from metrics.spans import Span
from metrics.spectra import Batch, flickering
from metrics.tiles import Level

_SOURCE = "sample variance over time of surface-locked tile spectra: residual under true motion"
_FORMULA = "sum |X - mean_t X|^2 / (T - 1), over sum w^2"

SCORES = {
    "residual.flicker": Metric(
        "radiance^2", "lower", "change in time of the test on the surface; no reference needed", _SOURCE, _FORMULA
    ),
    "residual.flicker.reference": Metric(
        "radiance^2", "information", "the same of the reference: what its pixel filter cannot calm", _SOURCE, _FORMULA
    ),
}


class ResidualFlicker:
    """Temporal variance of the test's and of the reference's spectra."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._ratios = Ratios()

    def held(self, level: Level) -> float:
        del level
        return 0.0

    def begin(self, span: Span) -> None:
        self._span = span
        names = ("test", "reference") if self._context.has_reference else ("test",)
        self._varied = {name: [np.zeros((lv.count, len(OCTAVES))) for lv in span.levels] for name in names}
        self._weight = [np.zeros(level.count) for level in span.levels]

    def add(self, batch: Batch) -> None:
        for name, varied in self._varied.items():
            varied[batch.level][batch.tiles] += batch.followed.varied[name]
        self._weight[batch.level][batch.tiles] += 3 * batch.weight

    def end(self) -> list[tuple[int, Values, dict[str, Values]]]:
        """For every level its size, and the tiles' weight and parts."""
        found = []
        for index, level in enumerate(self._span.levels):
            parts = {}
            for name, varied in self._varied.items():
                score = "residual.flicker" if name == "test" else f"residual.flicker.{name}"
                parts[score] = flickering(varied[index], self._span, index).sum(axis=1)
            found.append((level.size, self._weight[index], parts))
        return found

    def take(self, found: list[tuple[int, Values, dict[str, Values]]]) -> None:
        for tiles in found:
            self._ratios.add(*tiles)

    def finish(self) -> Measurement:
        found = Measurement()
        for name in SCORES:
            reason = ""
            if self._context.count < 2:
                reason = "needs at least 2 frames"
            elif name.endswith(".reference") and not self._context.has_reference:
                reason = "needs a reference"
            elif self._ratios.weight == 0:
                reason = "no tile stays wholly covered"
            if reason:
                found.absent[name] = reason
            else:
                ratios = self._ratios
                found.put(name, ratios.value(name), "", error=ratios.error(name), replicates=ratios.replicates(name))
        return found


MEASURE = ResidualFlicker
