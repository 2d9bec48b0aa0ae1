"""What was found in a clip, added up: the same scores wherever its spans were looked at."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from metrics import registry
from metrics.display import Domain
from metrics.measurement import Context, Measurement
from metrics.pixels import FrameFound
from metrics.tiles import SIZES
from metrics.whole_frame import SCORES as WHOLE_FRAME
from metrics.whole_frame import WholeFrame

# A screen-fixed error must travel this far against the surface to read as flicker for more than .9, px.
TRAVEL = 25.0

HALF_THE_PICTURE = 0.5
"""Below this share of measured pixels there is a note."""


class PartFound(NamedTuple):
    """What every measure found in a part of a span's tiles."""

    measures: list[Any]


class SpanFound(NamedTuple):
    """A span that is looked at to the end, and whether it has any tile."""

    start: int
    stop: int
    tiled: bool


Found = FrameFound | PartFound | SpanFound
"""A piece of what was found, in plain values that can be pickled."""


class Totals:
    """Takes in, in the order of spans, what was found in them."""

    def __init__(
        self,
        context: Context,
        shape: tuple[int, int],
        *,
        steps: NDArray[np.float64] | None,
        names: Sequence[str] | None,
        domain: Domain,
    ) -> None:
        """shape: [H, W] of the frames. steps: as `Plan` has them. names, domain: as `measure` takes them."""
        self._context, self._steps, self._names, self._domain = context, steps, names, domain
        self._measures = [measure(context) for measure in registry.measures(names)]
        self._whole = WholeFrame(shape, context.has_reference)
        self._longest = 0
        self._notes: list[str] = []

    def take(self, found: Found) -> None:
        """Add what was found next."""
        match found:
            case FrameFound():
                self._whole.take(found)
            case PartFound(parts):
                for measure, part in zip(self._measures, parts, strict=True):
                    measure.take(part)
            case SpanFound(start, stop, tiled):
                self._longest = max(self._longest, stop - start)
                if not tiled:
                    self._notes.append(f"frames {start} to {stop - 1}: no tile of {SIZES[-1]} px stays wholly covered")

    def finish(self) -> Measurement:
        """Scores and curves over all spans."""
        names, notes = self._names, list(self._notes)
        if self._longest < self._context.count:
            notes.append(f"frames are aligned in spans of {self._longest} at most: slower changes read as static")
        found = Measurement(notes=notes + (_travel_note(self._steps) if self._context.has_reference else []))
        for each in self._measures:
            found.merge(each.finish())
        if every_pixel(names):
            found.merge(self._whole.finish())
        found.notes += _extent_note(found.scores) + (self._whole.glints.notes() if self._domain == "linear" else [])
        found.scores = {name: found.scores[name] for name in sorted(found.scores) if registry.selected(name, names)}
        found.errors = {name: found.errors[name] for name in found.scores if name in found.errors}
        found.replicates = {name: found.replicates[name] for name in found.scores if name in found.replicates}
        found.absent = {name: found.absent[name] for name in sorted(found.absent) if registry.selected(name, names)}
        found.note_unknown_errors()
        return found


def every_pixel(names: Iterable[str] | None) -> bool:
    """Whether any of the named scores speaks of every pixel."""
    return any(registry.selected(name, names) for name in WHOLE_FRAME)


def _extent_note(scores: Mapping[str, float]) -> list[str]:
    """A warning where the budget speaks for less than half of the picture."""
    share = scores.get("measured.fraction", 1.0)
    if share >= HALF_THE_PICTURE:
        return []
    return [
        f"tiles reach {share:.0%} of the picture, and budget, residual and plane speak of these pixels alone; "
        f"edges.* ({scores['edges.fraction']:.0%}) and new.* ({scores['new.fraction']:.0%}) speak of the rest"
    ]


def _travel_note(steps: NDArray[np.float64] | None) -> list[str]:
    """A warning where an error fixed to the screen would not show as one; where nothing moves it is none."""
    if steps is None or len(steps) < 2:
        return []
    travelled = float(np.hypot(*steps[1:].sum(axis=0)))
    if travelled == 0 or travelled >= TRAVEL:
        return []
    return [
        f"the surface travels {travelled:.1f} px: an error fixed to the screen reads as flicker only in part "
        f"below {TRAVEL:g} px"
    ]
