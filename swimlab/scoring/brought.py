"""Brought frames in, a run folder out: requests of builds are measured, record and scores are written."""

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from swimlab.footage.brought import record_of, settings_of
from swimlab.footage.builds import of_same_frames, open_builds
from swimlab.footage.request import Request
from swimlab.footage.sources import Inputs, check_unchanged, files_of, find_inputs, hash_inputs
from swimlab.footage.subject import Subject
from swimlab.runs.record import Record, RunError
from swimlab.runs.scores import read_scores, refuse_rendered, write_brought
from swimlab.scoring.footage import measure_builds
from swimlab.scoring.kept import keep, kept_entries, keys_of_builds

Say = Callable[[str], None]

STORE = "measured"
"""Folder of a run in which builds that are measured wait for the others."""


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
    store: Path | None = None,
    known: Inputs = MappingProxyType({}),
) -> dict[str, Any]:
    """Measure builds by name, write them as a run folder, and return the content of scores.json.

    run: None: nothing is written; else builds that it has scores of are not measured again, if files, settings and code
    are the same. begin: called with the opened builds that are to be measured. store: folder of entries by key, in
    which builds may be measured already; None: one that lasts until all are. known: inputs whose hashes are known. The
    rest as `open_builds` and `measure_builds` take it, and raises as they do; RunError where the folder holds a
    rendered run, FrameError for all inputs that are not there at once, and for a file that changes while it is
    measured.
    """
    found = find_inputs(requests)
    requests = of_same_frames(requests)
    if run is None:
        builds = open_builds(requests, say, warn)
        begin(builds)
        return measure_builds(builds, sequence=sequence, peers=peers, device=device, command=command, advance=advance)
    refuse_rendered(run)
    name = sequence or next(iter(requests.values())).name
    earlier = Record.read(run) if (run / "run.json").is_file() else None
    inputs = hash_inputs(found, files_of(known or ({} if earlier is None else earlier.inputs)))
    keys = {} if peers else keys_of_builds(requests, inputs, device=device)
    entries = store or run / STORE
    kept = kept_entries(run, keys, entries)
    scores = None
    if earlier is not None and len(kept) == len(requests):
        scores = _standing(run, earlier, name, requests, inputs, keys)
    if scores is not None:
        _tell(scores["sequences"], say, warn)
        return scores
    builds = open_builds(requests, say, warn, pictures=run)
    missing = {build: subject for build, subject in builds.items() if build not in kept}
    if missing:
        begin(missing)

    def done(build: str, entry: Mapping[str, Any]) -> None:
        check_unchanged(inputs_of(build, requests, inputs), when="while it was measured")
        if build in keys:
            keep(entries, keys[build], entry)

    scores = measure_builds(
        builds, sequence=name, kept=kept, peers=peers, device=device, command=command, advance=advance, done=done
    )
    for entry in scores["sequences"]:
        entry |= {"key": keys[entry["technique"]]} if keys else {}
    write_brought(run, record_of(name, builds, scores["provenance"], inputs), scores)
    if store is None:
        shutil.rmtree(entries, ignore_errors=True)
    return scores


def inputs_of(build: str, requests: Mapping[str, Request], inputs: Inputs) -> Inputs:
    """The inputs of one build: its own, and those that builds share."""
    return {what: given for what, given in inputs.items() if what == build or what not in requests}


def _standing(
    run: Path, earlier: Record, name: str, requests: Mapping[str, Request], inputs: Inputs, keys: Mapping[str, str]
) -> dict[str, Any] | None:
    """The run's scores where they and its record are of these requests and files already.

    Files that were only touched since are noted in the record.
    """
    try:
        scores = read_scores(run)
        of = [(entry["sequence"], entry["technique"], entry["key"]) for entry in scores["sequences"]]
        if scores["provenance"]["hash"] != earlier.hash or of != [(name, build, keys[build]) for build in requests]:
            return None
    except (RunError, KeyError, TypeError):
        return None
    if earlier.settings != json.loads(json.dumps(settings_of(requests))) or not (run / "frames.csv").is_file():
        return None
    if earlier.inputs != inputs:
        earlier.inputs = {what: dict(given) for what, given in inputs.items()}
        earlier.write(run)
    return scores


def _tell(entries: Sequence[Mapping[str, Any]], say: Say, warn: Say) -> None:
    """Say again what was said when the entries were measured: what is of all builds once."""
    said = {text: entry for entry in reversed(entries) for text in entry["notes"]}
    for entry in entries:
        for text in entry["notes"]:
            if said[text] is entry:
                told = warn if text in entry.get("warnings", ()) else say
                told(f"{entry['technique']}: {text}" if len(entries) > 1 else text)
