"""How much flicker the unwarping of non-uniform motion makes by itself."""

from collections import defaultdict

import numpy as np

from metrics.bands import BANDS, describe
from metrics.glued import LIMIT
from metrics.measurement import Context, Measurement, Metric
from metrics.ratios import Ratios
from metrics.spans import Span, TileFloor
from metrics.spectra import Batch
from metrics.tiles import Level
from metrics.transform import follow

_TEXT = (
    f"share of a glued pattern's energy, content below {LIMIT:g} cycles/px, that reads as flicker: the measure's own"
)
_SOURCE = "a pattern followed through the clip's own motion fields; middle span"
_FORMULA = "sum |G - mean_t G|^2 T / (T - 1), over sum |G|^2; G the pattern's spectra"

SCORES = {"budget.alignment_floor": Metric("1", "information", _TEXT, _SOURCE, _FORMULA)} | {
    f"budget.alignment_floor.{band}": Metric("1", "information", f"{_TEXT}; {describe(band)}", _SOURCE, _FORMULA)
    for band in BANDS
}


CHANNELS = 3
"""Of pictures; the pattern has one."""


class AlignmentFloor:
    """Flicker of a glued pattern, in total and by band of distance."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._ratios: dict[str, Ratios] = defaultdict(Ratios)
        self._unwarped = False

    def held(self, level: Level) -> float:
        return level.held / CHANNELS

    def begin(self, span: Span) -> None:
        self._span, self._seen = span, False
        middle = span.correspondence is not None and span.start <= self._context.count // 2 < span.stop
        levels = span.levels if middle else []
        self._mean = [np.zeros((level.count, 1, *level.spectrum_shape), dtype=np.complex64) for level in levels]
        self._energy, self._varied = ([np.zeros(level.count) for level in levels] for _ in range(2))

    def add(self, batch: Batch) -> None:
        pattern = batch.pictures.glued
        if pattern is None:
            return
        self._seen = True
        seen = batch.frame - self._span.start + 1
        spectra, _ = batch.transform.seen(pattern, batch.tiles)
        energy, _, varied = follow(spectra, spectra, self._mean[batch.level][batch.tiles], 1 / seen)
        self._energy[batch.level][batch.tiles] += energy.sum(axis=1)
        self._varied[batch.level][batch.tiles] += varied.sum(axis=1) * ((seen - 1) / seen)

    def end(self) -> list[TileFloor] | None:
        """The pattern's tiles, of one span alone; None where nothing is unwarped."""
        span = self._span
        if span.correspondence is None:
            return None
        if self._seen:
            raised = span.count / max(1, span.count - 1)
            span.floors[span.tiles] = [
                TileFloor(level.size, None if span.bands is None else span.bands[index], energy, varied * raised)
                for index, (level, energy, varied) in enumerate(
                    zip(span.levels, self._energy, self._varied, strict=True)
                )
            ]
        return span.floors.get(span.tiles, [])

    def take(self, found: list[TileFloor] | None) -> None:
        if found is None:
            return
        self._unwarped = True
        for tiles in found:
            self._ratios["all"].add(tiles.size, tiles.energy, {"flicker": tiles.flicker})
            for number, band in enumerate(BANDS):
                if tiles.bands is not None:
                    inside = tiles.bands == number
                    self._ratios[band].add(tiles.size, tiles.energy[inside], {"flicker": tiles.flicker[inside]})

    def finish(self) -> Measurement:
        found = Measurement()
        for group in ("all", *BANDS):
            name = "budget.alignment_floor" if group == "all" else f"budget.alignment_floor.{group}"
            ratios = self._ratios[group]
            if not self._unwarped:
                found.absent[name] = "the picture moves as one: nothing is unwarped"
            elif group != "all" and not self._context.has_depth:
                found.absent[name] = "needs depth"
            elif ratios.weight == 0:
                found.absent[name] = "no tile stays wholly covered"
            else:
                found.put(name, ratios.value("flicker"), "", error=ratios.error("flicker"))
        return found


MEASURE = AlignmentFloor
