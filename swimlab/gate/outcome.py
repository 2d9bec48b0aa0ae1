"""A gate put to runs, or to a sequence that is rendered first: the checks, the verdict and the exit code."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from metrics.display import Domain
from swimlab.footage.keys import in_words_of
from swimlab.footage.shot import is_shot, load_shot
from swimlab.gate.baseline import Baseline, make_baseline, read_baseline
from swimlab.gate.evidence import find_evidence
from swimlab.gate.judge import Check, Status, exit_code, governed, judge
from swimlab.gate.lacking import rules_off
from swimlab.gate.repeats import read_own
from swimlab.gate.rules import GateError, load_gate
from swimlab.render.catalogue import techniques
from swimlab.render.plan import make_plan
from swimlab.render.run import render_run
from swimlab.runs.counting import counted
from swimlab.runs.entries import Entry, Key, read_all, warnings_of
from swimlab.runs.provenance import provenance
from swimlab.runs.record import REFERENCE
from swimlab.scoring.brought import measure_brought
from swimlab.scoring.measure import measure_run

VERSION = 1
"""Version of the format of a gate's JSON."""
STATUSES: tuple[Status, ...] = ("fail", "unjudged", "warn", "pass")


@dataclass(frozen=True)
class Outcome:
    """What a gate found. exit_code: 0 passed, perhaps with warnings; 1 failed; 2 something could not be judged.

    warnings: what may make scores that were judged wrong, as a motion that does not fit the frames; it fails no check.
    """

    gate: Path
    checks: Sequence[Check]
    provenance: dict[str, Any]
    warnings: Sequence[str] = ()

    @property
    def exit_code(self) -> int:
        """As the command ends."""
        return exit_code(self.checks)

    @property
    def paste(self) -> str:
        """Rules that switch off the scores that are not there, for the gate file; empty where all are."""
        cells = [check.cell for check in self.checks]
        return rules_off((check.cell for check in self.checks if check.absent), cells)

    @property
    def verdict(self) -> str:
        """In words, as "gate.toml: FAILED: 1 fail, 3 pass"."""
        counts = {status: sum(check.status == status for check in self.checks) for status in STATUSES}
        word = ("passed", "FAILED", "COULD NOT BE JUDGED")[self.exit_code]
        return f"{self.gate}: {word}: " + ", ".join(f"{count} {status}" for status, count in counts.items() if count)

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON: version, verdict, provenance, warnings and checks."""
        return {
            "version": VERSION,
            "gate": str(self.gate),
            "exit_code": self.exit_code,
            "verdict": self.verdict,
            "provenance": self.provenance,
            "warnings": list(self.warnings),
            "checks": [_check_json(check) for check in self.checks],
        }


def run_gate(path: Path, runs: Sequence[Path], *, provenance: dict[str, Any]) -> Outcome:
    """Judge the scores of runs by a gate file, and picture the worst place of every score beyond its limit.

    Raises GateError where the gate, its baseline or the scores cannot be read.
    """
    gate = load_gate(path)
    baseline = read_baseline(gate)
    entries = read_all(runs)
    measured = {entry.key: entry for entry in entries}
    checks = _with_evidence(judge(gate, entries, baseline), measured)
    if not checks:
        raise GateError(f"{path}: every rule is off; a gate that checks nothing would always pass")
    found = {"runs": [str(run) for run in runs], **provenance}
    if baseline is not None:
        found["baseline"] = baseline.provenance
    judged = {check.cell[:2] for check in checks}
    return Outcome(path, checks, found, warnings_of(entry for entry in entries if entry.key in judged))


def update_baseline(path: Path, runs: Sequence[Path], *, count: int | None, provenance: dict[str, Any]) -> Baseline:
    """Make the baseline of a gate from runs and write its file; several runs of a sequence give the spread.

    count: how many runs of each technique on each sequence there must be; None: any number.
    Raises GateError where the gate names no baseline, a run lacks a score that a rule speaks of, runs differ in their
    settings, or one comes twice.
    """
    gate = load_gate(path)
    destination = gate.baseline_path
    if destination is None:
        raise GateError(f"{path}: names no baseline; add a [baseline] table with a file")
    if not runs:
        raise GateError("name at least one run folder, or a scores.json file")
    entries = read_own(runs)
    baseline = make_baseline((cell for cell, _ in governed(gate, entries, None)), entries, provenance)
    if not baseline.entries:
        raise GateError(f"{path}: every rule is off; there is nothing to record")
    for (sequence, technique), known in baseline.entries.items():
        if count is not None and known.runs != count:
            raise GateError(f"{technique} on {sequence}: has {counted(known.runs, 'run')}, --runs asks for {count}")
    baseline.write(destination)
    return baseline


def _with_evidence(checks: Sequence[Check], measured: Mapping[Key, Entry]) -> list[Check]:
    """The checks, those beyond their limit with where they are worst."""
    beyond: dict[Key, list[str]] = {}
    for check in checks:
        if check.status in ("fail", "warn") and check.limit:
            beyond.setdefault(check.cell[:2], []).append(check.metric)
    found = {key: find_evidence(measured[key], metrics) for key, metrics in beyond.items()}
    return [replace(check, evidence=found.get(check.cell[:2], {}).get(check.metric)) for check in checks]


def _check_json(check: Check) -> dict[str, Any]:
    evidence = None
    if check.evidence is not None:
        crop = check.evidence.crop
        region = check.evidence.region
        evidence = {"frame": check.evidence.frame, "region": region, "crop": None if crop is None else str(crop)}
    return {**vars(check), "evidence": evidence}


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
    a pixel. A shot file is measured as it is: only names builds. Raises what `load`, `render_run` and `measure_run` do,
    RunError for an unknown build, and GateError for an unknown technique.
    """
    if is_shot(sequence):
        shot = load_shot(Path(sequence))
        requests = shot.requests(Path(sequence).parent, domain, builds=only or None)
        with in_words_of(Path(sequence)):
            measure_brought(requests, run, sequence=shot.name, command=COMMAND)
        return
    unknown = [name for name in only or () if name not in techniques()]
    if unknown:
        raise GateError(f"technique {unknown[0]!r}: is not known; there are {', '.join(techniques())}")
    names = None if only is None else [*only, REFERENCE]
    plan = make_plan(sequence, names, size=size, frames=frames, samples=samples)
    render_run(plan, run, threads=threads, command=COMMAND)
    measure_run(run, domain=domain, command=COMMAND)


def gate_runs(gate: Path, runs: Sequence[Path]) -> Outcome:
    """Judge runs by a gate file. Raises GateError."""
    return run_gate(gate, runs, provenance=provenance(COMMAND))
