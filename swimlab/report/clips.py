"""Which pictures the page carries: whole frames, and a detail as a loop beside them, as many as a budget allows."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from swimlab.report.display import BEYOND, error_codes, srgb, webp, wide_codes
from swimlab.report.recorded import Run
from swimlab.runs.frames import Image
from swimlab.runs.record import REFERENCE

BUDGET = 18_500_000
DETAIL_SHARE = 0.45
LEAST_DETAIL, MOST_DETAIL = 96, 160
"""Width of the detail, px: a twelfth of the picture's, but no less and no more. It is two thirds as high."""

SHRUNK = (1, 2, 3, 4)
"""By which whole pictures may be shrunk where not even one has room at its own size."""

Region = tuple[int, int, int, int]


@dataclass
class Clip:
    """Consecutive pictures of every technique in one region (x, y, width, height in px; None: whole frames).

    shrunk: each pixel is the mean of so many rows and columns of the frame's. wide: pictures are coded for radiance
    above 1, as `display.wide_codes` has it. pictures and errors: technique -> base64
    WebP by frame number. sizes: frame number -> (width, height). compared: the techniques that have errors. folder:
    where the pictures are if not in here, relative to the page.
    """

    run: Run
    region: Region | None = None
    shrunk: int = 1
    wide: bool = False
    pictures: dict[str, dict[int, str]] = field(default_factory=dict)
    errors: dict[str, dict[int, str]] = field(default_factory=dict)
    sizes: dict[int, tuple[int, int]] = field(default_factory=dict)
    compared: tuple[str, ...] = ()
    folder: str = ""

    @property
    def frames(self) -> list[int]:
        """Frame numbers, rising."""
        return sorted(self.sizes)

    def size(self) -> int:
        """Bytes of all pictures as base64 text."""
        return sum(len(text) for part in (self.pictures, self.errors) for d in part.values() for text in d.values())

    def merge(self, other: "Clip") -> None:
        """Take over the pictures of another clip of the same run and region."""
        self.sizes |= other.sizes
        self.compared = other.compared
        for mine, theirs in ((self.pictures, other.pictures), (self.errors, other.errors)):
            for technique, texts in theirs.items():
                mine.setdefault(technique, {}).update(texts)


