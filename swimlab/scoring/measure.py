"""Measuring a run folder: its record says what it holds, its techniques are scored, the scores become files."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from metrics.display import Domain
from swimlab.footage.brought import requests_of
from swimlab.runs.record import REFERENCE, Record
from swimlab.runs.scores import write_scores
from swimlab.scoring.brought import measure_brought
from swimlab.scoring.techniques import measure_techniques


def measure_run(
    run: Path,
    *,
    domain: Domain = "linear",
    peers: Sequence[str] = (),
    viewing: Mapping[str, float] | None = None,
    device: str = "cpu",
    command: str = "",
    advance: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Score every technique of a run, write scores.json and frames.csv into its folder, and return the former.

    peers: metrics of other projects to add, by name (see `scoring.peer`). viewing: what replaces pixels_per_degree and
    luminance of the sequence's [viewing]. device: as `metrics.measure` takes it. `advance` is called with a technique's
    name after each. Raises RunError where the folder holds no run or no pictures, FrameError where one is missing or
    damaged, ClipError where one cannot be measured, and PeerError for a peer that is not available.
    """
    record = Record.read(run)
    if record.inputs:
        changes: dict[str, Any] = {"domain": domain, **(viewing or {})}
        requests = {name: replace(request, **changes) for name, request in requests_of(record).items()}
        scores = measure_brought(
            requests, run, sequence=record.sequence["name"], peers=peers, device=device, command=command
        )
        for name in requests:
            advance(name)
        return scores
    tests = [name for name in record.techniques if name != REFERENCE]
    entries = measure_techniques(
        run, record, tests, domain=domain, peers=peers, viewing=viewing, device=device, advance=advance
    )
    return write_scores(run, record, entries, domain=domain, command=command)
