"""Temporal profiles: one row of pixels stacked over time, x across and time down, for every technique of a run."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swimlab.report.charts import drawing, drawn_text
from swimlab.report.display import srgb
from swimlab.report.figures import Figure
from swimlab.report.heat import UNKNOWN, image
from swimlab.report.recorded import Run
from swimlab.runs.frames import Image
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
LEAST_HEIGHT = 24


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
    moves = [("screen", (0.0, 0.0))]
    if run.uniform_velocity is not None and all(after - before == 1 for before, after in pairwise(frames)):
        moves.append(("surface", run.uniform_velocity))
    across = (WIDTH - GAP * (len(moves) - 1)) / len(moves)
    high = max(LEAST_HEIGHT, len(frames) * across / width)
    body = []
    for place, name in enumerate(run.techniques):
        top = place * (HEAD + high)
        stacks = profile(run, name, y, (left, left + width), [velocity for _, velocity in moves])
        for column, ((where, _), codes) in enumerate(zip(moves, stacks, strict=True)):
            start = column * (across + GAP)
            body.append(drawn_text(start, top + HEAD - 5, f"{name}, {where}", "start"))
            body.append(image(codes, (start, top + HEAD, start + across, top + HEAD + high)))
    size = (WIDTH, math.ceil(len(run.techniques) * (HEAD + high)))
    surface = (
        "on the moving surface what is glued to it stands upright, and what flickers breaks up"
        if len(moves) > 1
        else "no one motion of all frames is known, so the surface is not followed here"
    )
    sentence = (
        f"Row {y}, columns {left} to {left + width - 1}, {why}; x across, time down, "
        f"frames {frames[0]} to {frames[-1]} of {len(run.frames)}, in sRGB at exposure 0. "
        f"On the screen what moves is slanted; {surface}. Grey is not measured."
    )
    return [Figure("Temporal profiles", drawing(size, "Temporal profiles", body), sentence, [])]


def profile(
    run: Run, technique: str, y: int, columns: tuple[int, int], velocities: Sequence[tuple[float, float]]
) -> NDArray[np.uint8]:
    """A row of pixels in every frame shown under several motions, [motions, frames, columns, 3] sRGB codes.

    y, columns: of the middle frame, first..end-1. velocities: px a frame that the row moves by, read between pixels
    linearly; what is outside the picture or has no alpha is grey. Each frame is read once.
    """
    frames = run.frames[:FRAMES]
    middle = frames[len(frames) // 2]
    height = run.settings["size"][1]
    found = np.full((len(velocities), len(frames), columns[1] - columns[0], 3), UNKNOWN, np.uint8)
    for place, frame in enumerate(frames):
        moved = [((frame - middle) * dx, y + (frame - middle) * dy) for dx, dy in velocities]
        inside = [math.floor(row) for _, row in moved if 0 <= math.floor(row) < height]
        if not inside:
            continue
        first = min(inside)
        rows = run.pictures.read(technique, frame, rows=(first, min(max(inside) + 2, height)))
        for motion, (right, row) in enumerate(moved):
            above = math.floor(row)
            if 0 <= above < height:
                below = min(above + 1, height - 1)
                line = _between(rows[above - first], rows[below - first], row - above)
                found[motion, place] = _along(line, np.arange(*columns, dtype=np.float64) + right)
    return found


def _along(row: Image, x: NDArray[Any]) -> NDArray[np.uint8]:
    first = np.floor(x).astype(int)
    inside = (first >= 0) & (np.ceil(x) < len(row))
    low, high = np.clip(first, 0, len(row) - 1), np.clip(first + 1, 0, len(row) - 1)
    pixels = _between(row[low], row[high], (x - first)[:, None])
    known = inside & (pixels[:, 3] > 0)
    return np.where(known[:, None], srgb(pixels[:, :3]), np.array(UNKNOWN)).astype(np.uint8)


def _between(first: Image, second: Image, share: float | NDArray[np.float64]) -> Image:
    return np.asarray(first * (1 - share) + second * share, np.float32)


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
