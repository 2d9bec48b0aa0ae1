"""What was measured earlier: means and spreads of scores over runs, as a JSON file that is kept beside the gate."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from math import isfinite, sqrt
from pathlib import Path
from typing import Any

from swimlab.gate.comparable import difference, hashed
from swimlab.gate.lacking import may_lack, rules_off, why_lacking
from swimlab.gate.rules import Cell, Gate, GateError
from swimlab.runs.entries import Entry, Key, Settings
from swimlab.runs.files import write_json

VERSION = 1
"""Version of the format of baseline files."""


@dataclass
class Spread:
    """Mean and spread of a score over runs (Welford 1962: one pass, no cancellation)."""

    runs: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def add(self, value: float) -> None:
        """Take in the score of one more run."""
        self.runs += 1
        before = value - self.mean
        self.mean += before / self.runs
        self.squares += before * (value - self.mean)

    @property
    def sigma(self) -> float | None:
        """Standard deviation (n - 1) over the runs; None for a single run, which says nothing of it."""
        return sqrt(self.squares / (self.runs - 1)) if self.runs > 1 else None


@dataclass(frozen=True)
class Known:
    """What a baseline holds of a technique on a sequence. scores: name -> (mean, sigma or None).

    hashed: what the settings hash is made of, flat; empty where that is not known.
    """

    settings: Settings
    runs: int
    scores: dict[str, tuple[float, float | None]]
    hashed: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Baseline:
    """A baseline file."""

    entries: dict[Key, Known] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)

    def write(self, path: Path) -> None:
        """Write the file, whole or not at all."""
        entries = [
            {
                "sequence": sequence,
                "technique": technique,
                **asdict(known.settings),
                "runs": known.runs,
                "scores": {name: {"mean": mean, "sigma": sigma} for name, (mean, sigma) in known.scores.items()},
            }
            for (sequence, technique), known in self.entries.items()
        ]
        hashed = {known.settings.hash: known.hashed for known in self.entries.values() if known.hashed}
        write_json(
            path, {"version": VERSION, "provenance": self.provenance, "entries": entries, "settings_by_hash": hashed}
        )


def read_baseline(gate: Gate) -> Baseline | None:
    """The gate's baseline; None where the gate has none. Raises GateError for a missing or damaged file.

    A gate that only warns of what the baseline lacks may do without the file.
    """
    path = gate.baseline_path
    if gate.baseline is None or path is None:
        return None
    if not path.exists() and gate.baseline.missing == "warn":
        return Baseline()
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
        if content.get("version") != VERSION:
            raise GateError(
                f"{path}: has version {content.get('version')!r}, this swimlab reads {VERSION}; make it again"
            )
        hashed = content.get("settings_by_hash", {})
        entries = dict(_known(each, hashed.get(each["hash"], {})) for each in content["entries"])
        return Baseline(entries, content.get("provenance", {}))
    except OSError as error:
        raise GateError(
            f"{path}: cannot be read ({error.strerror}); make it: swimlab baseline update {gate.path} RUN"
        ) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, GateError):
            raise
        raise GateError(
            f"{path}: is not a baseline ({error!r}); make it again: swimlab baseline update {gate.path} RUN"
        ) from error


def make_baseline(chosen: Iterable[Cell], entries: Sequence[Entry], provenance: dict[str, Any]) -> Baseline:
    """Mean and spread of the chosen scores (sequence, technique, metric) over the runs in `entries`.

    Raises GateError where runs of a sequence differ in their settings, and one for all scores that a run lacks.
    """
    by_key: dict[Key, list[Entry]] = {}
    for entry in entries:
        by_key.setdefault(entry.key, []).append(entry)
    cells = sorted(chosen)
    _check_complete(cells, by_key)
    names: dict[Key, list[str]] = {}
    for *key, metric in cells:
        names.setdefault((key[0], key[1]), []).append(metric)
    return Baseline({key: _over_runs(key, by_key[key], found) for key, found in names.items()}, provenance)


def _check_complete(cells: Sequence[Cell], by_key: dict[Key, list[Entry]]) -> None:
    """Raise one GateError for all scores that a run lacks, with the rules that leave them out."""
    lines, lacking = [], []
    for sequence, technique, name in cells:
        what, runs = f"{technique} on {sequence}", by_key.get((sequence, technique), [])
        if not runs:
            lines.append(f"{what}: is in no run; measure it, or mend the gate's rule")
        for run in runs:
            value = run.scores.get(name)
            if value is None:
                lines.append(f"{what}: {name} cannot go into a baseline: {why_lacking(name, run)}")
                lacking += [(sequence, technique, name)] if may_lack(name, run) else []
            elif not isfinite(value):
                lines.append(f"{what}: {name} cannot go into a baseline: is not a number")
    if lines:
        raise GateError("\n".join(dict.fromkeys(lines)), paste=rules_off(dict.fromkeys(lacking), cells))


def _over_runs(key: Key, runs: Sequence[Entry], names: Sequence[str]) -> Known:
    first = runs[0]
    for run in runs:
        unlike = difference(run, first.settings, hashed(first))
        if unlike:
            raise GateError(
                f"{key[1]} on {key[0]}: cannot go into one baseline: {unlike}; give runs of the same settings"
            )
    scores = {}
    for name in names:
        spread = Spread()
        for run in runs:
            spread.add(run.scores[name])
        scores[name] = (spread.mean, spread.sigma)
    return Known(first.settings, len(runs), scores, hashed(first))


def _known(content: dict[str, Any], hashed: dict[str, Any]) -> tuple[Key, Known]:
    settings = Settings(content["hash"], content["domain"], content["extent"])
    scores = {name: (_finite(each["mean"]), _sigma(each["sigma"])) for name, each in content["scores"].items()}
    return (content["sequence"], content["technique"]), Known(settings, int(content["runs"]), scores, dict(hashed))


def _finite(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise ValueError(f"{value!r} is not a finite number")
    return float(value)


def _sigma(value: Any) -> float | None:
    return None if value is None else _finite(value)
