"""What the report needs to know of a run folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swimlab.footage.pictures import Pictures, open_pictures
from swimlab.runs.record import REFERENCE, Record


class ReportError(ValueError):
    """What no report can be made from; the message says where and how to mend it."""


@dataclass(frozen=True)
class Run:
    """A run folder of one sequence. `techniques` is in display order, the reference last if there is one."""

    folder: Path
    sequence: str
    fps: float
    techniques: tuple[str, ...]
    frames: tuple[int, ...]
    milliseconds: dict[str, float]
    settings: dict[str, Any]
    provenance: dict[str, Any]
    resizes: bool
    uniform_velocity: tuple[float, float] | None
    pictures: Pictures


def open_run(folder: Path) -> Run:
    """Read RUN/run.json. Raises RunError where it is missing or damaged."""
    record = Record.read(folder)
    return Run(
        folder=folder,
        sequence=record.sequence["name"],
        fps=float(record.sequence["fps"]),
        techniques=tuple(sorted(record.techniques, key=lambda name: (name == REFERENCE, name))),
        frames=tuple(record.frames),
        milliseconds={name: time["ms_per_frame"] for name, time in record.times.items()},
        settings=record.sequence,
        provenance=record.provenance,
        resizes=record.resizes,
        uniform_velocity=record.uniform_velocity,
        pictures=open_pictures(folder, record),
    )
