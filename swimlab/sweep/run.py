"""Running a sweep: chunks, run folders, scores. Finished parts are kept, failed parts are tried again."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swimlab.render.plan import Plan
from swimlab.runs.files import clear_leftovers
from swimlab.runs.record import REFERENCE, Record
from swimlab.runs.scores import write_scores
from swimlab.sweep.assemble import assemble
from swimlab.sweep.chunk import Chunk, Chunks, cut
from swimlab.sweep.engine import Engine, Task, failure_path, record_failure
from swimlab.sweep.file import Sweep
from swimlab.sweep.grid import configurations
from swimlab.sweep.render import clear_temporaries, render_chunk
from swimlab.sweep.score import measure_missing, read_entry, score_path

Show = Callable[[str, int], AbstractContextManager[Callable[[str], None]]]
"""Shows progress: a word and a number of steps in, what is called after each step out."""


@dataclass(frozen=True)
class Work:
    """A sweep in pieces. plans: its configurations. chunks: the chunks of each plan."""

    sweep: Sweep
    plans: list[Plan]
    chunks: list[Chunks]

    @staticmethod
    def of(sweep: Sweep) -> "Work":
        """Cut a sweep up. Raises SweepError naming every mistake in it."""
        plans = configurations(sweep)
        return Work(sweep, plans, [cut(plan, sweep.chunk) for plan in plans])

    def distinct(self) -> list[Chunk]:
        """Every chunk once, in a fixed order: equal work of several configurations is done once."""
        found: dict[str, Chunk] = {}
        for chunks in self.chunks:
            for parts in chunks.values():
                for chunk in parts:
                    found.setdefault(chunk.digest, chunk)
        return list(found.values())


@dataclass
class Outcome:
    """What came of a sweep: the scores of each configuration that could be measured, and the failures by file."""

    scores: list[dict[str, Any]] = field(default_factory=list)
    failures: dict[Path, str] = field(default_factory=dict)


def render_chunks(
    chunks: Sequence[Chunk], out: Path, engine: Engine, *, threads: int | None, show: Show
) -> dict[Path, str]:
    """Render the missing chunks; the failures by file."""
    missing = [chunk for chunk in chunks if not chunk.path(out).exists()]
    tasks = [Task(chunk.digest, chunk.label, render_chunk, (chunk, out, threads)) for chunk in missing]
    return _perform(tasks, out, engine, what="rendering chunks", show=show)


def finish(work: Work, out: Path, engine: Engine, *, command: str, show: Show) -> Outcome:
    """Make the run folders of what is rendered and measure them."""
    clear_temporaries(out)
    clear_leftovers(out)
    runs: list[tuple[Path, Record, dict[str, Path]]] = []
    tasks: list[Task] = []
    claimed: set[Path] = set()
    domain = work.sweep.domain
    for plan, chunks in zip(work.plans, work.chunks, strict=True):
        assembled = assemble(plan, chunks, out, command=command)
        if assembled is None:
            continue
        run, record = assembled
        tests = [name for name in record.techniques if name != REFERENCE]
        files = {name: score_path(plan, chunks, name, domain, out) for name in tests}
        runs.append((run, record, files))
        missing = {name: file for name, file in files.items() if file not in claimed and not file.exists()}
        claimed |= set(missing.values())
        if missing:
            label = f"scores of {plan.sequence.name}"
            folders = [part.path(out) for parts in chunks.values() for part in parts]
            tasks.append(Task(f"scores-{record.hash}", label, measure_missing, (run, missing, domain, folders)))
    outcome = Outcome(failures=_perform(tasks, out, engine, what="measuring", show=show))
    for run, record, files in runs:
        entries = [read_entry(file, record.sequence["name"]) for file in files.values() if file.exists()]
        if entries:
            outcome.scores.append(write_scores(run, record, entries, domain=domain, command=command))
    return outcome


def _perform(tasks: Sequence[Task], out: Path, engine: Engine, *, what: str, show: Show) -> dict[Path, str]:
    failures: dict[Path, str] = {}
    if not tasks:
        return failures
    with show(what, len(tasks)) as advance:
        for task, error in engine(tasks):
            if error is None:
                failure_path(out, task).unlink(missing_ok=True)
            else:
                failures[record_failure(out, task, error)] = f"{task.label}: {error}"
            advance(task.label)
    return failures
