"""Where each technique errs most and where it changes most: the frame, the region in it, and pictures of both."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any
from urllib.parse import urlencode

import numpy as np
from numpy.typing import NDArray

from swimlab.report.charts import drawing, drawn_text, number
from swimlab.report.clips import Clip, Region
from swimlab.report.display import COVERED, difference_codes, srgb
from swimlab.report.figures import Figure
from swimlab.report.heat import image
from swimlab.report.places import CHANGE, ERROR, cut, pair_into, to_blame, worst_frames, worst_region
from swimlab.report.recorded import Run
from swimlab.runs.record import REFERENCE

Entry = Mapping[str, Any]

NAMED = 3
"""Worst frames that are named."""

SHOWN = 6
"""Techniques that are shown, at most: those whose worst frame is worst."""

WIDTH = 420
GAP = 6
HEAD = 38


@dataclass(frozen=True)
class Worst:
    """A technique's worst frames, the worst first, their rms, the region of the first, and pictures of it by name."""

    technique: str
    frames: list[int]
    rms: float
    region: Region
    panels: dict[str, NDArray[np.uint8]]


def worst(run: Run, entries: Sequence[Entry], clips: Sequence[Clip]) -> list[Figure]:
    """The figures of one run; none for frames of several sizes.

    clips: of the whole page, to which frames that they show are linked. Raises FrameError where a picture cannot be
    read.
    """
    if run.resizes:
        return []
    names = [name for name in run.techniques if name != REFERENCE]
    tests = [{"frames": [], **each} for each in entries if each["technique"] in names]
    of = "the error" if REFERENCE in run.techniques else "the picture"
    drawn = []
    for title, keys, find, right in (
        ("Worst errors", ERROR, _error, "test \u2212 reference"),
        ("Worst flicker", CHANGE, _flicker, f"what of {of} changes on the surface from the frame before"),
    ):
        shown = _worst_of(tests, keys)
        found = [each for each in (find(run, entry) for entry in shown) if each is not None]
        if found:
            less = f", of the {len(shown)} worst of {len(tests)}" if len(shown) < len(tests) else ""
            sentence = (
                f"The square of largest squared difference in each {run.pictures.called}\u2019s worst frame{less}; "
                f"at the right {right}, grey where there is none."
            )
            drawn.append(Figure(title, _drawn(title, run, found, clips), sentence, []))
    return drawn


def _worst_of(tests: Sequence[Entry], keys: Sequence[str]) -> list[Entry]:
    """Those with the worst frames, in the order given."""
    worst_of = {test["technique"]: frames[0][1] for test in tests if (frames := worst_frames(test["frames"], *keys))}
    names = sorted(worst_of, key=lambda name: -worst_of[name])[:SHOWN]
    return [test for test in tests if test["technique"] in names]


def _error(run: Run, entry: Entry) -> Worst | None:
    frames = worst_frames(entry["frames"], *ERROR)
    if not frames or REFERENCE not in run.techniques:
        return None
    frame, name = frames[0][0], entry["technique"]
    test, exact = (run.pictures.read(each, frame) for each in (name, REFERENCE))
    error = test[..., :3] - exact[..., :3]
    region = worst_region(error, exact[..., 3] >= COVERED)
    panels = {name: srgb(cut(test[..., :3], region)), REFERENCE: srgb(cut(exact[..., :3], region))}
    return _found(name, frames, region, panels | {"error": difference_codes(cut(error, region))})


def _flicker(run: Run, entry: Entry) -> Worst | None:
    frames = [pair for pair in worst_frames(entry["frames"], *CHANGE) if pair[0] in run.frames[1:]]
    if not frames:
        return None
    frame, name = frames[0][0], entry["technique"]
    pair = pair_into(run.pictures, name, run.frames, frame, reference=REFERENCE in run.techniques)
    region = worst_region(pair.change, pair.known)
    panels = {
        f"frame {each}": srgb(cut(picture[..., :3], region))
        for each, picture in zip(pair.frames, pair.pictures, strict=True)
    }
    panels["change"] = difference_codes(cut(pair.change, region))
    first, place = pair.fault(region) if REFERENCE in run.techniques else (frame, region)
    blamed = {first: frames[0][1]}
    for each, value in frames[1:]:
        worse = to_blame(entry["frames"], each)
        blamed.setdefault(each if worse is None else worse, value)
    return _found(name, list(blamed.items()), place, panels)


def _found(name: str, frames: list[tuple[int, float]], region: Region, panels: dict[str, NDArray[np.uint8]]) -> Worst:
    return Worst(name, [frame for frame, _ in frames[:NAMED]], math.sqrt(max(0.0, frames[0][1])), region, panels)


def _drawn(title: str, run: Run, found: Sequence[Worst], clips: Sequence[Clip]) -> str:
    """A row of pictures a technique, under its words."""
    body: list[str] = []
    top = 0.0
    for each in found:
        x, y, width, height = each.region
        first, *others = each.frames
        then = f", then {', '.join(map(str, others))}" if others else ""
        at = f"frame {first} at ({x}, {y}), rms {number(each.rms)}"
        said = drawn_text(0, top + 14, f"{each.technique}: {at}{then}", "start")
        address = _address(run, each, clips)
        body.append(f'<a href="{escape(address)}">{said}</a>' if address else said)
        wide = (WIDTH - GAP * (len(each.panels) - 1)) / len(each.panels)
        high = wide * height / width
        for place, (name, codes) in enumerate(each.panels.items()):
            left = place * (wide + GAP)
            body.append(drawn_text(left, top + HEAD - 6, name, "start"))
            body.append(image(codes, (left, top + HEAD, left + wide, top + HEAD + high)))
        top += HEAD + high + GAP
    return drawing((WIDTH, math.ceil(top)), title, body)


def _address(run: Run, each: Worst, clips: Sequence[Clip]) -> str:
    """Of the viewer that shows the region; empty where the page has no whole picture of the frame."""
    frame = each.frames[0]
    for place, clip in enumerate(clips):
        if clip.run is run and clip.region is None and frame in clip.sizes:
            (width, height), (x, y, w, h) = run.settings["size"], each.region
            view = {
                "clip": place,
                "a": each.technique,
                "b": REFERENCE if REFERENCE in run.techniques else run.techniques[0],
                "frame": frame,
                "zoom": f"{max(1.0, min(width / (2 * w), height / (2 * h))):.2f}",
                "x": f"{(x + w / 2) / width:.4f}",
                "y": f"{(y + h / 2) / height:.4f}",
            }
            return f"#{urlencode(view)}"
    return ""
