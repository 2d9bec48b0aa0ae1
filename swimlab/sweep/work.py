"""What a sweep is to the command: pieces that are done anywhere, once each, and what is made of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from swimlab.sweep.engine import Engine
from swimlab.sweep.file import Sweep
from swimlab.sweep.perform import Show


@dataclass
class Outcome:
    """What came of a sweep: the scores of each configuration that could be measured, and the failures by file."""

    scores: list[dict[str, Any]] = field(default_factory=list)
    failures: dict[Path, str] = field(default_factory=dict)


class Piece(Protocol):
    """A piece of work: some frames of a technique, or of a build."""

    @property
    def technique(self) -> str:
        """Of which technique or build."""

    @property
    def frames(self) -> tuple[int, ...]:
        """Which frames."""

    def path(self, out: Path) -> Path:
        """What is there when the piece is done."""


class Work(Protocol):
    """A sweep in pieces; its configurations have names, in the order of `grid.points`."""

    @property
    def sweep(self) -> Sweep:
        """The file's content."""

    @property
    def names(self) -> list[str]:
        """The configurations' names."""

    def pieces(self) -> Sequence[Piece]:
        """Every piece once, in a fixed order."""

    def do(
        self, pieces: Sequence[Any], out: Path, engine: Engine, *, threads: int | None, show: Show
    ) -> dict[Path, str]:
        """Do the missing ones of some of the pieces; the failures by file."""

    def finish(self, out: Path, engine: Engine, *, command: str, show: Show) -> Outcome:
        """Make run folders and scores of what is done."""
