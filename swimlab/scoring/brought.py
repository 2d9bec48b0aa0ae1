"""Brought frames in, a run folder out: requests of builds are measured, record and scores are written."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from swimlab.footage.brought import record_of
from swimlab.footage.builds import open_builds
from swimlab.footage.request import Request
from swimlab.footage.subject import Subject
from swimlab.runs.scores import refuse_rendered, write_brought
from swimlab.scoring.footage import measure_builds

Say = Callable[[str], None]


def measure_brought(
    requests: Mapping[str, Request],
    run: Path | None,
    *,
    sequence: str | None = None,
    peers: Sequence[str] = (),
    device: str = "cpu",
    command: str = "",
    say: Say = lambda _: None,
    warn: Say = lambda _: None,
    begin: Callable[[Mapping[str, Subject]], None] = lambda _: None,
    advance: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Measure builds by name, write them as a run folder, and return the content of scores.json.

    run: None: nothing is written. begin: called with the opened builds before they are measured. The rest as
    `open_builds` and `measure_builds` take it, and raises as they do; RunError where the folder holds a rendered run.
    """
    if run is not None:
        refuse_rendered(run)
    builds = open_builds(requests, say, warn, pictures=run)
    begin(builds)
    scores = measure_builds(builds, sequence=sequence, peers=peers, device=device, command=command, advance=advance)
    if run is not None:
        write_brought(run, record_of(scores["sequences"][0]["sequence"], builds, scores["provenance"]), scores)
    return scores
