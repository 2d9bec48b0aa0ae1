"""The contact sheet, a PNG: a technique a row, its whole frame and one enlarged detail in several frames."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from swimlab.report.clips import Region, disputed_region
from swimlab.report.display import Picture, srgb
from swimlab.report.recorded import ReportError, Run, open_run
from swimlab.runs.files import replacing
from swimlab.runs.frames import Image, png

CELL = (256, 144)
ENLARGED = 4
GAP = 4
NAMES = 132
HEADER = 24
PAPER = (250, 250, 250)
INK = (30, 30, 30)
FRAME = (255, 170, 0)


def write_contact_sheet(run: Path, destination: Path, *, techniques: Sequence[str], frames: Sequence[int]) -> None:
    """Write the sheet of a run folder as PNG, sRGB.

    Rows are techniques. The first column is the whole of the first frame, shrunk by area averaging, with the
    detail outlined; then comes one column per frame with the detail enlarged ENLARGED times, pixel by pixel.
    Exposure is the same for all, set by the last technique (the reference, as a rule).
    Size: NAMES + (1 + len(frames)) (CELL width + GAP) by HEADER + len(techniques) (CELL height + GAP) px.
    Raises ReportError where the run lacks a technique or a frame.
    """
    opened = open_run(run)
    _check(opened, techniques, frames)
    region = disputed_region(opened, frames[0], (CELL[0] // ENLARGED, CELL[1] // ENLARGED))
    sheet = np.empty((HEADER + len(techniques) * (CELL[1] + GAP), column(1 + len(frames)), 3), np.uint8)
    sheet[:] = PAPER
    stops = exposure(opened.pictures.read(techniques[-1], frames[0]))
    for place, heading in enumerate(
        [f"whole frame, {stops:+d} EV", *(f"frame {frame}, x{ENLARGED}" for frame in frames)]
    ):
        write(sheet, heading, (column(place), HEADER - 8))
    for row, name in enumerate(techniques):
        top = HEADER + row * (CELL[1] + GAP)
        write(sheet, name, (6, top + CELL[1] // 2))
        pictures = [srgb(2.0**stops * opened.pictures.read(name, frame)[..., :3]) for frame in frames]
        for place, cell in enumerate([overview(pictures[0], region), *(enlarge(p, region) for p in pictures)]):
            sheet[top : top + CELL[1], column(place) : column(place) + CELL[0]] = cell
    with replacing(destination) as temporary:
        temporary.write_bytes(png(sheet))


def exposure(rgba: Image) -> int:
    """Stops (factors of two) that bring the 98th percentile of a picture's covered radiance just below 1."""
    seen = rgba[rgba[..., 3] > 0][:, :3]
    bright = float(np.percentile(seen, 98)) if len(seen) else 0.0
    return int(np.floor(-np.log2(bright))) if bright > 0 else 0


def column(place: int) -> int:
    """Left edge of a column of cells, px."""
    return NAMES + place * (CELL[0] + GAP)


def overview(picture: Picture, region: Region) -> Picture:
    """Fit a whole picture into a cell and outline the region on it."""
    height, width = picture.shape[:2]
    scale = min(CELL[0] / width, CELL[1] / height)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST)
    x, y, w, h = (round(edge * scale) for edge in region)
    cv2.rectangle(small, (x, y), (x + w, y + h), FRAME, 1)
    return centred(small.astype(np.uint8))


def enlarge(picture: Picture, region: Region) -> Picture:
    """Enlarge a region of a picture, pixel by pixel, into a cell."""
    x, y, width, height = region
    detail = picture[y : y + height, x : x + width]
    return centred(detail.repeat(ENLARGED, axis=0).repeat(ENLARGED, axis=1))


def centred(picture: Picture) -> Picture:
    """Put a picture no larger than a cell in the middle of one."""
    cell = np.empty((CELL[1], CELL[0], 3), np.uint8)
    cell[:] = PAPER
    top, left = (CELL[1] - picture.shape[0]) // 2, (CELL[0] - picture.shape[1]) // 2
    cell[top : top + picture.shape[0], left : left + picture.shape[1]] = picture
    return cell


def write(sheet: Picture, text: str, place: tuple[int, int]) -> None:
    """Draw a line of text with its base line starting at (x, y)."""
    cv2.putText(sheet, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.45, INK, 1, cv2.LINE_AA)


def _check(run: Run, techniques: Sequence[str], frames: Sequence[int]) -> None:
    if not techniques or not frames:
        raise ReportError(f"{run.folder}: a contact sheet needs a technique and a frame at least")
    for kind, wanted, there in (("technique", techniques, run.techniques), ("frame", frames, run.frames)):
        missing = [str(item) for item in wanted if item not in there]
        if missing:
            has = ", ".join(map(str, there))
            raise ReportError(f"{run.folder}: has no {kind} {', '.join(missing)}; choose of {has}, or render more")
