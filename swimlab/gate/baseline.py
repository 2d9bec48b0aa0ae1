"""What was measured earlier: means and spreads of scores over runs, as a JSON file that is kept beside the gate."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from math import isfinite, sqrt
from pathlib import Path
from typing import Any

from swimlab.files import write_json
from swimlab.gate.measured import Entry, Key, Settings
from swimlab.gate.rules import Gate, GateError

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
    """What a baseline holds of a technique on a sequence. scores: name -> (mean, sigma or None)."""

    settings: Settings
    runs: int
    scores: dict[str, tuple[float, float | None]]


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
        write_json(path, {"version": VERSION, "provenance": self.provenance, "entries": entries})


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
        content = json.loads(path.read_text(encoding="utf-8"))
        if content.get("version") != VERSION:
            raise GateError(
                f"{path}: has version {content.get('version')!r}, this swimlab reads {VERSION}; make it anew"
            )
        return Baseline(dict(map(_known, content["entries"])), content.get("provenance", {}))
    except OSError as error:
        raise GateError(
            f"{path}: cannot be read ({error.strerror}); make it: swimlab baseline update {gate.path} RUN"
        ) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, GateError):
            raise
        raise GateError(
            f"{path}: is not a baseline ({error!r}); make it anew: swimlab baseline update {gate.path} RUN"
        ) from error


def make_baseline(
    wanted: Iterable[tuple[str, str, str]], entries: Sequence[Entry], provenance: dict[str, Any]
) -> Baseline:
    """Mean and spread of the wanted scores (sequence, technique, metric) over the runs in `entries`.

    Raises GateError where runs of a sequence differ in their settings or lack a score.
    """
    by_key: dict[Key, list[Entry]] = {}
    for entry in entries:
        by_key.setdefault(entry.key, []).append(entry)
    names: dict[Key, list[str]] = {}
    for sequence, technique, metric in wanted:
        names.setdefault((sequence, technique), []).append(metric)
    return Baseline({key: _over_runs(key, by_key.get(key, []), found) for key, found in names.items()}, provenance)


def _over_runs(key: Key, runs: Sequence[Entry], names: Sequence[str]) -> Known:
    what = f"{key[1]} on {key[0]}"
    if not runs:
        raise GateError(f"{what}: is in no run; measure it, or mend the gate's rule")
    for run in runs:
        difference = run.settings.difference(runs[0].settings)
        if difference:
            raise GateError(f"{what}: cannot go into one baseline: {difference}; give runs of the same settings")
    scores = {}
    for name in sorted(names):
        spread = Spread()
        for run in runs:
            value = run.scores.get(name)
            if value is None or not isfinite(value):
                reason = run.absent.get(name, "is not a number" if value is not None else "is not there")
                raise GateError(f"{what}: {name} cannot go into a baseline: {reason}; switch it off with a rule")
            spread.add(value)
        scores[name] = (spread.mean, spread.sigma)
    return Known(runs[0].settings, len(runs), scores)


def _known(content: dict[str, Any]) -> tuple[Key, Known]:
    settings = Settings(content["hash"], content["domain"], content["extent"])
    scores = {name: (_finite(each["mean"]), _sigma(each["sigma"])) for name, each in content["scores"].items()}
    return (content["sequence"], content["technique"]), Known(settings, int(content["runs"]), scores)


def _finite(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise ValueError(f"{value!r} is not a finite number")
    return float(value)


def _sigma(value: Any) -> float | None:
    return None if value is None else _finite(value)
