"""`swimlab sweep`."""

import json
import re
import shlex
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from swimlab.cli.sweep_table import print_sweep
from swimlab.cli.terminal import progress
from swimlab.render.plan import check_threads
from swimlab.runs.files import write_json
from swimlab.runs.record import RunError
from swimlab.runs.scores import merge_scores
from swimlab.sweep.chunk import Chunk
from swimlab.sweep.engine import Engine, dask_engine, local
from swimlab.sweep.file import load_sweep
from swimlab.sweep.openjd import job_template
from swimlab.sweep.run import Outcome, Work, finish, render_chunks

SHOWN = 5
"""Failures that are printed; all are in files."""


def sweep_command(
    sweep: Path,
    /,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    engine: Literal["local", "dask"] = "local",
    scheduler: str | None = None,
    threads: int | None = None,
    only: str | None = None,
    export: Annotated[tuple[Literal["openjd"], Path] | None, Parameter(negative="")] = None,
    dry_run: Annotated[bool, Parameter(negative="")] = False,
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Render and measure a grid of sequences, techniques and settings, here or on a cluster.

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
        Threads to render a chunk with (default: every core; with dask on this machine 1, and a process for every core).
    only:
        Render the K-th of every N chunks, written K/N, and measure nothing: a task of a render farm.
    export:
        Write a job template and do nothing else: openjd FILE, an Open Job Description as JSON.
    dry_run:
        Say what there is to do, and do nothing.
    json_output:
        Print JSON instead of a table.
    quiet:
        Show no progress.
    """
    if scheduler is not None and engine != "dask":
        raise RunError(f"--scheduler {scheduler}: is for --engine dask; add that")
    check_threads(threads)
    if only is not None and json_output and not dry_run:
        raise RunError("--json: with --only nothing is measured that could be printed; leave it out")
    work = Work.of(load_sweep(sweep))
    out = (output or Path("runs") / work.sweep.name).absolute()
    if export is not None:
        return _export(work, sweep, export[1])
    chunks = work.distinct()
    if only is not None:
        first, step = parse_share(only)
        chunks = chunks[first - 1 :: step]
    if dry_run:
        return _say_what_is_to_do(work, chunks, out, json_output=json_output)
    show = partial(progress, quiet=quiet)
    with _engine(engine, scheduler, threads) as perform:
        failures = render_chunks(chunks, out, perform, threads=_threads(engine, scheduler, threads), show=show)
        command = shlex.join(["swimlab", *sys.argv[1:]])
        outcome = Outcome() if only is not None else finish(work, out, perform, command=command, show=show)
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


@contextmanager
def _engine(name: str, scheduler: str | None, threads: int | None) -> Iterator[Engine]:
    if name == "local":
        yield local
        return

    with dask_engine(scheduler, threads=threads) as engine:
        yield engine


def _threads(engine: str, scheduler: str | None, threads: int | None) -> int | None:
    """Threads of a chunk: the processes of a cluster on this machine share its cores."""
    return threads or 1 if engine == "dask" and scheduler is None else threads


def _export(work: Work, sweep: Path, path: Path) -> int:
    write_json(path, job_template(work, sweep, path))
    print(path)
    return 0


def _say_what_is_to_do(work: Work, chunks: Sequence[Chunk], out: Path, *, json_output: bool) -> int:
    every = Counter(chunk.technique for chunk in chunks)
    done = Counter(chunk.technique for chunk in chunks if chunk.path(out).exists())
    frames = Counter({name: sum(len(c.frames) for c in chunks if c.technique == name) for name in every})
    rows = [
        {"technique": name, "chunks": every[name], "done": done[name], "frames": frames[name]} for name in sorted(every)
    ]
    if json_output:
        runs = [plan.sequence.name for plan in work.plans]
        print(json.dumps({"output": str(out), "configurations": runs, "work": rows}, indent=1))
        return 0
    for plan in work.plans:
        print(out / "runs" / plan.sequence.name)
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
    print(f"swimlab: {len(failures)} tasks failed, each with a file in {out / 'failures'}:", file=sys.stderr)
    for message in list(failures.values())[:SHOWN]:
        print(f"swimlab: {message}", file=sys.stderr)
    if len(failures) > SHOWN:
        print(f"swimlab: and {len(failures) - SHOWN} more", file=sys.stderr)
    print("swimlab: the same command tries them again, and keeps what is done", file=sys.stderr)
