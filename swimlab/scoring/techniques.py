"""Scores of a run's techniques, several at a time: clips in, entries of scores.json out."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from metrics import Clip, Measurement, ReferenceFrames, align, measure_scales
from metrics.display import Domain
from metrics.kernels.launch import Launcher
from metrics.machine import cores
from swimlab.footage.colour import quantisation_floor
from swimlab.runs.clips import check_complete, display_of, read_clip, reference_error
from swimlab.runs.frames import Image
from swimlab.runs.record import GEOMETRY, REFERENCE, Record, RunError
from swimlab.scoring.score import entry_of, score_clip

MEMORY = 2_000_000_000
"""Bytes that measuring several techniques at a time may take."""
BYTES_PER_PIXEL = 1500
"""Memory that measuring one clip takes for each pixel of a frame (1300 measured at 640x360, half covered)."""
KEPT_BYTES = 256_000_000
"""Bytes of alignment, and of the reference's frames, that are kept for the next technique; the rest is made again."""


def measure_techniques(
    run: Path,
    record: Record,
    tests: Sequence[str],
    *,
    domain: Domain = "linear",
    peers: Sequence[str] = (),
    device: str = "cpu",
    advance: Callable[[str], None] = lambda _: None,
) -> list[dict[str, Any]]:
    """The entries of scores.json for some techniques of a run, none for none; raises as `measure_run`."""
    if not record.frames:
        raise RunError(f"{run}: holds no finished frame; render it first")
    references = [name for name in record.techniques if name == REFERENCE]
    check_complete(run, [*tests, *references, GEOMETRY], record.frames)
    if record.resizes and peers:
        raise RunError(f"--peers {','.join(peers)}: frames of different sizes are not a clip; leave it out")
    if not tests:
        return []
    score = _scale_scorer(run, record, domain) if record.resizes else _clip_scorer(run, record, domain, peers, device)
    viewed = {} if record.resizes else {"viewing": record.sequence.get("viewing", {})}
    display = display_of(record)
    entries = []
    with ThreadPoolExecutor(_workers(record)) as pool:
        for name, found in zip(tests, pool.map(score, tests), strict=True):
            entry = entry_of(record.sequence["name"], name, found, record.frames, domain=domain, display=display)
            entries.append(entry | viewed)
            advance(name)
    return entries


def _clip_scorer(
    run: Path, record: Record, domain: Domain, peers: Sequence[str], device: str
) -> Callable[[str], Measurement]:
    """What measures all frames of a technique as one clip; the techniques share their alignment."""
    frames = record.frames
    width, height = record.sequence["size"]
    geometry = read_clip(run, record, record.techniques[0], frames)
    fits = len(frames) * width * height * 8 < KEPT_BYTES
    shared = align(geometry, launcher=Launcher(device=device)) if fits else None
    display = display_of(record)
    exact = None
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
        floors = [rounding(test.frame(t)) for t in sampled]
        return score_clip(
            test,
            exact,
            domain=domain,
            display=display,
            rounding=floors,
            peers=peers,
            alignment=shared,
            threads=1,
            device=device,
        )

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
    return max(1, min(cores(), fit))
