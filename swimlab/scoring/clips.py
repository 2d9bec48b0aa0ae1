"""A technique of a run folder as a clip, rendered or brought."""

from dataclasses import replace
from pathlib import Path

from metrics import Clip
from swimlab.footage.brought import requests_of
from swimlab.footage.sources import check_unchanged
from swimlab.footage.subject import Subject
from swimlab.runs.clips import read_clip
from swimlab.runs.record import REFERENCE, Record


def run_clip(run: Path, record: Record, technique: str) -> Clip:
    """All frames of a technique, or of the reference, with motion, coverage and depth.

    Raises FrameError where brought frames are gone or have changed.
    """
    if not record.inputs:
        return read_clip(run, record, technique, list(record.frames))
    check_unchanged(record.inputs)
    requests = requests_of(record)
    name = next(iter(requests)) if technique == REFERENCE else technique
    subject = Subject(requests[name], lambda _: None, lambda _: None)
    test, reference = subject.clips()
    return replace(test, frame=reference.frame) if technique == REFERENCE and reference is not None else test
