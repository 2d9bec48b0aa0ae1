"""A run folder's description of itself, run.json."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swimlab.runs.files import write_json
from swimlab.runs.names import check_part

VERSION = 1
"""Version of the format of run.json and scores.json."""

REFERENCE = "reference"
"""The technique that the others are measured against."""

GEOMETRY = "geometry"
ERROR = "error"
"""Folders of a run beside the techniques': the geometry, and the reference's standard error in channels R, G, B, A.

The error has the precision of the pictures: halves where the pictures are halves.
"""


RESERVED = (REFERENCE, GEOMETRY, ERROR, "motion", "depth", "mask")
"""What no build may be called: a run has folders or inputs of these names."""

PARTS = (
    *(GEOMETRY, ERROR, "targets", "gate", "report", "measured"),
    *("run.json", "scores.json", "frames.csv", "report.html", "contact.png"),
)
"""What no technique may be called, whose folder lies in a run beside these folders and files."""


class RunError(ValueError):
    """A run that cannot be used as asked; the message says why and how to mend it."""


@dataclass
class Record:
    """What run.json holds.

    sequence: the sequence file's content with every default and every technique's settings filled in.
    times: per technique, the medians of the ms that a frame took to render and of the samples, texels or vertices that
        were shaded for it, and over how many frames.
    rendered: for each technique, when its pictures, or those that they are measured against, were last rendered anew.
        More frames do not count. Scores carry it, to be known for older than the pictures.
    code: for each technique from a folder of your own, the hash of its file.
    reference_rms_error: per frame, the reference's own standard error, rms over RGB and wholly covered pixels.
    inputs: of frames that were brought and stay where they are: input (a build's name, "reference", "motion", ...) ->
        its name, and its files' paths, sizes (bytes), times (ns) and hashes.
    """

    sequence: dict[str, Any]
    settings: dict[str, Any]
    hash: str
    uniform_velocity: tuple[float, float] | None
    resizes: bool
    provenance: dict[str, Any]
    techniques: list[str] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    times: dict[str, dict[str, float]] = field(default_factory=dict)
    rendered: dict[str, str] = field(default_factory=dict)
    code: dict[str, str] = field(default_factory=dict)
    reference_rms_error: dict[str, float] = field(default_factory=dict)
    inputs: dict[str, dict[str, Any]] = field(default_factory=dict)

    def write(self, run: Path) -> None:
        """Write RUN/run.json."""
        content = {key: value for key, value in vars(self).items() if key != "inputs" or value}
        write_json(run / "run.json", {"version": VERSION, **content})

    @staticmethod
    def read(run: Path) -> "Record":
        """Read RUN/run.json. Raises RunError where it is missing, of another version, or has a path for a name."""
        path = run / "run.json"
        if not path.is_file():
            raise RunError(f"{path}: is missing; name a run folder that 'swimlab render' or 'study' wrote")
        try:
            content = json.loads(path.read_text(encoding="utf-8-sig"))
            version = content.pop("version")
            if version != VERSION:
                raise RunError(f"{path}: has version {version!r}, this swimlab reads {VERSION}; render again")
            record = Record(**content)
            for name in record.techniques:  # its folder
                check_part(name, "technique")
            return record
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            if isinstance(error, RunError):
                raise
            raise RunError(f"{path}: is not a run description ({error}); render again with --force") from error
