"""Scores of anyone's frames."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from swimlab.footage.colour import AUTO
from swimlab.footage.request import ESTIMATE
from swimlab.footage.subject import Subject
from swimlab.runs.provenance import provenance
from swimlab.runs.record import VERSION
from swimlab.scoring.score import entry_of, score_clip


def measure_subject(
    subject: Subject,
    *,
    peers: Sequence[str] = (),
    device: str = "cpu",
    command: str = "",
    advance: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Measure frames and return scores in the form of scores.json.

    advance: called with frames done and frames in all. Raises FrameError and ClipError naming the frame that is bad.
    """
    request = subject.request
    clip, reference = subject.clips()
    found = score_clip(
        clip,
        reference,
        domain=request.domain,
        display=request.display,
        rounding=subject.test.quantisation(subject.sampled(), request.domain, request.display),
        peers=peers,
        progress=advance,
        device=device,
    )
    floor = found.scores.get("quantisation.floor")
    if floor is not None:
        text = f"{subject.test.stored_as} codes: quantisation alone makes a flicker of {np.sqrt(floor):.2g} rms"
        subject.note(text)
    for note in found.notes:
        subject.note(note)
    numbers = [subject.test.reader.numbers[index] for index in subject.kept]
    entry = entry_of(subject.name, "test", found, numbers, domain=request.domain, display=request.display)
    checked = subject.checked.entry(lambda index: subject.test.reader.numbers[index])
    entry |= {"motion": subject.motion_kind, "motion_check": checked, "notes": subject.notes}
    settings = _settings(subject)
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:16]
    about = {**provenance(command), "domain": request.domain, "hash": digest, "settings": settings}
    return {"version": VERSION, "provenance": about, "sequences": [entry]}


def _settings(subject: Subject) -> dict[str, Any]:
    """All that decides the scores but for the pixels, and for the display, which stands with the scores."""
    request = subject.request
    chosen = asdict(request)
    look, reference_look, motion_part = chosen["look"], _said(chosen.pop("reference_look")), chosen.pop("motion_part")
    chosen["look"] = _said(look) | {
        "channels": look["channels"],
        "colour_space": look["colour_space"] or AUTO,
        "alpha": look["alpha"] or "ignore",
        "crop": look["crop"],
    }
    chosen |= {"reference_look": reference_look} if reference_look else {}
    chosen |= _said({"motion_part": motion_part})
    for part_of_command in ("test", "reference", "mask", "motion_mask", "unverified", "display"):
        chosen.pop(part_of_command)
    height, width = subject.test.shape
    chosen["motion"] = request.motion if subject.motion_kind == "uniform" else subject.motion_kind
    if subject.motion_kind == "fields":
        chosen |= {"motion_mask": request.motion_mask is not None, "motion_size": subject.motion_size}
    else:
        chosen.pop("convention")
    side = chosen.pop("motion_jitter_in")
    jitter = chosen.pop("motion_jitter")
    if jitter is not None:
        chosen["motion_jitter"] = f"{side}, estimated" if jitter == ESTIMATE else side
    return {
        **chosen,
        "fps": subject.fps,
        "size": [width, height],
        "count": len(subject.kept),
        "channels": list(subject.test.channels),
        "stored_as": subject.test.stored_as,
        "colour_space": subject.test.space,
        "reference": request.reference is not None,
        "mask": request.mask is not None,
        "unverified": request.unverified,
    }


def _said(options: dict[str, Any]) -> dict[str, Any]:
    """The options that are given."""
    return {name: value for name, value in options.items() if value is not None}
