"""Render a sequence small and hold it to a gate: what a test does."""

from collections.abc import Sequence
from pathlib import Path

from metrics.display import Domain
from swimlab.gate.outcome import Outcome, run_gate
from swimlab.gate.rules import GateError
from swimlab.render.catalogue import techniques
from swimlab.render.plan import make_plan
from swimlab.render.run import render_run
from swimlab.runs.provenance import provenance
from swimlab.runs.record import REFERENCE
from swimlab.scoring.measure import measure_run

COMMAND = "pytest"


def render_and_measure(
    sequence: str | Path,
    run: Path,
    *,
    only: Sequence[str] | None = None,
    size: tuple[int, int] | None = None,
    frames: str | None = None,
    samples: int = 64,
    threads: int | None = None,
    domain: Domain = "linear",
) -> None:
    """Render techniques of a sequence beside the reference into a run folder, and measure them.

    only: names of techniques, None: all. size: width and height in px. frames: as "0-7". samples: of the reference,
    a pixel. Raises what `load`, `render_run` and `measure_run` do, and GateError for an unknown technique.
    """
    unknown = [name for name in only or () if name not in techniques()]
    if unknown:
        raise GateError(f"technique {unknown[0]!r}: there are {', '.join(techniques())}")
    names = None if only is None else [*only, REFERENCE]
    plan = make_plan(sequence, names, size=size, frames=frames, samples=samples)
    render_run(plan, run, threads=threads, command=COMMAND)
    measure_run(run, domain=domain, command=COMMAND)


def gate_runs(gate: Path, runs: Sequence[Path]) -> Outcome:
    """Judge runs by a gate file. Raises GateError."""
    return run_gate(gate, runs, provenance=provenance(COMMAND))
