"""Measuring a run folder: its record says what it holds, its techniques are scored, the scores become files."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from metrics.display import Domain
from swimlab.runs.record import REFERENCE, Record
from swimlab.runs.scores import write_scores
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
    tests = [name for name in record.techniques if name != REFERENCE]
    entries = measure_techniques(
        run, record, tests, domain=domain, peers=peers, viewing=viewing, device=device, advance=advance
    )
    return write_scores(run, record, entries, domain=domain, command=command)
