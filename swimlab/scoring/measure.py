"""Measuring a run folder: its record says what it holds, its techniques are scored, the scores become files."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from metrics.display import Domain
from swimlab.footage.brought import requests_of
from swimlab.runs.record import REFERENCE, Record, RunError
from swimlab.runs.scores import write_scores
from swimlab.scoring.brought import measure_brought
from swimlab.scoring.kept import kept_entries, keys_of, standing
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

    Scores that are there already, of the same pictures, settings and code, are kept as they are.
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
    if record.resizes and viewing:
        raise RunError(f"--{next(iter(viewing)).replace('_', '-')}: frames of different sizes have no visibility")
    tests = [name for name in record.techniques if name != REFERENCE]
    record.sequence["viewing"] = record.sequence.get("viewing", {}) | dict(viewing or {})
    keys = {} if peers else keys_of(run, record, tests, domain=domain, device=device)
    kept = kept_entries(run, keys)
    missing = [name for name in tests if name not in kept]
    for name in kept:
        advance(name)
    if not missing and (there := standing(run, record, [kept[name] for name in tests], domain)) is not None:
        return there
    measured = measure_techniques(run, record, missing, domain=domain, peers=peers, device=device, advance=advance)
    found = kept | {
        name: entry | ({"key": keys[name]} if name in keys else {})
        for name, entry in zip(missing, measured, strict=True)
    }
    return write_scores(run, record, [found[name] for name in tests], domain=domain, command=command)
