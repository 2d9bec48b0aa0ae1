"""Running a sweep of sequences: chunks, run folders, scores. Finished parts are kept, failed parts are tried again."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from swimlab.render.plan import Plan
from swimlab.runs.files import clear_leftovers
from swimlab.runs.record import REFERENCE, Record
from swimlab.runs.scores import write_scores
from swimlab.sweep.assemble import assemble
from swimlab.sweep.chunk import Chunk, Chunks, cut
from swimlab.sweep.engine import Engine, Task
from swimlab.sweep.file import Sweep
from swimlab.sweep.grid import configurations
from swimlab.sweep.perform import Show, perform
from swimlab.sweep.render import clear_temporaries, render_chunk
from swimlab.sweep.score import measure_missing, read_entry, score_path
from swimlab.sweep.work import Outcome


@dataclass(frozen=True)
class RenderedWork:
    """A sweep of sequences in pieces. plans: its configurations. chunks: the chunks of each plan."""

    sweep: Sweep
    plans: list[Plan]
    chunks: list[Chunks]

    @staticmethod
    def of(sweep: Sweep) -> "RenderedWork":
        """Cut a sweep up. Raises SweepError naming every mistake in it."""
        plans = configurations(sweep)
        return RenderedWork(sweep, plans, [cut(plan, sweep.chunk) for plan in plans])

    @property
    def names(self) -> list[str]:
        """The configurations' names."""
        return [plan.sequence.name for plan in self.plans]

    def pieces(self) -> list[Chunk]:
        """Every chunk once, in a fixed order: equal work of several configurations is done once."""
        found: dict[str, Chunk] = {}
        for chunks in self.chunks:
            for parts in chunks.values():
                for chunk in parts:
                    found.setdefault(chunk.digest, chunk)
        return list(found.values())

    def do(
        self, pieces: Sequence[Chunk], out: Path, engine: Engine, *, threads: int | None, show: Show
    ) -> dict[Path, str]:
        """Render the missing ones of some chunks; the failures by file."""
        missing = [chunk for chunk in pieces if not chunk.path(out).exists()]
        tasks = [Task(chunk.digest, chunk.label, render_chunk, (chunk, out, threads)) for chunk in missing]
        return perform(tasks, out, engine, what="rendering chunks", show=show)

    def finish(self, out: Path, engine: Engine, *, command: str, show: Show) -> Outcome:
        """Make the run folders of what is rendered and measure them."""
        clear_temporaries(out)
        clear_leftovers(out)
        runs: list[tuple[Path, Record, dict[str, Path]]] = []
        tasks: list[Task] = []
        claimed: set[Path] = set()
        domain = self.sweep.domain
        for plan, chunks in zip(self.plans, self.chunks, strict=True):
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
        outcome = Outcome(failures=perform(tasks, out, engine, what="measuring", show=show))
        for run, record, files in runs:
            entries = [read_entry(file, record.sequence["name"]) for file in files.values() if file.exists()]
            if entries:
                outcome.scores.append(write_scores(run, record, entries, domain=domain, command=command))
        return outcome
