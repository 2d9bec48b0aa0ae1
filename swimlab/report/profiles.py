"""Temporal profiles: one row of pixels stacked over time, x across and time down, for every technique of a run."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swimlab.report.charts import drawing, drawn_text
from swimlab.report.display import srgb
from swimlab.report.figures import Figure
from swimlab.report.following import follow, read_at
from swimlab.report.heat import UNKNOWN, image
from swimlab.report.recorded import Run
from swimlab.runs.record import REFERENCE

COLUMNS = 320
"""Pixels of the row that are shown, at most."""

FRAMES = 160
"""Frames that are shown, at most: the first ones."""

PROBED = 4
"""Frames by which the row is chosen, at most."""

WIDTH = 420
HEAD = 18
GAP = 8
LEAST_HEIGHT = 40

UNKNOWN_MOTION = {"none": "no motion is given", "estimated": "its motion is estimated from the frames"}
"""Kind of motion -> why the surface is not followed."""


def profiles(run: Run) -> list[Figure]:
    """The figure of one run; none for a single frame or for frames of several sizes.

    Raises FrameError where a picture cannot be read.
    """
    if len(run.frames) < 2 or run.resizes:
        return []
    frames = run.frames[:FRAMES]
    energy, why = _energy(run)
    y = int(np.argmax(energy.sum(axis=1))) if energy.any() else energy.shape[0] // 2
    width = min(COLUMNS, energy.shape[1])
    sums = np.concatenate([[0.0], np.cumsum(energy[y])])
    left = int(np.argmax(sums[width:] - sums[:-width]))
    anchor = len(frames) // 2
    row = np.stack([np.full(width, float(y)), np.arange(left, left + width, dtype=np.float64)])
    lines = {"screen": np.repeat(row[None], len(frames), axis=0)}
    surface, said = _surface(run, frames, anchor, row)
    if surface is not None:
        lines["surface"] = surface
    across = (WIDTH - GAP * (len(lines) - 1)) / len(lines)
    high = max(LEAST_HEIGHT, len(frames) * across / width)
    body = []
    for place, name in enumerate(run.techniques):
        top = place * (HEAD + high)
        stacks = profile(run, name, frames, list(lines.values()))
        for column, (where, codes) in enumerate(zip(lines, stacks, strict=True)):
            start = column * (across + GAP)
            body.append(drawn_text(start, top + HEAD - 5, f"{name}, {where}", "start"))
            body.append(image(codes, (start, top + HEAD, start + across, top + HEAD + high)))
    size = (WIDTH, math.ceil(len(run.techniques) * (HEAD + high)))
    sentence = (
        f"Row {y}, columns {left} to {left + width - 1}, {why}; x across, time down, "
        f"frames {frames[0]} to {frames[-1]} of {len(run.frames)}, in sRGB at exposure 0. "
        f"On the screen what moves is slanted; {said}."
    )
    return [Figure("Temporal profiles", drawing(size, "Temporal profiles", body), sentence, [])]


def _surface(
    run: Run, frames: Sequence[int], anchor: int, row: NDArray[np.float64]
) -> tuple[NDArray[np.float64] | None, str]:
    """Where the surface of a row of pixels [2, n] of one frame is in all; and what is to be seen, or why not."""
    kind = run.settings["motion"]["kind"]
    glued = "what is glued to it stands upright, and what flickers breaks up"
    steps = {after - before for before, after in pairwise(frames)}
    if kind in UNKNOWN_MOTION:
        return None, f"the surface is not followed here, as {UNKNOWN_MOTION[kind]}. Grey is not measured"
    if run.uniform_velocity is not None and steps == {1}:
        away = (np.array(frames) - frames[anchor])[:, None, None] * np.array(run.uniform_velocity[::-1])[:, None]
        return row + away, f"on the moving surface {glued}. Grey is not measured"
    if steps != {1}:
        return None, "the surface is not followed here, as frames are left out. Grey is not measured"
    followed = follow(row, anchor, frames, run.pictures.motion(frames))
    return followed, (
        f"on the moving surface, which is followed through its vectors from frame {frames[anchor]}, {glued}. "
        "Grey is hidden, out of the picture or not measured"
    )


def profile(run: Run, technique: str, frames: Sequence[int], lines: Sequence[NDArray[np.float64]]) -> NDArray[np.uint8]:
    """Lines of points in every frame, [lines, frames, n, 3] sRGB codes.

    lines: for each, where its points are in each frame, [frames, 2, n] (y, x px), read between pixels linearly; what is
    NaN, outside the picture or without alpha is grey. Each frame is read once.
    """
    height = run.settings["size"][1]
    found = np.full((len(lines), len(frames), lines[0].shape[2], 3), UNKNOWN, np.uint8)
    for place, frame in enumerate(frames):
        y = np.concatenate([line[place, 0] for line in lines])
        inside = y[(y >= 0) & (y <= height - 1)]
        if not len(inside):
            continue
        top = math.floor(inside.min())
        rows = run.pictures.read(technique, frame, rows=(top, min(math.floor(inside.max()) + 2, height)))
        for number, line in enumerate(lines):
            pixels = read_at(rows, line[place], top)
            known = pixels[:, 3] > 0
            found[number, place, known] = srgb(pixels[known, :3])
    return found


def _energy(run: Run) -> tuple[NDArray[np.float64], str]:
    """[H, W] by which the row is chosen, and why, as a part of a sentence."""
    tests = [name for name in run.techniques if name != REFERENCE]
    against = REFERENCE in run.techniques and bool(tests)
    step = max(1, math.ceil((len(run.frames) - 1) / PROBED))
    energy = np.zeros(tuple(reversed(run.settings["size"])))
    for place in range(1, len(run.frames), step):
        frame, before = run.frames[place], run.frames[place - 1]
        shared = run.pictures.read(REFERENCE, frame) if against else None
        for name in tests or run.techniques:
            picture = run.pictures.read(name, frame)
            other = run.pictures.read(name, before) if shared is None else shared
            known = (picture[..., 3] > 0) & (other[..., 3] > 0)
            energy += np.where(known, ((picture - other)[..., :3].astype(np.float64) ** 2).sum(axis=2), 0.0)
    if not energy.any():
        return energy, "the middle, as nothing differs"
    return energy, "where errors are largest" if against else "where pictures change most from frame to frame"
