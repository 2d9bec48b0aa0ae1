"""Where a failing score is worst: the frame, the region, and a picture of it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from swimlab.footage.pictures import open_pictures
from swimlab.gate.about import About, about, frames_of, worst_scale
from swimlab.gate.look import Found, Look
from swimlab.report.clips import Region
from swimlab.report.contact import GAP, PAPER, write
from swimlab.report.display import Picture
from swimlab.report.places import ERROR, frame_before, to_blame, worst_frames
from swimlab.runs.entries import Entry
from swimlab.runs.files import replacing
from swimlab.runs.frames import FrameError, png
from swimlab.runs.names import file_name
from swimlab.runs.record import Record

STATIC = ("bias", "detail")


@dataclass(frozen=True)
class Evidence:
    """The worst frame of a score; region: (x, y, width, height) in px; crop: what is there, as a picture.

    frame: None where only pictures could tell, and they are not there. before: the frame before it, where it is not
    known which of the two is at fault for the change between them. static: what is worst in the region is so in every
    frame alike.
    region is None where the run has no frames or no reference any more, crop also where it cannot be written;
    `lacking` says why.
    """

    frame: int | None
    before: int | None = None
    region: Region | None = None
    crop: Path | None = None
    lacking: str = ""
    static: bool = False

    def describe(self) -> str:
        """In words, as "worst in frame 7 at x 64 y 128, 64x64 px"."""
        if self.frame is None:
            return f"where it is worst is not known: {self.lacking}"
        words = f"worst in frame {self.frame}"
        if self.before is not None:
            words = f"worst between frames {self.before} and {self.frame}"
        if self.region is not None:
            at = "at x {} y {}, {}x{} px".format(*self.region)
            words = f"worst {at} of frame {self.frame}" if self.static else f"{words} {at}"
        said = str(self.crop) if self.crop is not None else f"no picture of it: {self.lacking}" if self.lacking else ""
        return f"{words} ({said})" if said else words


def find_evidence(entry: Entry, metrics: Sequence[str]) -> dict[str, Evidence]:
    """Locate what scores are worst about and write the pictures RUN/gate/SEQUENCE-TECHNIQUE-METRIC.png.

    Frame and region are those of what the score is about: the error or the change, at its pixels, in its band of
    distance. A score of which that is not known is left out.
    """
    found = {metric: told for metric in metrics if (told := where_worst(entry, metric)) is not None}
    if not found:
        return {}
    if entry.folder is None:
        own = "settings" in entry.provenance
        why = "your own frames are not in a run folder" if own else "no run folder lies beside the scores"
        return {metric: replace(told, lacking=why) for metric, told in found.items()}
    seen, lacking = _look(entry, entry.folder, found)
    return {
        metric: _pictured(entry, entry.folder, metric, seen[metric])
        if metric in seen
        else replace(told, lacking=lacking.get(metric, ""))
        for metric, told in found.items()
    }


def where_worst(entry: Entry, metric: str) -> Evidence | None:
    """The frame that is worst for a score as far as its values by frame tell; None where it has no place.

    One bad frame makes two changes, into it and out of it: of the two frames of a change the worse is named.
    """
    if metric.startswith("scale."):
        scale = _worst_scale(entry, metric)
        return None if scale is None else Evidence(scale)
    what = about(metric)
    frames = [] if what is None else frames_of(what, entry.frames, reference=_has_reference(entry))
    if what is None or not frames:
        return None
    if len(frames) > 1 or what.kind in STATIC or what.band:
        return Evidence(None)
    if "change" not in what.kind:
        return Evidence(frames[0])
    worse = to_blame(entry.frames, frames[0])
    return Evidence(frames[0], frame_before(entry.frames, frames[0])) if worse is None else Evidence(worse)


def _look(entry: Entry, folder: Path, metrics: Iterable[str]) -> tuple[dict[str, Found], dict[str, str]]:
    """Where each score is worst, and why it is not known of others: every frame is looked at once for all."""
    record, reference = Record.read(folder), _has_reference(entry)
    pictures, classes = open_pictures(folder, record), entry.curves.get("frame.map", {})
    by_frame: dict[int, list[tuple[str, About]]] = {}
    for metric in metrics:
        what = about(metric)
        if what is None:
            continue
        scale = _worst_scale(entry, metric)
        frames = frames_of(what, entry.frames, reference=reference) if scale is None else [scale]
        for frame in frames:
            by_frame.setdefault(frame, []).append((metric, what))
    found: dict[str, Found] = {}
    lacking: dict[str, str] = {}
    for frame, asked in by_frame.items():
        look = Look(pictures, entry.technique, record.frames, frame, reference=reference, classes=classes)
        for metric, what in asked:
            try:
                seen = look.find(what)
            except FrameError as error:
                lacking.setdefault(metric, str(error))
                continue
            if seen is None:
                lacking.setdefault(metric, "its pictures show nothing of it")
            elif metric not in found or seen.power > found[metric].power:
                found[metric] = seen
    return found, lacking


def _pictured(entry: Entry, folder: Path, metric: str, seen: Found) -> Evidence:
    """What was seen, with its picture written."""
    what = about(metric)
    evidence = Evidence(seen.frame, seen.before, seen.region, static=what is not None and what.kind in STATIC)
    crop = folder / "gate" / file_name(entry.sequence, entry.technique, f"{metric}.png")
    try:
        write_crop(crop, seen.panels)
    except OSError as error:  # a run folder that is read-only is judged all the same
        return replace(evidence, lacking=f"{crop}: {error.strerror or error}")
    return replace(evidence, crop=crop)


def _has_reference(entry: Entry) -> bool:
    return bool(worst_frames(entry.frames, *ERROR))


def _worst_scale(entry: Entry, metric: str) -> int | None:
    """The frame of the scale that a score is about, where every frame of the run has its row."""
    curve = entry.curves.get("scale")
    return worst_scale(metric, curve, Record.read(entry.folder).frames) if curve and entry.folder is not None else None


ENLARGED = 4
HEADER = 24


def write_crop(path: Path, panels: Mapping[str, Picture]) -> None:
    """Write pictures of a region side by side as PNG, enlarged pixel by pixel, each under its name.

    Pictures are sRGB at exposure 1. A difference is grey where there is none; a channel is 255 where the picture
    is brighter by ERROR_RANGE of linear radiance and 1 where it is darker by as much, in any frame.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(png(_sheet(panels)))


def _sheet(panels: Mapping[str, Picture]) -> Picture:
    large = {name: panel.repeat(ENLARGED, axis=0).repeat(ENLARGED, axis=1) for name, panel in panels.items()}
    height, width = next(iter(large.values())).shape[:2]
    sheet: Picture = np.empty((HEADER + height, len(large) * (width + GAP) - GAP, 3), np.uint8)
    sheet[:] = PAPER
    for place, (name, panel) in enumerate(large.items()):
        left = place * (width + GAP)
        sheet[HEADER:, left : left + width] = panel
        write(sheet, name, (left + 4, HEADER - 8))
    return sheet