def choose_clips(runs: Sequence[Run], entries: Sequence[Mapping[str, Any]], budget: int = BUDGET) -> list[Clip]:
    """Encode the pictures of the page in at most `budget` bytes, shared evenly; what a run leaves goes on.

    A run of several frames gets a detail over as many of them as fit into DETAIL_SHARE of its share, unless it
    resizes, and whole frames for the rest, shrunk where need be. Clips come in the order of `runs`.
    """
    clips: dict[str, list[Clip]] = {}
    left = budget
    waiting = sorted(runs, key=lambda run: not run.resizes)
    for place, run in enumerate(waiting):
        chosen = _clips_of(run, entries, left // (len(waiting) - place))
        left -= sum(clip.size() for clip in chosen)
        clips[run.sequence] = chosen
    return [clip for run in runs for clip in clips[run.sequence]]


def _clips_of(run: Run, entries: Sequence[Mapping[str, Any]], budget: int) -> list[Clip]:
    order = list(reversed(run.frames)) if run.resizes else outwards(run.frames, liveliest(run, entries))
    wide = is_wide(run, order)
    detail = detail_of(run, order, int(DETAIL_SHARE * budget), wide=wide)
    left = budget - sum(clip.size() for clip in detail)
    tried = (fill(Clip(run, shrunk=shrunk, wide=wide), order, left) for shrunk in SHRUNK)
    whole = next((clip for clip in tried if clip.sizes), None)
    return [*([whole] if whole is not None else []), *detail]


def is_wide(run: Run, order: Sequence[int]) -> bool:
    """Whether a picture is brighter than 1 in the first, the middle or the last of the frames, in the order given."""
    probed = {order[0], order[len(order) // 2], order[-1]}
    return any((_read(run, name, frame, None)[..., :3] > BEYOND).any() for frame in probed for name in run.techniques)


def detail_of(run: Run, order: Sequence[int], budget: int, *, wide: bool) -> list[Clip]:
    """The detail in which pictures differ most, frames in the given order; none where it would not move or not fit."""
    if run.resizes or len(order) < 2:
        return []
    width = min(MOST_DETAIL, max(LEAST_DETAIL, run.settings["size"][0] // 12))
    clip = fill(Clip(run, disputed_region(run, order[0], (width, width * 2 // 3)), wide=wide), order, budget)
    return [clip] if len(clip.sizes) > 1 else []


def fill(clip: Clip, order: Iterable[int], budget: int) -> Clip:
    """Encode frames into a clip in the given order until the next one would go over the budget."""
    used = 0
    for frame in order:
        step = encode(clip, frame)
        used += step.size()
        if used > budget:
            break
        clip.merge(step)
    return clip


def encode(clip: Clip, frame: int) -> Clip:
    """One frame of every technique as a clip has it, with its error against the reference where there is one."""
    run, codes = clip.run, wide_codes if clip.wide else srgb
    with ThreadPoolExecutor() as pool:
        read = pool.map(lambda name: shrink(_read(run, name, frame, clip.region), clip.shrunk), run.techniques)
        images = dict(zip(run.techniques, read, strict=True))
        tests = tuple(n for n in run.techniques if n != REFERENCE and REFERENCE in images)
        pictures = pool.map(lambda n: webp(codes(images[n][..., :3])), run.techniques)
        errors = pool.map(lambda n: webp(error_codes(images[n], images[REFERENCE])), tests)
        height, width = images[run.techniques[0]].shape[:2]
        return Clip(
            run,
            pictures={name: {frame: text} for name, text in zip(run.techniques, pictures, strict=True)},
            errors={name: {frame: text} for name, text in zip(tests, errors, strict=True)},
            sizes={frame: (width, height)},
            compared=tests,
        )


def _read(run: Run, technique: str, frame: int, region: Region | None) -> Image:
    if region is None:
        return run.pictures.read(technique, frame)
    x, y, width, height = region
    return run.pictures.read(technique, frame, rows=(y, y + height))[:, x : x + width]


def liveliest(run: Run, entries: Sequence[Mapping[str, Any]]) -> int:
    """The frame in which the errors of all techniques change most; the middle one if no change is known."""
    change = dict.fromkeys(run.frames, 0.0)
    for entry in entries:
        if entry["sequence"] == run.sequence:
            for row in entry.get("frames", []):
                if row.get("change") is not None and row["frame"] in change:
                    change[row["frame"]] += row["change"]
    return max(change, key=lambda frame: change[frame]) if any(change.values()) else run.frames[len(run.frames) // 2]


def outwards(frames: Sequence[int], start: int) -> list[int]:
    """Frames from `start` to the end, then backwards from it: every prefix is a row of consecutive frames."""
    place = list(frames).index(start)
    return [*frames[place:], *reversed(frames[:place])]


def shrink(image: Image, by: int) -> Image:
    """Means of `by` x `by` pixels of [H, W, channels]; what is left of them at the right and below is cut off."""
    height, width = (length // by for length in image.shape[:2])
    cut = image[: height * by, : width * by]
    return np.asarray(cut.reshape(height, by, width, by, -1).mean(axis=(1, 3)), np.float32) if by > 1 else image


def disputed_region(run: Run, frame: int, size: tuple[int, int] = (LEAST_DETAIL, LEAST_DETAIL * 2 // 3)) -> Region:
    """The region (x, y, width, height) of a frame where the pictures of the techniques differ most."""
    stack = np.stack([srgb(_read(run, name, frame, None)[..., :3]).mean(axis=2) for name in run.techniques])
    height, width = stack.shape[1:]
    w, h = min(size[0], width), min(size[1], height)
    spread = stack.std(axis=0)
    around = cv2.boxFilter(spread, -1, (w, h), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
    y, x = np.unravel_index(int(np.argmax(around[: height - h + 1, : width - w + 1])), (height - h + 1, width - w + 1))
    return int(x), int(y), w, h
