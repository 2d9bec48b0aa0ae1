"""How much of the picture the scores speak of."""

from metrics.measurement import Context, Measurement, Metric
from metrics.spans import Span
from metrics.spectra import Batch
from metrics.tiles import Level

SCORES = {
    "covered.fraction": Metric(
        "1", "information", "share of wholly covered pixels", "mean over frames", "wholly covered / all"
    ),
}


class Extent:
    """Measured and covered area."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._covered = 0.0

    def held(self, level: Level) -> float:
        del level
        return 0.0

    def begin(self, span: Span) -> None:
        self._span = span

    def add(self, batch: Batch) -> None:
        """Nothing to learn from pictures."""

    def end(self) -> float:
        return 0.0 if self._span.part > 0 else self._span.covered * self._span.count

    def take(self, found: float) -> None:
        self._covered += found

    def finish(self) -> Measurement:
        return Measurement(
            scores={
                "covered.fraction": self._covered / self._context.count,
            },
            errors=dict.fromkeys(SCORES, 0.0),
        )


MEASURE = Extent
