"""`swimlab study`."""

import json
import shlex
import shutil
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from metrics.display import Domain
from swimlab.cli.dry_run import print_plans
from swimlab.cli.engines import Name, check_engine, open_engine, threads_of_task
from swimlab.cli.measure_command import measure_shot_with_progress, measure_with_progress
from swimlab.cli.options import Rendering, technique_names
from swimlab.cli.render_command import render_with_progress
from swimlab.cli.score_table import print_scores
from swimlab.cli.terminal import progress
from swimlab.footage.shot import is_shot, load_shot
from swimlab.report.contact import write_contact_sheet
from swimlab.report.kept import is_made_of, key_of_report, write_kept_report
from swimlab.runs.files import write_json
from swimlab.runs.record import REFERENCE, Record, RunError
from swimlab.runs.scores import check_output, merge_scores, refuse_other
from swimlab.sweep.build import STORE
from swimlab.sweep.shots import Asked, Shots

ROAD = ("road-shift", "road-drive", "road-scale")
SHEET, SHEET_FRAMES = "contact.png", 3


def study_command(
    *sequences: str,
    techniques: Annotated[str | None, Parameter(name=["--techniques", "-t"])] = None,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("runs/study"),
    domain: Domain = "linear",
    engine: Name = "local",
    scheduler: str | None = None,
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    rendering: Rendering | None = None,
) -> int:
    """Render the techniques and the reference, or take the builds of shot files, measure them and write a report.

    One sequence makes OUTPUT a run folder; several make a run folder each in it, beside scores and report of all.

    Parameters
    ----------
    sequences:
        Names of sequences in the library, or .toml files of sequences or shots (default: the three road sequences).
    techniques:
        Techniques, or builds of shots, separated by commas (default: all); the reference is always rendered.
    output:
        Folder to write.
    domain:
        Measure linear radiance, or display codes, as the sequence's [display] says (else exposure 1, clamped, sRGB).
    engine:
        Where builds of shots are measured: in this process, or by dask.distributed, long builds by parts.
    scheduler:
        Address of a dask scheduler, as tcp://HOST:8786 (default: one of our own, with processes on this machine).
    json_output:
        Print the scores as JSON instead of a table.
    """
    check_engine(engine, scheduler)
    rendering = rendering or Rendering()
    shots = {name: load_shot(Path(name)) for name in sequences if is_shot(name)}
    if shots:
        rendering.refuse_for_shots(next(iter(shots)))
    if engine != "local" and len(shots) < len(sequences or ROAD):
        raise RunError(f"--engine {engine}: measures shots; render sequences on it by a sweep file and 'swimlab sweep'")
    if shots and techniques is not None and len(shots) < len(sequences):
        raise RunError(f"-t {techniques}: names either techniques of sequences or builds of shots; study them apart")
    names = technique_names(None if techniques is None or shots else f"{techniques},{REFERENCE}")
    plans = {name: rendering.plan(name, names) for name in sequences or ROAD if name not in shots}
    titles = {name: shots[name].name if name in shots else plans[name].sequence.name for name in sequences or ROAD}
    for title, count in Counter(titles[name] for name in sequences or ROAD).items():
        if count > 1:
            raise RunError(
                f"{title}: {count} of the sequences are named so, and would write one folder; rename or drop one"
            )
    folders = [output if len(titles) == 1 else output / title for title in titles.values()]
    if rendering.dry_run:
        print_plans(list(plans.values()), folders, force=rendering.force, json_output=json_output)
        return 0
    check_output(output)
    for name, run in zip(titles, folders, strict=True):
        if name in shots:
            refuse_other(run, titles[name])
    builds = None if techniques is None else [name.strip() for name in techniques.split(",") if name.strip()]
    asked = {name: shot.requests(Path(name).parent, domain, builds=builds) for name, shot in shots.items()}
    if engine != "local":
        there = [Asked(titles[name], asked[name], run) for name, run in zip(titles, folders, strict=True)]
        _measure_elsewhere(there, output, engine, scheduler, quiet=rendering.quiet)
    for name, run in zip(titles, folders, strict=True):
        if name in plans:
            render_with_progress(plans[name], run, rendering)
    all_scores = [
        measure_shot_with_progress(Path(name), asked[name], run, titles[name], quiet=rendering.quiet)
        if name in shots
        else measure_with_progress(run, domain, quiet=rendering.quiet)
        for name, run in zip(titles, folders, strict=True)
    ]
    merged = merge_scores(all_scores)
    if len(folders) > 1:
        write_json(output / "scores.json", merged)
    _report(folders, merged, output / "report.html")
    if json_output:
        print(json.dumps(merged, indent=1, allow_nan=False))
        return 0
    print_scores(all_scores)
    print(output / "report.html")
    return 0


def _measure_elsewhere(
    asked: Sequence[Asked], output: Path, engine: Name, scheduler: str | None, *, quiet: bool
) -> None:
    """Measure shots and write their runs on an engine. Raises RunError for what failed, when the rest is done."""
    out, show = output.absolute(), partial(progress, quiet=quiet)
    shots = Shots(each._replace(run=each.run.absolute()) for each in asked)
    threads = threads_of_task(engine, scheduler, None)
    with open_engine(engine, scheduler, None) as opened:
        failures = shots.measure(list(shots.builds.values()), out, opened, threads=threads, show=show)
        failures |= shots.write(out, opened, command=shlex.join(["swimlab", *sys.argv[1:]]), show=show)
    if failures:
        raise RunError("\n".join([*failures.values(), "the same command tries them again, and keeps what is done"]))
    shutil.rmtree(out / STORE, ignore_errors=True)


def _report(runs: Sequence[Path], scores: Mapping[str, Any], page: Path) -> None:
    """Write contact sheets and the report, the latter last: where it is of the same, so are they."""
    key = key_of_report(runs, scores)
    if is_made_of(page, key) and all((run / SHEET).is_file() for run in runs):
        return
    for run in runs:
        record = Record.read(run)
        rows = sorted(record.techniques, key=lambda name: name == REFERENCE)
        write_contact_sheet(run, run / SHEET, techniques=rows, frames=record.frames[:SHEET_FRAMES])
    write_kept_report(runs, scores, page, key)
