"""Where a failing score is worst: the frame, the region, and a picture of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swimlab.gate.crop import worst_region, write_crop
from swimlab.runs.entries import Entry
from swimlab.runs.frames import frame_path
from swimlab.runs.record import REFERENCE, Record

CHANGES = {"flicker", "plane", "residual", "visible"}
"""Words in the names of scores that are about change in time; all others are about the error itself."""


@dataclass(frozen=True)
class Evidence:
    """The worst frame of a score; region: (x, y, width, height) in px; crop: picture | reference | error.

    region and crop are None where the run has no frames or no reference any more; `lacking` says why.
    """

    frame: int
    region: tuple[int, int, int, int] | None = None
    crop: Path | None = None
    lacking: str = ""

    def describe(self) -> str:
        """In words, as "worst in frame 7 at x 64 y 128, 64x64 px"."""
        words = f"worst in frame {self.frame}"
        if self.region is not None:
            words += " at x {} y {}, {}x{} px".format(*self.region)
        said = str(self.crop) if self.crop is not None else f"no picture of it: {self.lacking}" if self.lacking else ""
        return f"{words} ({said})" if said else words


def find_evidence(entry: Entry, metric: str) -> Evidence | None:
    """Locate what a score is worst about and write the picture RUN/gate/SEQUENCE-TECHNIQUE-METRIC.png.

    The frame is the one of the largest error or change, as the score is about; the region is the square of the
    largest squared error in it. None where the scores hold nothing by frame.
    """
    frame = worst_frame(entry, metric)
    if frame is None:
        return None
    if entry.folder is None:
        own = "settings" in entry.provenance
        why = "your own frames are not in a run folder" if own else "no run folder lies beside the scores"
        return Evidence(frame, lacking=why)
    test, reference = (frame_path(entry.folder, name, frame) for name in (entry.technique, REFERENCE))
    gone = [path for path in (test, reference) if not path.is_file()]
    if gone:
        return Evidence(frame, lacking=f"{gone[0]} is gone")
    region = worst_region(test, reference)
    crop = entry.folder / "gate" / f"{entry.sequence}-{entry.technique}-{metric}.png"
    write_crop(crop, test, reference, region)
    return Evidence(frame, region, crop)


def worst_frame(entry: Entry, metric: str) -> int | None:
    """Number of the frame that is worst for a score."""
    if metric.startswith("scale."):
        return _worst_scale(entry)
    changes = bool(CHANGES & set(metric.split(".")))
    return _largest(entry.frames, *(("change", "mse") if changes else ("mse", "change")))


def _largest(rows: Sequence[dict[str, Any]], *keys: str) -> int | None:
    for key in keys:
        known = [row for row in rows if isinstance(row.get(key), int | float)]
        if known:
            return int(max(known, key=lambda row: row[key])["frame"])
    return None


def _worst_scale(entry: Entry) -> int | None:
    """The frame of the scale with the largest error, where every frame of the run has its row."""
    curve = entry.curves.get("scale", {})
    errors = curve.get("rmse") or curve.get("self_rmse") or []
    frames = Record.read(entry.folder).frames if entry.folder is not None else []
    if not errors or len(errors) != len(frames) or any(error is None for error in errors):
        return None
    return frames[max(range(len(errors)), key=lambda index: errors[index])]
