"""Scores of anyone's frames."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from metrics import Alignment, Measurement, ReferenceFrames, align
from metrics.kernels.launch import Launcher
from swimlab.footage.colour import AS_STORED, AUTO, SRGB
from swimlab.footage.request import ESTIMATE
from swimlab.footage.subject import Subject
from swimlab.runs.configuration import configuration
from swimlab.runs.hashes import hash_of
from swimlab.runs.provenance import provenance
from swimlab.runs.record import VERSION
from swimlab.scoring.score import entry_of, score_clip
from swimlab.scoring.techniques import KEPT_BYTES


def measure_builds(
    builds: Mapping[str, Subject],
    *,
    sequence: str | None = None,
    peers: Sequence[str] = (),
    device: str = "cpu",
    command: str = "",
    advance: Callable[[int, int], None] | None = None,
    kept: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    done: Callable[[str, Mapping[str, Any]], None] = lambda *_: None,
) -> dict[str, Any]:
    """Measure builds of a shot, by name, and return scores in the form of scores.json.

    sequence: the shot's name; None: as the first build's files are called. advance: called with frames done and frames
    in all, for each build. kept: entries of builds that need not be measured. done: called with a build that was
    measured and its entry. Raises FrameError and ClipError naming the frame that is bad.
    """
    first = next(iter(builds.values()))
    called = sequence or first.request.name
    shared: dict[Subject, Shared] = {}
    entries, of_builds = [], {}
    for name, subject in builds.items():
        settings = _settings(subject)
        of_builds[name] = {"hash": hash_of(settings), "settings": settings}
        if name in kept:
            entry = {key: value for key, value in kept[name].items() if key not in of_builds[name]}
            entries.append(entry | {"sequence": called} | _told_anew(entry, subject))
            continue
        if len(builds) - len(kept) > 1 and subject.like not in shared:
            shared[subject.like] = _share(subject.like, device)
        entry = measure_build(
            called, name, subject, shared.get(subject.like), peers=peers, device=device, advance=advance
        )
        done(name, entry)
        entries.append(entry)
    about: dict[str, Any] = {**provenance(command), "domain": first.request.domain}
    if len(builds) == 1:
        about |= of_builds[entries[0]["technique"]]
    else:
        about["hash"] = hash_of({name: each["hash"] for name, each in of_builds.items()})
        entries = [entry | of_builds[entry["technique"]] for entry in entries]
    return {"version": VERSION, "provenance": about, "sequences": entries}


def _told_anew(entry: Mapping[str, Any], subject: Subject) -> dict[str, Any]:
    """What is said of a kept entry: notes on its files come first, and may name them where they were."""
    notes = [*subject.notes, *entry["notes"][len(subject.notes) :]]
    return {"notes": notes} | ({"warnings": subject.warnings} if subject.warnings else {})


class Shared(NamedTuple):
    """What builds of one motion, coverage and reference share: work that is done for the first."""

    alignment: Alignment | None
    reference: ReferenceFrames | None


def _share(subject: Subject, device: str) -> Shared:
    clip, reference = subject.clips()
    height, width = subject.test.shape
    fits = clip.count * width * height * 8 < KEPT_BYTES
    request = subject.request
    exact = None
    if reference is not None:
        exact = ReferenceFrames(reference, domain=request.domain, display=request.display, room=KEPT_BYTES)
    return Shared(align(clip, launcher=Launcher(device=device)) if fits else None, exact)


def measure_build(
    sequence: str,
    name: str,
    subject: Subject,
    shared: Shared | None = None,
    *,
    peers: Sequence[str] = (),
    device: str = "cpu",
    advance: Callable[[int, int], None] | None = None,
    threads: int | None = None,
) -> dict[str, Any]:
    """The entry of scores.json of one build. shared: the same scores sooner, where several builds are measured."""
    request = subject.request
    clip, reference = subject.clips()
    found = score_clip(
        clip,
        shared.reference if shared is not None and shared.reference is not None else reference,
        alignment=None if shared is None else shared.alignment,
        domain=request.domain,
        display=request.display,
        rounding=rounding_of(subject),
        peers=peers,
        progress=advance,
        threads=threads,
        device=device,
    )
    return entry_of_build(sequence, name, subject, found)


def rounding_of(subject: Subject) -> list[float | None]:
    """Mean squared errors of rounding some of its frames to stored codes, radiance^2."""
    return subject.test.quantisation(subject.sampled(), subject.request.domain, subject.request.display)


def entry_of_build(sequence: str, name: str, subject: Subject, found: Measurement) -> dict[str, Any]:
    """The entry of scores.json of a build that is measured."""
    request = subject.request
    floor = found.scores.get("quantisation.floor")
    if floor is not None:
        text = f"{subject.test.stored_as} codes: quantisation alone makes a flicker of {np.sqrt(floor):.2g} rms"
        subject.note(text)
    for note in found.notes:
        subject.note(note)
    numbers = [subject.test.reader.numbers[index] for index in subject.kept]
    entry = entry_of(sequence, name, found, numbers, domain=request.domain, display=request.display)
    checked = subject.checked.entry(lambda index: subject.test.reader.numbers[index])
    told = {"notes": subject.notes} | ({"warnings": subject.warnings} if subject.warnings else {})
    return entry | {"motion": subject.motion_kind, "motion_check": checked, **told}


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
    of_masks = ("mask_channels", "mask_part", "motion_mask_channels", "motion_mask_part")
    chosen |= _said({"motion_part": motion_part} | {name: chosen.pop(name) for name in of_masks})
    depth = {name: chosen.pop(name) for name in ("depth", "depth_channels", "depth_part")}
    chosen |= {"depth": True} | _said({key: depth[key] for key in depth if key != "depth"}) if depth["depth"] else {}
    for part_of_command in ("test", "reference", "mask", "motion_mask", "unverified", "display", "left_out"):
        chosen.pop(part_of_command)
    spaces = {source.space for source in (subject.test, subject.reference) if source is not None}
    if spaces - {AS_STORED, SRGB} and (colour := configuration()) is not None:
        chosen["configuration"] = colour.digest
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
