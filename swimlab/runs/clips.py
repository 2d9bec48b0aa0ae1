"""A run folder's files as clips: pictures, motion, coverage and depth, read frame by frame."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from metrics import Bloom, Clip, Display
from swimlab.runs.frames import FrameError, Geometry, Image, frame_path, read_frame, read_geometry
from swimlab.runs.record import ERROR, GEOMETRY, REFERENCE, Record, RunError

ALPHA_ROUNDING = 1e-3
"""Alpha is kept as a half: it is 1 within this."""


def read_clip(run: Path, record: Record, name: str, frames: list[int]) -> Clip:
    """Some frames of a technique of a run as a clip. Raises RunError where they do not follow each other."""

    def picture(t: int) -> Image:
        return read_frame(frame_path(run, name, frames[t]))[..., :3]

    @lru_cache(maxsize=2)
    def geometry(t: int) -> Geometry:
        return read_geometry(frame_path(run, GEOMETRY, frames[t]))

    def coverage(t: int) -> Image:
        covered = geometry(t).coverage
        if REFERENCE not in record.techniques:
            return covered
        return shared_coverage(covered, read_frame(frame_path(run, REFERENCE, frames[t]))[..., 3])

    viewing = record.sequence.get("viewing", {})
    return Clip(
        frame=picture,
        count=len(frames),
        fps=record.sequence["fps"],
        pixels_per_degree=viewing.get("pixels_per_degree"),
        luminance=viewing.get("luminance"),
        motion=_uniform_motion(record, frames) or (lambda t: geometry(t).motion),
        coverage=coverage,
        depth=lambda t: geometry(t).depth,
    )


def shared_coverage(covered: Image, alpha: Image) -> Image:
    """How much of each pixel, [H, W] in 0..1, the surface covers both by the geometry and by the reference's alpha.

    A pixel filter wider than a pixel takes in what lies beside the road: such a pixel is not wholly covered.
    """
    partly = np.minimum(covered, np.clip(alpha, 0.0, 1.0 - ALPHA_ROUNDING))
    return np.where(np.abs(alpha - 1.0) < ALPHA_ROUNDING, covered, partly).astype(np.float32)


def _uniform_motion(record: Record, frames: list[int]) -> tuple[float, float] | None:
    """The clip's motion, px a frame of the clip, where the whole picture moves as one.

    Raises RunError where it does not and frames are left out: the motion fields join each frame to the one before it.
    """
    steps = {after - before for before, after in pairwise(frames)}
    if record.uniform_velocity is not None and len(steps) <= 1:
        step = max(steps, default=1)
        return step * record.uniform_velocity[0], step * record.uniform_velocity[1]
    if steps - {1}:
        raise RunError("frames are left out, and their motion with them; render every frame of the range")
    return None


def reference_error(run: Path, frames: Sequence[int]) -> Callable[[int], Image]:
    """Half the difference of the reference's two halves, [H, W, 3], by place in `frames`."""
    return lambda t: read_frame(frame_path(run, ERROR, frames[t]))[..., :3]


def display_of(record: Record) -> Display:
    """How the run's sequence says that radiance is shown. Raises RunError for a view that no configuration has."""
    return shown_by(record.sequence["name"], record.sequence.get("display", {}), record.sequence["seed"])


def shown_by(name: str, table: Mapping[str, Any], seed: int) -> Display:
    """What a [display] table of a sequence or shot says; seed: of the dither. Raises RunError as `display_of` does."""
    given = dict(table)
    bloom = Bloom(**given.pop("bloom", {}))
    try:
        return Display(**given, bloom=bloom, seed=seed)
    except ValueError as error:
        raise RunError(f"{name}: display: {error}") from error


def check_complete(run: Path, names: Iterable[str], frames: Iterable[int]) -> None:
    """Raise FrameError naming the first picture that a run should hold and does not."""
    needed = [frame_path(run, name, frame) for name in names for frame in frames]
    missing = [path for path in needed if not path.is_file()]
    if missing:
        raise FrameError(f"{missing[0]}: is missing ({len(missing)} in all); give the render command again to resume")
