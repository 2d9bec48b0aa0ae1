"""The charts that need a picture of their own for every technique, to be picked from one at a time."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from swimlab.report.bands_strip import strip
from swimlab.report.class_maps import class_map, edge_map
from swimlab.report.clips import Region, disputed_region
from swimlab.report.display import srgb, webp
from swimlab.report.figures import Figure
from swimlab.report.plane_slice import plane_slice
from swimlab.report.recorded import Run
from swimlab.report.spectrum_maps import peaks_of, spectrum_map, stripes
from swimlab.runs.record import REFERENCE

Entry = Mapping[str, Any]

THUMBNAIL = (128, 96)
DRAWN = {
    "Error by frame and frequency band": (strip, "budget.mse"),
    "Classes of pixels": (class_map, "measured.fraction"),
    "Flicker of edges": (edge_map, "edges.flicker"),
    "Spectrum of the error in two dimensions": (spectrum_map, "moire.excess"),
    "Motion-plane slice": (plane_slice, "plane.on"),
}
"""Title of a chart -> what draws it, and the score whose absence says why there is none."""
TITLES = tuple(DRAWN)


class Maps(NamedTuple):
    """Figures by technique, the technique to show first, and (title, reason) of charts that no technique has."""

    figures: dict[str, list[Figure]]
    first: str
    missing: list[tuple[str, str]]


def maps(run: Run, entries: Sequence[Entry]) -> Maps:
    """The charts of each technique of one sequence; that which flickers most is shown first.

    Raises FrameError where a picture whose stripes are to be drawn cannot be read.
    """
    tests = [entry for entry in entries if entry["technique"] != REFERENCE]
    drawn = {entry["technique"]: [draw(entry) for draw, _ in DRAWN.values()] for entry in tests}
    region = disputed_region(run, run.frames[0], THUMBNAIL) if any(map(peaks_of, tests)) else None
    found = {}
    for entry in tests:
        kept = zip(TITLES, drawn[entry["technique"]], strict=True)
        figures = [Figure(title, svg, sentence, []) for title, (svg, sentence) in kept if svg]
        if region is not None and peaks_of(entry) and entry["technique"] in run.techniques:
            figures.append(_on_picture(run, entry, region))
        if figures:
            found[entry["technique"]] = figures
    missing = [
        (title, _why_not(tests, title))
        for place, title in enumerate(TITLES)
        if tests and not any(some[place][0] for some in drawn.values())
    ]
    return Maps(found, max(found, key=lambda name: _flicker(tests, name)) if found else "", missing)


def _on_picture(run: Run, entry: Entry, region: Region) -> Figure:
    x, y, width, height = region
    rgba = run.pictures.read(entry["technique"], run.frames[0])[y : y + height, x : x + width]
    picture = f"data:image/webp;base64,{webp(srgb(rgba[..., :3]))}"
    return Figure(
        "Stripes of the peaks on the picture",
        stripes(picture, (width, height), peaks_of(entry)),
        f"Lines run and repeat as the numbered peaks' stripes do, on {width}x{height} px at ({x}, {y}) of frame "
        f"{run.frames[0]}; where they start is not known.",
        [],
    )


def _why_not(tests: Sequence[Entry], title: str) -> str:
    """In the words of the measure, as far as it says."""
    score = DRAWN[title][1]
    reasons = [entry.get("absent", {}).get(score) for entry in tests]
    if any("scale" in entry.get("curves", {}) for entry in tests):
        return "frames of different sizes are no clip"
    few = "needs a reference and 16 frames under one motion, or was measured by an earlier version"
    other = "was measured by an earlier version: measure the run again"
    return next((reason for reason in reasons if reason), few if score == "plane.on" else other)


def _flicker(tests: Sequence[Entry], name: str) -> float:
    return next(float(e["scores"].get("budget.flicker", 0.0)) for e in tests if e["technique"] == name)
