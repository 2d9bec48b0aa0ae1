"""Where a failing score is worst: the frame, the region, and a picture of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from swimlab.footage.pictures import open_pictures
from swimlab.report.clips import Region
from swimlab.report.contact import GAP, PAPER, write
from swimlab.report.display import COVERED, ERROR_RANGE, Picture, difference_codes, srgb
from swimlab.report.worst import frame_before, to_blame, worst_frames, worst_region
from swimlab.runs.entries import Entry
from swimlab.runs.files import replacing
from swimlab.runs.frames import FrameError, Image, png
from swimlab.runs.names import file_name
from swimlab.runs.record import REFERENCE, Record

CHANGES = {"flicker", "plane", "residual", "visible"}
"""Words in the names of scores that are about change in time; all others are about the error itself."""


@dataclass(frozen=True)
class Evidence:
    """The worst frame of a score; region: (x, y, width, height) in px; crop: picture | reference | error.

    before: the frame before it, where it is not known which of the two is at fault for the change between them.
    region is None where the run has no frames or no reference any more, crop also where it cannot be written;
    `lacking` says why.
    """

    frame: int
    before: int | None = None
    region: Region | None = None
    crop: Path | None = None
    lacking: str = ""

    def describe(self) -> str:
        """In words, as "worst in frame 7 at x 64 y 128, 64x64 px"."""
        between = self.before is not None
        words = f"worst between frames {self.before} and {self.frame}" if between else f"worst in frame {self.frame}"
        if self.region is not None:
            words += " at x {} y {}, {}x{} px".format(*self.region)
        said = str(self.crop) if self.crop is not None else f"no picture of it: {self.lacking}" if self.lacking else ""
        return f"{words} ({said})" if said else words


def find_evidence(entry: Entry, metric: str) -> Evidence | None:
    """Locate what a score is worst about and write the picture RUN/gate/SEQUENCE-TECHNIQUE-METRIC.png.

    The frame is the one of the largest error or change, as the score is about; the region is the square of the
    largest squared error in it. None where the scores hold nothing by frame.
    """
    found = where_worst(entry, metric)
    if found is None:
        return None
    if entry.folder is None:
        own = "settings" in entry.provenance
        why = "your own frames are not in a run folder" if own else "no run folder lies beside the scores"
        return replace(found, lacking=why)
    pictures = open_pictures(entry.folder, Record.read(entry.folder))
    try:
        test, reference = (pictures.read(name, found.frame) for name in (entry.technique, REFERENCE))
    except FrameError as error:
        return replace(found, lacking=str(error))
    region = worst_region(test[..., :3] - reference[..., :3], reference[..., 3] >= COVERED)
    crop = entry.folder / "gate" / file_name(entry.sequence, entry.technique, f"{metric}.png")
    try:
        write_crop(crop, {entry.technique: test, REFERENCE: reference}, region)
    except OSError as error:  # a run folder that is read-only is judged all the same
        return replace(found, region=region, lacking=f"{crop}: {error.strerror or error}")
    return replace(found, region=region, crop=crop)


def where_worst(entry: Entry, metric: str) -> Evidence | None:
    """The frame that is worst for a score, without region and picture.

    One bad frame makes two changes, into it and out of it: of the two frames of a change the worse is named.
    """
    if metric.startswith("scale."):
        scale = _worst_scale(entry)
        return None if scale is None else Evidence(scale)
    changes = bool(CHANGES & set(metric.split(".")))
    if changes and (found := worst_frames(entry.frames, "change")):
        frame = found[0][0]
        worse = to_blame(entry.frames, frame)
        return Evidence(frame, frame_before(entry.frames, frame)) if worse is None else Evidence(worse)
    found = worst_frames(entry.frames, "mse", "change")
    return Evidence(found[0][0]) if found else None


def _worst_scale(entry: Entry) -> int | None:
    """The frame of the scale with the largest error, where every frame of the run has its row."""
    curve = entry.curves.get("scale", {})
    errors = curve.get("rmse") or curve.get("self_rmse") or []
    frames = Record.read(entry.folder).frames if entry.folder is not None else []
    if not errors or len(errors) != len(frames) or any(error is None for error in errors):
        return None
    return frames[max(range(len(errors)), key=lambda index: errors[index])]


ENLARGED = 4
HEADER = 24


def write_crop(path: Path, pictures: Mapping[str, Image], region: Region) -> None:
    """Write a region of two pictures as PNG, enlarged pixel by pixel: picture, reference, and their difference.

    Pictures are sRGB at exposure 1. The difference is grey where there is none; a channel is 255 where the picture
    is brighter by ERROR_RANGE of linear radiance and 1 where it is darker by as much, in any frame.
    """
    x, y, width, height = region
    cuts = {name: each[y : y + height, x : x + width, :3] for name, each in pictures.items()}
    cut, exact = cuts.values()
    error = difference_codes(cut - exact)
    panels = {**{name: srgb(each) for name, each in cuts.items()}, f"error +-{ERROR_RANGE:g}": error}
    with replacing(path) as temporary:
        temporary.write_bytes(png(_sheet(panels)))


def _sheet(panels: dict[str, Picture]) -> Picture:
    large = {name: panel.repeat(ENLARGED, axis=0).repeat(ENLARGED, axis=1) for name, panel in panels.items()}
    height, width = next(iter(large.values())).shape[:2]
    sheet: Picture = np.empty((HEADER + height, len(large) * (width + GAP) - GAP, 3), np.uint8)
    sheet[:] = PAPER
    for place, (name, panel) in enumerate(large.items()):
        left = place * (width + GAP)
        sheet[HEADER:, left : left + width] = panel
        write(sheet, name, (left + 4, HEADER - 8))
    return sheet
