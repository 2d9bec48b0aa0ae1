"""A run of brought frames: its record, and what that record asks to measure again."""

import os
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from swimlab.footage.request import ESTIMATE, Request
from swimlab.footage.subject import Subject
from swimlab.runs.record import REFERENCE, Record


def record_of(
    sequence: str, builds: Mapping[str, Subject], provenance: Mapping[str, Any], inputs: Mapping[str, Any]
) -> Record:
    """What run.json holds of builds of a shot. provenance: as the scores have it, with the settings hash.

    inputs: as `hash_inputs` gives them.
    """
    first = next(iter(builds.values()))
    height, width = first.test.shape
    kept = sorted(set.intersection(*(set(subject.kept) for subject in builds.values())))
    requests = {name: subject.request for name, subject in builds.items()}
    viewing = {"pixels_per_degree": first.request.pixels_per_degree, "luminance": first.request.luminance}
    about = {key: value for key, value in provenance.items() if key not in ("hash", "settings", "domain")}
    velocity = first.request.velocity if first.motion_kind == "uniform" else None
    return Record(
        sequence={
            "name": sequence,
            "frames": len(first.test.reader.numbers),
            "fps": first.fps,
            "size": [width, height],
            "motion": {"kind": first.motion_kind},
            "viewing": {key: value for key, value in viewing.items() if value is not None},
            "builds": {name: _about(subject) for name, subject in builds.items()},
        },
        settings=settings_of(requests),
        hash=provenance["hash"],
        uniform_velocity=velocity,
        resizes=False,
        provenance=about,
        techniques=[*builds, *([REFERENCE] if first.reference is not None else [])],
        frames=[first.test.reader.numbers[index] for index in kept],
        inputs=dict(inputs),
    )


def requests_of(record: Record) -> dict[str, Request]:
    """What was asked to measure of each build; names are absolute."""
    return TypeAdapter(dict[str, Request]).validate_python(record.settings["requests"])


def settings_of(requests: Mapping[str, Request]) -> dict[str, Any]:
    """What a record's settings hold of requests: all of them as plain values."""
    return {"requests": {name: asdict(from_anywhere(request)) for name, request in requests.items()}}


def from_anywhere(request: Request, *, home: str | None = None) -> Request:
    """The request with absolute names, or with `home` with names that are relative to this folder."""
    named = {name: getattr(request, name) for name in ("test", "reference", "mask", "depth", "motion_mask")}
    named["motion"] = request.motion if request.velocity is None else None
    named["motion_jitter"] = request.motion_jitter
    files: dict[str, Any] = {
        name: placed(value, home) for name, value in named.items() if value not in (None, ESTIMATE)
    }
    return replace(request, **files)


def placed(name: str, home: str | None) -> str:
    """The absolute name of a file, or with `home` its name relative to this folder."""
    return str(Path(name).absolute()) if home is None else os.path.relpath(name, home)


def _about(subject: Subject) -> dict[str, Any]:
    source = subject.test
    return {"channels": list(source.channels), "stored_as": source.stored_as, "colour_space": source.space}
