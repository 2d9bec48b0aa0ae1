"""Flicker without a reference: what changes in time at the same place of the surface."""

import numpy as np

from metrics.measurement import Context, Measurement, Metric
from metrics.spans import Span
from metrics.spectra import Batch, RunningMean

_SOURCE = "variance over time of surface-locked tile spectra: residual under true motion"

SCORES = {
    "residual.flicker": Metric(
        "radiance^2", "lower", "change in time of the test on the surface; no reference needed", _SOURCE
    ),
    "residual.flicker.reference": Metric(
        "radiance^2", "information", "the same of the reference: what its pixel filter cannot calm", _SOURCE
    ),
}


class ResidualFlicker:
    """Temporal variance of the test's and of the reference's spectra."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._varied = {"residual.flicker": 0.0, "residual.flicker.reference": 0.0}
        self._weight = 0.0

    def begin(self, span: Span) -> None:
        self._test = RunningMean(span)
        self._reference = RunningMean(span)

    def add(self, batch: Batch) -> None:
        self._test.add(batch, batch.test)
        if batch.reference is not None:
            self._reference.add(batch, batch.reference)
        self._weight += 3 * batch.weight * len(batch.test)

    def end(self) -> None:
        for name, running in zip(self._varied, (self._test, self._reference), strict=True):
            self._varied[name] += float(sum(np.sum(varied) for varied in running.varied))

    def finish(self) -> Measurement:
        found = Measurement()
        for name, varied in self._varied.items():
            reason = ""
            if self._context.count < 2:
                reason = "needs at least 2 frames"
            elif name.endswith(".reference") and not self._context.has_reference:
                reason = "needs a reference"
            elif self._weight == 0:
                reason = "no tile stays wholly covered"
            found.put(name, None if reason else varied / self._weight, reason)
        return found


MEASURE = ResidualFlicker
