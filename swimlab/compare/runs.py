"""Several runs side by side; the first is the base."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swimlab.compare.change import SIGMAS, Change, change, expected_by_chance
from swimlab.compare.pick import Pick
from swimlab.runs.differences import Difference, differences
from swimlab.runs.entries import Entry, Key, read_all
from swimlab.runs.record import RunError

VERSION = 1
"""Version of the format of a comparison's JSON."""


@dataclass(frozen=True)
class Against:
    """A run against the base. only: techniques on sequences that one of the two lacks, each with which has it."""

    run: Path
    changes: list[Change]
    differences: dict[str, list[Difference]]
    only: dict[Key, str]


@dataclass(frozen=True)
class Comparison:
    """Runs against a base. threshold: standard errors beyond which a change is said to be real."""

    base: Path
    runs: list[Against]
    threshold: float
    provenance: dict[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "version": VERSION,
            "base": str(self.base),
            "threshold": self.threshold,
            "provenance": self.provenance,
            "runs": [
                {
                    "run": str(each.run),
                    **tally(each.changes, self.threshold),
                    "differences": {
                        name: [vars(difference) for difference in found] for name, found in each.differences.items()
                    },
                    "only": [
                        {"sequence": key[0], "technique": key[1], "in": where} for key, where in each.only.items()
                    ],
                    "changes": [found.as_json() for found in each.changes],
                }
                for each in self.runs
            ],
        }


def compare_runs(
    runs: Sequence[Path], *, pick: Pick | None = None, threshold: float = SIGMAS, provenance: dict[str, Any]
) -> Comparison:
    """Compare the scores of measured run folders, folders of a study, or scores.json files with the first one's.

    Runs of other settings may be compared; what differs is said, and their changes are marked. Two that hold one
    sequence each are paired under any name. Raises RunError where
    fewer than two runs are named or they have nothing in common, RunError where scores cannot be read.
    """
    pick = pick or Pick()
    if len(runs) < 2:
        raise RunError("compare: name two runs or more, the first is the base; or one with --history FOLDER")
    base, *others = [read_all([run]) for run in runs]
    pick.check([entry for entries in (base, *others) for entry in entries])
    found = [_against(run, base, entries, pick, threshold) for run, entries in zip(runs[1:], others, strict=True)]
    return Comparison(runs[0], found, threshold, provenance)


def tally(changes: Sequence[Change], threshold: float) -> dict[str, Any]:
    """Counts: verdicts, scores of which the sigmas are known, how many chance and how many in fact go beyond."""
    known = [abs(each.sigmas) for each in changes if each.sigmas is not None]
    verdicts = [each.verdict for each in changes]
    return {
        "verdicts": {verdict: verdicts.count(verdict) for verdict in dict.fromkeys(verdicts)},
        "compared": len(known),
        "beyond": sum(sigmas > threshold for sigmas in known),
        "expected_by_chance": expected_by_chance(len(known), threshold),
    }


def _against(run: Path, base: Sequence[Entry], entries: Sequence[Entry], pick: Pick, threshold: float) -> Against:
    known = {entry.key: entry for entry in base if pick.has(entry.technique)}
    measured = {entry.key: entry for entry in entries if pick.has(entry.technique)}
    if len(known) == len(measured) == 1:
        # One clip each, as your own frames are: their files' names need not agree.
        measured = dict(zip(known, measured.values(), strict=True))
    elif len(names := {key[0] for key in known}) == len({key[0] for key in measured}) == 1:
        # One sequence each, as the run folders of a sweep: techniques are paired under any name of it.
        (name,) = names
        measured = {(name, key[1]): entry for key, entry in measured.items()}
    both = [key for key in known if key in measured]
    if not both:
        raise RunError(
            f"{run}: has no technique on a sequence in common with the base: {_names(measured)}; base: {_names(known)}"
        )
    unlike: dict[str, list[Difference]] = {}
    changes: list[Change] = []
    for key in both:
        if key[0] not in unlike:
            unlike[key[0]] = differences(known[key], measured[key])
        like = not any(each.concerns(key[1]) for each in unlike[key[0]])
        changes += _changes(known[key], measured[key], pick, threshold, like=like)
    only = {key: "base" if key in known else "run" for key in (*known, *measured) if key not in both}
    return Against(run, changes, {name: found for name, found in unlike.items() if found}, only)


def _changes(before: Entry, after: Entry, pick: Pick, threshold: float, *, like: bool) -> Iterator[Change]:
    for metric in pick.of_entries(before, after):
        yield change(before, after, metric, threshold=threshold, like=like)


def _names(entries: dict[Key, Entry]) -> str:
    return ", ".join(f"{technique} on {sequence}" for sequence, technique in entries) or "none"
