"""Measuring a run folder: its files as clips for `metrics`, and the scores as files."""

import csv
import io
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from metrics import Bloom, Clip, Display, Measurement, ReferenceFrames, align, measure, measure_scales, quantisation
from swimlab.footage.colour import quantisation_floor
from swimlab.render.renderer import ERROR, GEOMETRY
from swimlab.render.run import check_complete
from swimlab.runs.files import write_json, write_text
from swimlab.runs.frames import Geometry, Image, frame_path, read_frame, read_geometry
from swimlab.runs.provenance import provenance
from swimlab.runs.record import REFERENCE, VERSION, Record, RunError
from swimlab.scoring.peer_scores import all_peer_scores

Domain = Literal["linear", "display"]

MEMORY = 2_000_000_000
"""Bytes that measuring several techniques at a time may take."""
BYTES_PER_PIXEL = 1500
"""Memory that measuring one clip takes for each pixel of a frame (1300 measured at 640x360, half covered)."""
ALPHA_ROUNDING = 1e-3
"""Alpha is kept as a half: it is 1 within this."""
KEPT_BYTES = 256_000_000
"""Bytes of alignment, and of the reference's frames, that are kept for the next technique; the rest is made anew."""


def measure_run(
    run: Path,
    *,
    domain: Domain = "linear",
    peers: Sequence[str] = (),
    viewing: Mapping[str, float] | None = None,
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Score every technique of a run, write scores.json and frames.csv into its folder, and return the former.

    peers: metrics of other projects to add, by name (see `scoring.peer`). viewing: what replaces pixels_per_degree and
    luminance of the sequence's [viewing]. `advance` is called with a technique's
    name after each. Raises RunError where the folder holds no run or no pictures, FrameError where one is missing or
    damaged, ClipError where one cannot be measured, and PeerError for a peer that cannot be had.
    """
    record = Record.read(run)
    tests = [name for name in record.techniques if name != REFERENCE]
    entries = measure_techniques(run, record, tests, domain=domain, peers=peers, viewing=viewing, advance=advance)
    return write_scores(run, record, entries, domain=domain, command=command)


def measure_techniques(
    run: Path,
    record: Record,
    tests: Sequence[str],
    *,
    domain: Domain = "linear",
    peers: Sequence[str] = (),
    viewing: Mapping[str, float] | None = None,
    advance: Callable[[str], None] = lambda _: None,
) -> list[dict[str, Any]]:
    """The entries of scores.json for some techniques of a run; raises as `measure_run`."""
    if not record.frames:
        raise RunError(f"{run}: holds no finished frame; render it first")
    references = [name for name in record.techniques if name == REFERENCE]
    check_complete(run, [*tests, *references, GEOMETRY], record.frames)
    if record.resizes and peers:
        raise RunError(f"--peers {','.join(peers)}: frames of different sizes are not a clip; leave it out")
    if record.resizes and viewing:
        raise RunError(f"--{next(iter(viewing)).replace('_', '-')}: frames of different sizes have no visibility")
    record.sequence["viewing"] = record.sequence.get("viewing", {}) | dict(viewing or {})
    score = _scale_scorer(run, record, domain) if record.resizes else _clip_scorer(run, record, domain, peers)
    shown: dict[str, Any] = {"display": asdict(display_of(record))} if domain == "display" else {}
    if not record.resizes:
        shown["viewing"] = record.sequence["viewing"]
    entries = []
    with ThreadPoolExecutor(_workers(record)) as pool:
        for name, found in zip(tests, pool.map(score, tests), strict=True):
            entries.append(_entry(record, name, found) | shown)
            advance(name)
    return entries


def write_scores(
    run: Path, record: Record, entries: list[dict[str, Any]], *, domain: Domain, command: str = ""
) -> dict[str, Any]:
    """Write scores.json and frames.csv into a run's folder; return the content of the former."""
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
    values = [key for entry in entries for row in entry["frames"] for key in row]
    columns = list(dict.fromkeys(["sequence", "technique", "frame", *values]))
    text = io.StringIO()
    table = csv.DictWriter(text, columns, lineterminator="\n")
    table.writeheader()
    for entry in entries:
        for row in entry["frames"]:
            table.writerow({"sequence": entry["sequence"], "technique": entry["technique"], **row})
    return text.getvalue()


def _clip_scorer(run: Path, record: Record, domain: Domain, peers: Sequence[str]) -> Callable[[str], Measurement]:
    """What measures all frames of a technique as one clip; the techniques share their alignment."""
    frames = record.frames
    width, height = record.sequence["size"]
    geometry = read_clip(run, record, record.techniques[0], frames)
    shared = align(geometry) if len(frames) * width * height * 8 < KEPT_BYTES else None
    display = display_of(record)
    reference = exact = None
    if REFERENCE in record.techniques:
        reference = read_clip(run, record, REFERENCE, frames)
        error = reference_error(run, frames)
        exact = ReferenceFrames(reference, error=error, domain=domain, display=display, room=KEPT_BYTES)
    sampled = sorted({0, len(frames) // 2, len(frames) - 1})
    stored_as = "half" if record.settings["half"] else "float"

    def rounding(pixels: Image) -> float | None:
        return quantisation_floor(pixels, stored_as=stored_as, space="linear", domain=domain, display=display)

    def score(name: str) -> Measurement:
        test = read_clip(run, record, name, frames)
        found = measure(test, exact, domain=domain, display=display, alignment=shared, threads=1)
        found.scores |= all_peer_scores(peers, test, reference)
        found.merge(quantisation([rounding(test.frame(t)) for t in sampled], len(frames)))
        return found

    return score


def _scale_scorer(run: Path, record: Record, domain: Domain) -> Callable[[str], Measurement]:
    """What measures frames of different sizes as one-frame clips; scales are relative to the first frame's."""
    has_reference = REFERENCE in record.techniques

    def clips(name: str) -> list[Clip]:
        return [read_clip(run, record, name, [frame]) for frame in record.frames]

    references = clips(REFERENCE) if has_reference else None
    display = display_of(record)

    def score(name: str) -> Measurement:
        tests = clips(name)
        heights = [clip.shape[0] for clip in tests]
        scales = [height / heights[0] for height in heights]
        return measure_scales(tests, references, scales, domain=domain, display=display)

    return score


def _workers(record: Record) -> int:
    """Techniques to measure at a time: as many as there are cores for, and memory."""
    width, height = record.sequence["size"]
    fit = MEMORY // int(width * height * BYTES_PER_PIXEL)
    return max(1, min(len(os.sched_getaffinity(0)), fit))


def display_of(record: Record) -> Display:
    """How the run's sequence says that radiance is shown."""
    table = dict(record.sequence.get("display", {}))
    bloom = Bloom(**table.pop("bloom", {}))
    return Display(**table, bloom=bloom, seed=record.sequence["seed"])


def reference_error(run: Path, frames: Sequence[int]) -> Callable[[int], Image]:
    """Half the difference of the reference's two halves, [H, W, 3], by place in `frames`."""
    return lambda t: read_frame(frame_path(run, ERROR, frames[t]))[..., :3]


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
        # A pixel filter wider than a pixel takes in what lies beside the road.
        alpha = read_frame(frame_path(run, REFERENCE, frames[t]))[..., 3]
        return np.where(np.abs(alpha - 1.0) < ALPHA_ROUNDING, covered, 0.0).astype(np.float32)

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


def _uniform_motion(record: Record, frames: list[int]) -> tuple[float, float] | None:
    """The clip's motion, px a frame of the clip, where the whole picture moves alike.

    Raises RunError where it does not and frames are left out: the motion fields join each frame to the one before it.
    """
    steps = {after - before for before, after in pairwise(frames)}
    if record.uniform_velocity is not None and len(steps) <= 1:
        step = max(steps, default=1)
        return step * record.uniform_velocity[0], step * record.uniform_velocity[1]
    if steps - {1}:
        raise RunError("frames are left out, and their motion with them; render every frame of the range")
    return None


def _entry(record: Record, technique: str, found: Measurement) -> dict[str, Any]:
    frames = [{**row, "frame": record.frames[row["frame"]]} for row in found.frames]
    return {
        "sequence": record.sequence["name"],
        "technique": technique,
        "scores": found.scores,
        "errors": found.errors,
        "replicates": found.replicates,
        "absent": found.absent,
        "frames": frames,
        "curves": found.curves,
        "notes": found.notes,
    }
