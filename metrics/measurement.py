"""What a measure says about its scores, takes in, and gives back."""

from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from metrics.spans import Span
from metrics.spectra import Batch

Better = Literal["lower", "higher", "information"]


@dataclass(frozen=True)
class Metric:
    """A score's unit, which direction is better, what it says in one line, and where it comes from."""

    unit: str
    better: Better
    description: str
    source: str


@dataclass
class Measurement:
    """Scores, and for each that cannot be had the reason why; ready for JSON, without NaN.

    frames: one entry a frame. curves: name -> axis -> values. notes: what a reader should beware of.
    """

    scores: dict[str, float] = field(default_factory=dict)
    absent: dict[str, str] = field(default_factory=dict)
    frames: list[dict[str, Any]] = field(default_factory=list)
    curves: dict[str, dict[str, list[Any]]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def put(self, name: str, value: float | None, reason: str) -> None:
        """Set a score, or its reason if there is no value."""
        if value is None:
            self.absent[name] = reason
        else:
            self.scores[name] = float(value)

    def merge(self, other: "Measurement") -> None:
        """Take over what another measure found."""
        self.scores |= other.scores
        self.absent |= other.absent
        self.frames += other.frames
        self.curves |= other.curves
        self.notes += other.notes


@dataclass(frozen=True)
class Context:
    """What a measure may know before the first frame.

    velocity: (dx, dy) px a frame if the picture moves uniformly in space and time, else None.
    has_depth: whether spans come with bands of distance.
    """

    count: int
    has_reference: bool
    has_floor: bool
    has_depth: bool
    velocity: tuple[float, float] | None


class Measure(Protocol):
    """Takes in a clip span by span, frame by frame, batch by batch."""

    def __init__(self, context: Context) -> None: ...

    def begin(self, span: Span) -> None:
        """A new span starts: frames of different spans are not aligned."""

    def add(self, batch: Batch) -> None:
        """The next frame's spectra of some tiles."""

    def end(self) -> None:
        """The span has ended."""

    def finish(self) -> Measurement:
        """Scores and curves over all spans."""
