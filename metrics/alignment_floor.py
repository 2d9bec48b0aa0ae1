"""How much flicker the unwarping of non-uniform motion makes by itself."""

from collections import defaultdict

from metrics.bands import BANDS, describe
from metrics.glued import LIMIT, TileFloor
from metrics.measurement import Context, Measurement, Metric
from metrics.ratios import Ratios
from metrics.spans import Span
from metrics.spectra import Batch
from metrics.tiles import Level

_TEXT = (
    f"share of a glued pattern's energy, content below {LIMIT:g} cycles/px, that reads as flicker: the measure's own"
)
_SOURCE = "a pattern followed through the clip's own motion fields; middle span"
_FORMULA = "sum |G - mean_t G|^2 T / (T - 1), over sum |G|^2; G the pattern's spectra"

SCORES = {"budget.alignment_floor": Metric("1", "information", _TEXT, _SOURCE, _FORMULA)} | {
    f"budget.alignment_floor.{band}": Metric("1", "information", f"{_TEXT}; {describe(band)}", _SOURCE, _FORMULA)
    for band in BANDS
}


class AlignmentFloor:
    """Flicker of a glued pattern, in total and by band of distance."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._ratios: dict[str, Ratios] = defaultdict(Ratios)
        self._unwarped = False

    def held(self, level: Level) -> float:
        del level
        return 0.0

    def begin(self, span: Span) -> None:
        self._found: list[TileFloor] | None = None
        if span.glued is not None:
            middle = span.part == 0 and span.start <= self._context.count // 2 < span.stop
            self._found = span.glued.floor() if middle else []

    def add(self, batch: Batch) -> None:
        """Nothing to learn from pictures."""

    def end(self) -> list[TileFloor] | None:
        """The pattern's tiles, of one span alone; None where nothing is unwarped."""
        return self._found

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
