"""`swimlab info`."""

import json
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from swimlab.footage.describe import describe
from swimlab.footage.pattern import holds_frames
from swimlab.footage.shot import is_shot, load_shot
from swimlab.footage.sources import changes
from swimlab.render.plan import load_sequence
from swimlab.report.sentences import listed, notes_of
from swimlab.runs.beside import read_current
from swimlab.runs.counting import counted
from swimlab.runs.entries import read_entries
from swimlab.runs.record import Record, RunError
from swimlab.runs.scores import read_scores


def info_command(what: str, /, *, json_output: Annotated[bool, Parameter(name="--json", negative="")] = False) -> int:
    """Say what a sequence, a run folder or frames of your own hold.

    Parameters
    ----------
    what:
        A run folder, a folder or file of scores, the name of a sequence in the library, a .toml file; or frames: a
        pattern, a folder, a file. Bad frames end with exit code 2.
    json_output:
        Print it as JSON, a run folder's run.json in full.
    """
    if json_output:
        content = _as_json(what)
        print(json.dumps(content, indent=1, allow_nan=False))
        return 2 if content.get("bad frames") else 0
    if holds_frames(what):
        return print_frames(what)
    if _holds_scores(Path(what)):
        print_scores_of(Path(what))
        return 0
    if not Path(what).is_dir():
        print_sequence(what)
        return 0
    record = Record.read(Path(what))
    size = "{}x{}".format(*record.sequence["size"])
    print(f"run of      {record.sequence['name']}, {record.sequence['motion']['kind']}, {size}")
    print(f"hash        {record.hash}")
    print(f"techniques  {', '.join(record.techniques) or 'none yet'}")
    print(f"frames      {len(record.frames)} of {record.sequence['frames']}")
    if "samples" in record.settings:
        print(f"samples     {record.settings['samples']} a pixel of the reference")
    for name, given in record.inputs.items():
        print(f"input       {name}: {given['name']}, {counted(len(given['files']), 'file')}")
    for text in changes(record.inputs):
        print(f"beware      {text}")
    if record.inputs and (Path(what) / "scores.json").is_file():
        print_scores_of(Path(what))
        return 0
    for name, time in record.times.items():
        print(f"time        {name}: {time['ms_per_frame']:.1f} ms a frame")
    for key, value in record.provenance.items():
        print(f"{key:<11} {value}")
    older = _why_unmeasured(Path(what))
    print(f"measured    {'yes' if not older else f'no: {older}'}")
    return 0


def _as_json(what: str) -> dict[str, Any]:
    if holds_frames(what):
        lines, bad = describe(what)
        return {**dict(lines), "bad frames": bad}
    if _holds_scores(Path(what)):
        return read_scores(Path(what))
    if not Path(what).is_dir():
        return _described(what)
    record = Record.read(Path(what))
    changed = {"changes": list(changes(record.inputs))} if record.inputs else {}
    return {**vars(record), "measured": not _why_unmeasured(Path(what)), **changed}


def _why_unmeasured(run: Path) -> str:
    """Why there are no scores of what a run folder holds; empty where there are."""
    try:
        read_current(run)
    except RunError as error:
        return str(error)
    return ""


def print_frames(name: str) -> int:
    """Print what frames were taken for: range, channels, size, type, colour space, motion convention.

    Returns 2 where frames are bad, else 0.
    """
    lines, bad = describe(name)
    for heading, value in [*lines, *(("bad frame", problem) for problem in bad)]:
        print(f"{heading:<11} {value}")
    return 2 if bad else 0


def _holds_scores(path: Path) -> bool:
    """Whether it is a file of scores, or a folder of them that is no run."""
    if path.is_dir():
        return (path / "scores.json").is_file() and not (path / "run.json").exists()
    return path.suffix == ".json" and path.is_file()


def print_scores_of(path: Path) -> None:
    """Print of what and under which settings scores were measured, and what a reader should know beside them."""

    content = read_scores(path)
    measured: dict[tuple[str, str, str], list[str]] = {}
    for entry in read_entries(path):
        settings = entry.settings
        measured.setdefault((entry.sequence, settings.extent, settings.domain), []).append(entry.technique)
    for (sequence, extent, domain), techniques in measured.items():
        frames = extent if extent.endswith("scales") else f"frames {extent}"
        print(f"scores of   {sequence}, {frames}, {domain}: {', '.join(techniques)}")
    for key, value in content["provenance"].items():
        if key != "domain" and not isinstance(value, dict):
            print(f"{key:<11} {value}")
    by_sequence: dict[str, list[dict[str, Any]]] = {}
    for entry in content["sequences"]:
        by_sequence.setdefault(entry["sequence"], []).append(entry)
    for sequence, entries in by_sequence.items():
        where = f" on {sequence}" if len(by_sequence) > 1 else ""
        for note, names in notes_of(entries).items():
            print(f"note        {names or listed(entry['technique'] for entry in entries)}{where}: {note}")


def print_sequence(name: str) -> None:
    """Print a sequence with every default filled in, as TOML-like lines of key = value."""

    def walk(table: dict[str, object], prefix: str) -> None:
        for key, value in table.items():
            if isinstance(value, dict):
                walk(value, f"{prefix}{key}.")
            elif value is not None:
                print(f"{prefix}{key} = {json.dumps(value)}")

    walk(_described(name), "")


def _described(name: str) -> dict[str, Any]:
    """A sequence or shot file with every default filled in."""
    if is_shot(name):
        return load_shot(Path(name)).model_dump(mode="json", exclude_none=True)
    return load_sequence(name).model_dump(mode="json")
