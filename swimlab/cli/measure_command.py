"""`swimlab measure`."""

import json
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from metrics.display import Domain
from swimlab.cli.footage_options import VIEWING, Footage
from swimlab.cli.score_table import print_scores
from swimlab.cli.terminal import progress
from swimlab.footage.keys import as_keys, in_words_of
from swimlab.footage.request import Request
from swimlab.footage.shot import is_shot, load_shot
from swimlab.footage.subject import Subject
from swimlab.runs.columns import COLUMNS
from swimlab.runs.files import write_json, write_text
from swimlab.runs.record import REFERENCE, Record, RunError
from swimlab.runs.scores import check_output, frames_table, scores_path
from swimlab.scoring.brought import measure_brought
from swimlab.scoring.measure import measure_run


def measure_command(
    run: Path | None = None,
    /,
    *,
    footage: Footage | None = None,
    domain: Domain = "linear",
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    peers: str | None = None,
    device: str = "cpu",
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Measure the techniques of a run folder against its reference, or frames of your own (--test, or a shot file).

    The scores of a run folder are written into it, as scores.json and frames.csv.

    Parameters
    ----------
    run:
        Run folder, or a shot file.
    domain:
        Measure linear radiance, or display codes, as the sequence's [display] says (else exposure 1, clamped, sRGB).
    output:
        Write scores.json, frames.csv and a picture of where the motion does not fit into this folder too; a name that
        ends in .json: the scores, into this file.
    peers:
        Metrics of other projects to add as columns, with commas: flip, flip-oiio, vdp.
    device:
        Where frames are aligned and pixels compared: cpu, or a GPU, as cuda:0.
    json_output:
        Print the scores as JSON instead of a table.
    quiet:
        Show no progress and no notes, only warnings.
    """
    footage = footage or Footage()
    others = tuple(name.strip() for name in peers.split(",")) if peers else ()
    if (run is None) == (footage.test is None and not footage.build):
        raise RunError("measure either a run folder or frames of your own: give RUN or --test, one of them")
    folder = None if output is None or scores_path(output) == output else output
    if output is not None:
        check_output(output)
    if run is not None and is_shot(run):
        _refuse_footage(footage, "a shot file has keys for it")
        shot, viewing = load_shot(run), dict[str, Any](footage.viewing())
        asked = {build: replace(request, **viewing) for build, request in shot.requests(run.parent, domain).items()}
        scores = measure_shot_with_progress(run, asked, folder, shot.name, peers=others, device=device, quiet=quiet)
        run = None
    elif run is not None:
        _refuse_footage(footage, "a run folder knows it by itself")
        scores = measure_with_progress(run, domain, peers=others, viewing=footage.viewing(), device=device, quiet=quiet)
    else:
        scores = measure_brought_with_progress(
            footage.requests(domain), folder, footage.sequence, peers=others, device=device, quiet=quiet
        )
    written = None if output is None else scores_path(output)
    if output is not None and (run is not None or written == output):
        _write(output, scores)
    if json_output:
        print(json.dumps(scores, indent=1, allow_nan=False))
    else:
        print_scores([scores])
        if written is not None:
            print(written)
    return 0


def measure_with_progress(
    run: Path,
    domain: Domain,
    *,
    peers: Sequence[str] = (),
    viewing: Mapping[str, float] | None = None,
    device: str = "cpu",
    quiet: bool,
) -> dict[str, Any]:
    """Measure a run, showing how far it is."""

    record = Record.read(run)
    tests = [name for name in record.techniques if name != REFERENCE]
    with progress(f"measuring {record.sequence['name']}", len(tests), quiet=quiet) as advance:
        command = shlex.join(["swimlab", *sys.argv[1:]])
        return measure_run(
            run, domain=domain, peers=peers, viewing=viewing, device=device, command=command, advance=advance
        )


def measure_brought_with_progress(
    requests: Mapping[str, Request],
    run: Path | None,
    sequence: str | None,
    *,
    peers: Sequence[str] = (),
    device: str = "cpu",
    quiet: bool,
    reword: Callable[[str], str] = str,
) -> dict[str, Any]:
    """Measure builds of the user's own frames, saying on stderr what there is to know beside the scores.

    reword: makes of what is said, which names options, what is to be read.
    """

    def say(text: str) -> None:
        if not quiet:
            print(f"swimlab: {reword(text)}", file=sys.stderr)

    def warn(text: str) -> None:
        print(f"swimlab: warning: {reword(text)}", file=sys.stderr)

    with ExitStack() as stack:
        shown: list[Callable[[str], None]] = []

        def begin(builds: Mapping[str, Subject]) -> None:
            total = sum(len(subject.kept) for subject in builds.values())
            name = sequence or next(iter(builds.values())).request.name
            shown.append(stack.enter_context(progress(f"measuring {name}", total, quiet=quiet)))

        scores = measure_brought(
            requests,
            run,
            sequence=sequence,
            peers=peers,
            device=device,
            command=shlex.join(["swimlab", *sys.argv[1:]]),
            say=say,
            warn=warn,
            begin=begin,
            advance=lambda *_: shown[0](""),
        )
    for family, reason in _absent_families(scores["sequences"][0]).items():
        say(f"no {family}: {reason}")
    return scores


def measure_shot_with_progress(
    path: Path,
    requests: Mapping[str, Request],
    run: Path | None,
    sequence: str,
    *,
    peers: Sequence[str] = (),
    device: str = "cpu",
    quiet: bool,
) -> dict[str, Any]:
    """Measure the builds of a shot file as `measure_brought_with_progress` does, in the words of the file."""
    with in_words_of(path):
        return measure_brought_with_progress(
            requests, run, sequence, peers=peers, device=device, quiet=quiet, reword=as_keys
        )


def _absent_families(entry: dict[str, Any]) -> dict[str, str]:
    """Families of scores ("budget") of which there is none, each with the reason why its main one is absent."""

    there = {name.partition(".")[0] for name in entry["scores"]}
    main = [name for name, _ in COLUMNS.values() if name in entry["absent"]]
    reasons: dict[str, str] = {}
    for name in [*main, *entry["absent"]]:
        reasons.setdefault(name.partition(".")[0], entry["absent"][name])
    return {
        family: reason.replace("pixels per degree", "--pixels-per-degree")
        for family, reason in sorted(reasons.items())
        if family not in there
    }


def _write(output: Path, scores: dict[str, Any]) -> Path:
    """Write scores into a folder as a run has them, or into a .json file; return the file's path."""

    path = scores_path(output)
    if path != output:
        write_text(output / "frames.csv", frames_table(scores["sequences"]))
    write_json(path, scores)
    return path


def _refuse_footage(footage: Footage, why: str) -> None:
    """Raise RunError where options for your own frames come with a run folder or shot file, which state all of this."""
    about_frames = [field for field in fields(footage) if field.name not in VIEWING]
    given = [field.name for field in about_frames if getattr(footage, field.name) != field.default]
    if given:
        option = given[0].replace("range_of_", "").replace("_", "-")
        raise RunError(f"--{option}: is for frames of your own, with --test; {why}")
