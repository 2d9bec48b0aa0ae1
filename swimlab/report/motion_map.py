"""What is known of the motion of brought frames: how well it fits them, and where it does not."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from swimlab.footage.check.picture import marked
from swimlab.footage.pattern import frame_range
from swimlab.report.charts import drawing, number
from swimlab.report.clips import shrink
from swimlab.report.figures import Figure
from swimlab.report.heat import image
from swimlab.report.recorded import Run
from swimlab.runs.record import REFERENCE

WIDTH = 420

TITLE = "Where the motion does not fit"
VERDICTS = {
    "verified": "fits the frames",
    "partly": "fits the frames in part",
    "wrong": "does not fit the frames",
    "unchecked": "could not be checked",
}

Entry = Mapping[str, Any]


def motion_map(run: Run, entries: Sequence[Entry]) -> list[Figure]:
    """A frame of the reference, or of the first build, darkened where the motion fits; none where it fits everywhere.

    Raises FrameError where the frame cannot be read.
    """
    check = _check(entries)
    if "unfit" not in check:
        return []
    frame = run.frames[len(run.frames) // 2]
    name = REFERENCE if REFERENCE in run.techniques else run.techniques[0]
    picture = run.pictures.read(name, frame)[..., :3]
    small = shrink(picture, max(1, picture.shape[1] // WIDTH))
    unfit = np.array([[cell == "1" for cell in row] for row in check["unfit"]])
    height = WIDTH * small.shape[0] / small.shape[1]
    sentence = (
        f"Frame {frame} of {name}: bright is where the motion does not fit all along, {check['unfit_fraction']:.0%} of "
        "what was compared; scores there speak of the motion, not of the pictures."
    )
    svg = drawing((WIDTH, round(height)), TITLE, [image(marked(small, unfit), (0, 0, WIDTH, height))])
    return [Figure(TITLE, svg, sentence, [])]


def checked_motion(entries: Sequence[Entry]) -> str:
    """How well the motion fits, in a sentence or two; empty for rendered frames, whose motion is exact."""
    check = _check(entries)
    if not check:
        return ""
    kind = next(entry["motion"] for entry in entries if "motion_check" in entry)
    told = f"Motion ({kind}) {VERDICTS[check['verdict']]}"
    if check.get("residual") is not None:
        told += f"; between neighbouring frames it leaves {number(check['residual'])} of the change"
    parts = [told + "."]
    for key, words in (
        ("frames", "It does not fit frames {}."),
        ("cuts", "New shots begin with frames {}."),
        ("repeated", "Frames {} show the one before again."),
    ):
        if check.get(key):
            parts.append(words.format(frame_range(check[key])))
    if check.get("jitter"):
        parts.append(f"It has a jitter of {number(check['jitter'])} px rms.")
    return " ".join(parts)


def _check(entries: Sequence[Entry]) -> Mapping[str, Any]:
    return next((entry["motion_check"] for entry in entries if "motion_check" in entry), {})
