"""What the viewer of the page is handed: clips with their pictures, and what is known of them frame by frame."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from swimlab.report.clips import Clip
from swimlab.report.display import ERROR_COLOURS, ERROR_RANGE, ERROR_STEPS
from swimlab.report.places import CHANGE, ERROR, worst_frames
from swimlab.report.recorded import Run
from swimlab.runs.record import REFERENCE


def picture_json(clips: Sequence[Clip], entries: Sequence[Mapping[str, Any]], pick: str) -> str:
    """What the viewer needs, as JSON that may stand inside a script element. pick: the technique to show first."""
    content = {
        "error": {"range": ERROR_RANGE, "steps": ERROR_STEPS, "colours": ERROR_COLOURS},
        "first": _first(clips),
        "pick": pick,
        "reference": REFERENCE,
        "clips": [_viewer_clip(clip, entries) for clip in clips],
    }
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _first(clips: Sequence[Clip]) -> int:
    """The place of the clip to open on: whole pictures of what moves at one size, else a detail, else anything."""

    def worth(place: int) -> tuple[bool, bool]:
        clip = clips[place]
        return len(clip.run.frames) > 1 and not clip.run.resizes, clip.region is None

    return max(range(len(clips)), key=worth, default=0)


def caption(clip: Clip) -> str:
    """Which part and which frames of its run a clip has, in words."""
    first, last = clip.frames[0], clip.frames[-1]
    which = f"frame {first}" if first == last else f"frames {first} to {last}"
    if clip.region is None:
        size = f" at 1/{clip.shrunk} of its size" if clip.shrunk > 1 else ""
        return f"whole picture{size}, {which} of {len(clip.run.frames)}"
    x, y, width, height = clip.region
    return f"detail {width}x{height} at ({x}, {y}), {which} of {len(clip.run.frames)}"


def _viewer_clip(clip: Clip, entries: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    mine = [entry for entry in entries if entry["sequence"] == clip.run.sequence]
    by_frame = {entry["technique"]: dict(worst_frames(entry.get("frames", []), *ERROR, *CHANGE)) for entry in mine}
    return {
        "sequence": clip.run.sequence,
        "name": f"{clip.run.sequence}: {caption(clip)}",
        "folder": clip.folder,
        "fps": clip.run.fps,
        "techniques": clip.run.techniques,
        "frames": clip.frames,
        "region": clip.region,
        "shrunk": clip.shrunk,
        "wide": clip.wide,
        "tone": _tone(clip.run, mine),
        "farthest": _farthest(mine),
        "compared": clip.compared,
        "sizes": [clip.sizes[frame] for frame in clip.frames],
        "pictures": {name: [texts[frame] for frame in clip.frames] for name, texts in clip.pictures.items()},
        "errors": {name: [texts[frame] for frame in clip.frames] for name, texts in clip.errors.items()},
        "squared": {name: [by_frame.get(name, {}).get(frame) for frame in clip.frames] for name in clip.run.techniques},
        "is": "error" if REFERENCE in clip.run.techniques else "change",
        "worst": {name: next(iter(rows)) for name, rows in by_frame.items() if rows},
    }


def _tone(run: Run, entries: Sequence[Mapping[str, Any]]) -> str:
    """The tone map by which the scores saw the pictures, else that of the sequence's [display]; "none" clips."""
    shown = [entry["display"] for entry in entries if "display" in entry] or [run.settings.get("display", {})]
    return str(shown[0].get("tone_map", "none"))


def _farthest(entries: Sequence[Mapping[str, Any]]) -> str:
    """The technique that errs most, or without errors flickers most; "" where neither is known."""
    for score in ("budget.mse", "frame.mse", "residual.flicker"):
        known = [each for each in entries if score in each["scores"] and each["technique"] != REFERENCE]
        if known:
            return str(max(known, key=lambda each: float(each["scores"][score]))["technique"])
    return ""
