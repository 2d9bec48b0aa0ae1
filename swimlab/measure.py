"""Measuring a run folder: its files as clips for `metrics`, and the scores as files."""

import csv
import io
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from metrics import Clip, Measurement, measure, measure_scales
from swimlab.files import write_json, write_text
from swimlab.frames import Image, frame_path, read_frame, read_geometry
from swimlab.record import VERSION, Record, RunError, provenance
from swimlab.run import ERROR, GEOMETRY, check_complete

Domain = Literal["linear", "display"]

REFERENCE = "reference"


def measure_run(
    run: Path,
    *,
    domain: Domain = "linear",
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Score every technique of a run, write scores.json and frames.csv into its folder, and return the former.

    `advance` is called with a technique's name after each. Raises RunError where the folder holds no run or no
    pictures, FrameError where one is missing or damaged, and ClipError where one cannot be measured.
    """
    record = Record.read(run)
    if not record.frames:
        raise RunError(f"{run}: holds no finished frame; render it first")
    tests = [name for name in record.techniques if name != REFERENCE]
    has_reference = REFERENCE in record.techniques
    names = [*tests, REFERENCE] if has_reference else tests
    check_complete(run, [*names, GEOMETRY], record.frames)
    entries = []
    for name in tests:
        score = _score_scales if record.resizes else _score_clip
        found = score(run, record, name, has_reference=has_reference, domain=domain)
        entries.append(_entry(record, name, found))
        advance(name)
    scores = {
        "version": VERSION,
        "provenance": {**provenance(command), "domain": domain, "hash": record.hash, "rendering": record.provenance},
        "sequences": entries,
    }
    write_json(run / "scores.json", scores)
    write_text(run / "frames.csv", frames_table(entries))
    return scores


def frames_table(entries: list[dict[str, Any]]) -> str:
    """The per-frame values of all entries as CSV: sequence, technique, frame and one column a value."""
    columns = ["sequence", "technique", "frame"]
    for entry in entries:
        columns += [key for row in entry["frames"] for key in row if key not in columns]
    text = io.StringIO()
    table = csv.DictWriter(text, columns, lineterminator="\n")
    table.writeheader()
    for entry in entries:
        for row in entry["frames"]:
            table.writerow({"sequence": entry["sequence"], "technique": entry["technique"], **row})
    return text.getvalue()


def _score_clip(run: Path, record: Record, name: str, *, has_reference: bool, domain: Domain) -> Measurement:
    """Measure all frames of a technique as one clip."""
    test = _clip(run, record, name, record.frames)
    if not has_reference:
        return measure(test, None, domain=domain)
    return measure(
        test,
        _clip(run, record, REFERENCE, record.frames),
        domain=domain,
        reference_error=lambda t: read_frame(frame_path(run, ERROR, record.frames[t]))[..., :3],
    )


def _score_scales(run: Path, record: Record, name: str, *, has_reference: bool, domain: Domain) -> Measurement:
    """Measure frames of different sizes as one-frame clips; scales are relative to the first, which is the largest."""
    tests = [_clip(run, record, name, [frame]) for frame in record.frames]
    references = [_clip(run, record, REFERENCE, [frame]) for frame in record.frames] if has_reference else None
    heights = [clip.shape[0] for clip in tests]
    return measure_scales(tests, references, [height / heights[0] for height in heights], domain=domain)


def _clip(run: Path, record: Record, name: str, frames: list[int]) -> Clip:
    def picture(t: int) -> Image:
        return read_frame(frame_path(run, name, frames[t]))[..., :3]

    def geometry(t: int) -> Path:
        return frame_path(run, GEOMETRY, frames[t])

    return Clip(
        frame=picture,
        count=len(frames),
        fps=record.sequence["fps"],
        motion=_motion(run, record, frames),
        coverage=lambda t: read_geometry(geometry(t)).coverage,
        depth=lambda t: read_geometry(geometry(t)).depth,
    )


def _motion(run: Path, record: Record, frames: list[int]) -> Any:
    """The clip's motion: exact where the whole picture moves alike, else the rendered fields.

    Raises RunError where frames are left out, as the fields join each frame to the one just before it.
    """
    steps = {after - before for before, after in pairwise(frames)}
    if record.uniform_velocity is not None and len(steps) <= 1:
        step = next(iter(steps), 1)
        return tuple(step * speed for speed in record.uniform_velocity)
    if steps - {1}:
        raise RunError(f"{run}: frames are left out; motion needs every frame of a range, render them too")
    return lambda t: read_geometry(frame_path(run, GEOMETRY, frames[t])).motion


def _entry(record: Record, technique: str, found: Measurement) -> dict[str, Any]:
    frames = [{**row, "frame": record.frames[row["frame"]]} for row in found.frames]
    return {
        "sequence": record.sequence["name"],
        "technique": technique,
        "scores": found.scores,
        "absent": found.absent,
        "frames": frames,
        "curves": found.curves,
        "notes": found.notes,
    }
