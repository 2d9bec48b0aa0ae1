"""`swimlab info`."""

import json
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def info_command(what: str, /, *, json_output: Annotated[bool, Parameter(name="--json", negative="")] = False) -> int:
    """Say what a sequence, a run folder or frames of your own hold.

    Parameters
    ----------
    what:
        A run folder, the name of a sequence in the library, a .toml file; or frames: a pattern, a folder, a file.
    json_output:
        Print it as JSON, a run folder's run.json in full.
    """
    from swimlab.footage.pattern import holds_frames
    from swimlab.record import Record

    if json_output:
        print(json.dumps(_as_json(what), indent=1, allow_nan=False))
        return 0
    if holds_frames(what):
        print_frames(what)
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
    print(f"samples     {record.settings['samples']} a pixel of the reference")
    for name, time in record.times.items():
        print(f"time        {name}: {time['ms_per_frame']:.1f} ms a frame")
    for key, value in record.provenance.items():
        print(f"{key:<11} {value}")
    print(f"measured    {'yes' if (Path(what) / 'scores.json').is_file() else 'no'}")
    return 0


def _as_json(what: str) -> dict[str, Any]:
    from swimlab.footage.describe import describe
    from swimlab.footage.pattern import holds_frames
    from swimlab.plan import load_sequence
    from swimlab.record import Record

    if holds_frames(what):
        return dict(describe(what))
    if not Path(what).is_dir():
        return load_sequence(what).model_dump(mode="json")
    return {**vars(Record.read(Path(what))), "measured": (Path(what) / "scores.json").is_file()}


def print_frames(name: str) -> None:
    """Print what frames were taken for: range, channels, size, type, colour space, motion convention."""
    from swimlab.footage.describe import describe

    for heading, value in describe(name):
        print(f"{heading:<11} {value}")


def print_sequence(name: str) -> None:
    """Print a sequence with every default filled in, as TOML-like lines of key = value."""
    from swimlab.plan import load_sequence

    def walk(table: dict[str, object], prefix: str) -> None:
        for key, value in table.items():
            if isinstance(value, dict):
                walk(value, f"{prefix}{key}.")
            elif value is not None:
                print(f"{prefix}{key} = {json.dumps(value)}")

    walk(load_sequence(name).model_dump(mode="json"), "")
