"""`swimlab sweep`."""

import json
import re
import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from swimlab.cli.engines import Name, check_engine, open_engine, threads_of_task
from swimlab.cli.sweep_table import print_sweep
from swimlab.cli.terminal import progress
from swimlab.render.plan import check_threads
from swimlab.runs.counting import counted
from swimlab.runs.files import write_json
from swimlab.runs.record import RunError
from swimlab.runs.scores import merge_scores
from swimlab.sweep.file import load_sweep
from swimlab.sweep.openjd import job_template
from swimlab.sweep.run import RenderedWork
from swimlab.sweep.shot_grid import ShotWork, are_shots
from swimlab.sweep.work import Outcome, Piece, Work

SHOWN = 5
"""Failures that are printed; all are in files."""


def sweep_command(
    sweep: Path,
    /,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    engine: Name = "local",
    scheduler: str | None = None,
    threads: int | None = None,
    only: str | None = None,
    export: Annotated[tuple[Literal["openjd"], Path] | None, Parameter(negative="")] = None,
    dry_run: Annotated[bool, Parameter(negative="")] = False,
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Render and measure a grid of sequences, techniques and settings, or of shots, builds and settings.

    What OUTPUT holds is kept and what failed is tried again: give an interrupted command once more. Ends with 2 where
    anything failed; the rest is done all the same.

    Parameters
    ----------
    sweep:
        Sweep file.
    output:
        Folder of the results (default: runs/NAME): runs/ with a run folder for each configuration, scores.json.
    engine:
        Where the work is done: in this process, or by dask.distributed.
    scheduler:
        Address of a dask scheduler, as tcp://HOST:8786 (default: one of our own, with processes on this machine).
    threads:
        Threads of a chunk, or of a build (default: every core; with dask here 1, and a process for every core).
    only:
        Render the K-th of every N chunks, written K/N, or measure so many builds of shots: a task of a render farm.
    export:
        Write a job template and do nothing else: openjd FILE, an Open Job Description as JSON.
    dry_run:
        Say what there is to do, and do nothing.
    json_output:
        Print JSON instead of a table.
    quiet:
        Show no progress.
    """
    check_engine(engine, scheduler)
    check_threads(threads)
    if only is not None and json_output and not dry_run:
        raise RunError("--json: with --only nothing is measured that could be printed; leave it out")
    given = load_sweep(sweep)
    out = (output or Path("runs") / given.name).absolute()
    work: Work = ShotWork.of(given, out) if are_shots(given) else RenderedWork.of(given)
    if export is not None:
        return _export(work, sweep, export[1])
    pieces = work.pieces()
    if only is not None:
        first, step = parse_share(only)
        pieces = pieces[first - 1 :: step]
    if dry_run:
        return _say_what_is_to_do(work, pieces, out, json_output=json_output)
    show = partial(progress, quiet=quiet)
    of_task = threads_of_task(engine, scheduler, threads)
    with open_engine(engine, scheduler, threads) as opened:
        failures = work.do(pieces, out, opened, threads=of_task, show=show)
        command = shlex.join(["swimlab", *sys.argv[1:]])
        outcome = Outcome() if only is not None else work.finish(out, opened, command=command, show=show)
    failures |= outcome.failures
    if outcome.scores:
        _print_scores(work, outcome.scores, out, json_output=json_output)
    if failures:
        _say_what_failed(failures, out)
    return 2 if failures else 0


def parse_share(text: str) -> tuple[int, int]:
    """K and N of K/N, 1 <= K <= N. Raises RunError."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        raise RunError(f"--only {text}: write K/N with K from 1 to N, as 3/16")
    return int(found[1]), int(found[2])


def _export(work: Work, sweep: Path, path: Path) -> int:
    write_json(path, job_template(work, sweep, path))
    print(path)
    return 0


def _say_what_is_to_do(work: Work, pieces: Sequence[Piece], out: Path, *, json_output: bool) -> int:
    every = Counter(piece.technique for piece in pieces)
    done = Counter(piece.technique for piece in pieces if piece.path(out).exists())
    frames = Counter({name: sum(len(each.frames) for each in pieces if each.technique == name) for name in every})
    rows = [
        {"technique": name, "chunks": every[name], "done": done[name], "frames": frames[name]} for name in sorted(every)
    ]
    if json_output:
        print(json.dumps({"output": str(out), "configurations": work.names, "work": rows}, indent=1))
        return 0
    for name in work.names:
        print(out / "runs" / name)
    print(f"{'technique':16} {'chunks':>8} {'done':>8} {'frames':>8}")
    for row in rows:
        print(f"{row['technique']:16} {row['chunks']:8} {row['done']:8} {row['frames']:8}")
    return 0


def _print_scores(work: Work, scores: list[dict[str, Any]], out: Path, *, json_output: bool) -> None:
    merged = merge_scores(scores)
    write_json(out / "scores.json", merged)
    if json_output:
        print(json.dumps(merged, indent=1, allow_nan=False))
        return
    print_sweep(work, scores, out)
    print(out / "scores.json")


def _say_what_failed(failures: dict[Path, str], out: Path) -> None:
    print(f"swimlab: {counted(len(failures), 'task')} failed, each with a file in {out / 'failures'}:", file=sys.stderr)
    for message in list(failures.values())[:SHOWN]:
        print(f"swimlab: {message}", file=sys.stderr)
    if len(failures) > SHOWN:
        print(f"swimlab: and {len(failures) - SHOWN} more", file=sys.stderr)
    print("swimlab: the same command tries them again, and keeps what is done", file=sys.stderr)
