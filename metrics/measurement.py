"""What a measure says about its scores, takes in, and gives back."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from metrics.ratios import jackknife
from metrics.spans import Span
from metrics.spectra import Batch
from metrics.tiles import Level

Better = Literal["lower", "higher", "information"]

# Scores named in a note.
_LISTED = 4


@dataclass(frozen=True)
class Metric:
    """A score's unit, which direction is better, what it says in one line, and where it comes from.

    formula: how it is made of frames. There e is test - reference, E its surface-locked spectra at spatial frequency
    k, X the test's, w the tiles' window and T the number of frames; sums are over all tiles and channels.
    """

    unit: str
    better: Better
    description: str
    source: str
    formula: str = ""


@dataclass
class Measurement:
    """Scores, and for each that cannot be measured the reason; ready for JSON, without NaN.

    errors: standard errors of scores, in their units; one that is not known is left out, and there is a note.
    replicates: scores with one block of tiles left out at a time; two measurements of one geometry leave out the same,
        so that the spread of their differences is that of a difference (see `ratios.jackknife`).
    frames: one entry a frame. curves: name -> axis -> values. notes: what a reader should beware of.
    """

    scores: dict[str, float] = field(default_factory=dict)
    absent: dict[str, str] = field(default_factory=dict)
    errors: dict[str, float] = field(default_factory=dict)
    replicates: dict[str, list[float]] = field(default_factory=dict)
    frames: list[dict[str, Any]] = field(default_factory=list)
    curves: dict[str, dict[str, list[Any]]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def put(
        self,
        name: str,
        value: float | None,
        reason: str,
        *,
        error: float | None = None,
        replicates: Sequence[float] = (),
    ) -> None:
        """Set a score and its replicates, or the reason if there is no value.

        error: the standard error; None: the replicates', if there are any.
        """
        if value is None:
            self.absent[name] = reason
            return
        self.scores[name] = float(value)
        if replicates:
            self.replicates[name] = [float(f"{each:.9g}") for each in replicates]
            error = jackknife(replicates) if error is None else error
        if error is not None:
            self.errors[name] = float(error)

    def note_unknown_errors(self) -> None:
        """Say which scores have no standard error."""
        unknown = [name for name in self.scores if name not in self.errors]
        if unknown:
            listed = ", ".join(unknown[:_LISTED]) + (f" and {len(unknown) - _LISTED} more" if unknown[_LISTED:] else "")
            self.notes.append(f"no standard error of {listed}: too little is measured to be split in parts that differ")

    def merge(self, other: "Measurement") -> None:
        """Take over what another measure found."""
        self.scores |= other.scores
        self.absent |= other.absent
        self.errors |= other.errors
        self.replicates |= other.replicates
        rows = {row["frame"]: row for row in self.frames}
        for row in other.frames:
            rows.setdefault(row["frame"], {}).update(row)
        self.frames = [rows[frame] for frame in sorted(rows)]
        self.curves |= other.curves
        self.notes += other.notes


@dataclass(frozen=True)
class Context:
    """What a measure may know before the first frame.

    velocity: (dx, dy) px a frame if the picture moves uniformly in space and time, else None.
    has_depth: whether spans come with bands of distance.
    pixels_per_degree, luminance: as a clip has them; None if unknown, or if the domain is not linear.
    """

    count: int
    has_reference: bool
    has_floor: bool
    has_depth: bool
    velocity: tuple[float, float] | None
    fps: float
    pixels_per_degree: float | None
    luminance: float | None


class Measure(Protocol):
    """Takes in a clip span by span, each in parts; of every piece of tiles frame by frame, in order.

    One looks at frames, from `begin` to `end`; another adds up what it found, with `take`, and may be in another
    process: so scores are the same bits wherever spans were looked at.
    `add` is called from several threads, of each piece from one at a time: it may write what belongs to the piece
    only, so that scores are the same bits for any number of threads.
    """

    def __init__(self, context: Context) -> None: ...

    def held(self, level: Level) -> float:
        """Bytes held for tiles of a level from `begin` to `end`."""

    def begin(self, span: Span) -> None:
        """Another part of a span starts: frames of different spans are not aligned."""

    def add(self, batch: Batch) -> None:
        """The next frame's spectra of a piece of tiles."""

    def end(self) -> Any:
        """The part has ended: what was found in it, in plain values that can be pickled."""

    def take(self, found: Any) -> None:
        """Add what was found in the next part, in the order of spans and parts."""

    def finish(self) -> Measurement:
        """Scores and curves over all spans."""
