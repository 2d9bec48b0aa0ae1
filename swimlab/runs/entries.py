"""Scores of runs as the gate sees them: of which clip, under which settings, and where its frames lie."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Any

from metrics.display import STANDARD
from sequences.viewing import Viewing
from swimlab.runs.beside import folder_of, hashes_of, reading
from swimlab.runs.names import check_part
from swimlab.runs.record import RunError
from swimlab.runs.scores import read_scores, scores_path

Key = tuple[str, str]
"""Sequence and technique."""


@dataclass(frozen=True)
class Settings:
    """What must agree for two measurements to be comparable.

    hash: of all that decides the pixels, or None for frames that swimlab did not render. domain: "linear", "display" or
    "display: gamma sqrt", with all that is not as it stands. extent: the frames that were measured, as "0-31", or "9
    scales".
    """

    hash: str | None
    domain: str
    extent: str

    def difference(self, other: "Settings") -> str:
        """The first thing in which the two differ, in words; empty where they agree. Unknown hashes never agree."""
        if self.hash is None:
            return "the scores carry no settings hash, so they cannot be checked for being comparable"
        for what, mine, theirs in (
            ("settings hash", self.hash, other.hash),
            ("domain", self.domain, other.domain),
            ("frames", self.extent, other.extent),
        ):
            if mine != theirs:
                return f"{what} {mine} instead of {theirs}"
        return ""


@dataclass(frozen=True)
class Entry:
    """A technique's scores on a sequence; a score that is null or not finite in the file is NaN here.

    frames, curves: as in scores.json. errors, replicates: of the scores that have them. folder: the run folder with
    its pictures, if there is one. warnings: what was found when it was measured that may make the scores wrong.
    """

    sequence: str
    technique: str
    scores: dict[str, float]
    absent: dict[str, str]
    settings: Settings
    frames: Sequence[dict[str, Any]] = ()
    curves: dict[str, dict[str, list[Any]]] = field(default_factory=dict)
    errors: dict[str, float] = field(default_factory=dict)
    replicates: dict[str, list[float]] = field(default_factory=dict)
    folder: Path | None = None
    provenance: dict[str, Any] = field(default_factory=dict)
    warnings: Sequence[str] = ()

    @property
    def key(self) -> Key:
        """Sequence and technique."""
        return self.sequence, self.technique


def read_entries(run: Path) -> list[Entry]:
    """Every entry of a run folder, of a study's folder, or of a scores.json file.

    Raises RunError where scores are missing, damaged, empty, or older than the run they lie in.
    """
    path = scores_path(run)
    content = read_scores(run)
    with reading(path):
        hashes = hashes_of(path, content)
        found = [
            _entry(path, content["provenance"], hashes[entry["sequence"]], entry) for entry in content["sequences"]
        ]
    if not found:
        raise RunError(f"{path}: holds no scores; render a technique beside the reference and measure the run")
    return found


def read_all(runs: Iterable[Path]) -> list[Entry]:
    """The entries of several runs; none may come twice. Raises RunError."""
    found: dict[Key, Path] = {}
    entries = []
    for run in runs:
        for entry in read_entries(run):
            if entry.key in found:
                raise RunError(
                    f"{run}: {entry.technique} on {entry.sequence} is in {found[entry.key]} already; name each run once"
                )
            found[entry.key] = run
            entries.append(entry)
    if not entries:
        raise RunError("name at least one run folder, or a scores.json file")
    return entries


def number(values: Mapping[str, float], name: str) -> float | None:
    """A value by name; None where it is not there or not a number."""
    value = values.get(name)
    return None if value is None or not isfinite(value) else value


def _entry(path: Path, provenance: dict[str, Any], digest: str | None, content: dict[str, Any]) -> Entry:
    sequence = _name(path, content, "sequence")
    frames, curves = content.get("frames", []), content.get("curves", {})
    folder = folder_of(path, content, digest)
    if "hash" in content:  # builds of a shot have settings of their own
        digest, provenance = content["hash"], {**provenance, "settings": content["settings"]}
    return Entry(
        sequence=sequence,
        technique=_name(path, content, "technique"),
        scores={name: _number(value) for name, value in content["scores"].items()},
        absent=dict(content.get("absent", {})),
        settings=Settings(digest, _domain(provenance, content), _extent(frames, curves)),
        frames=frames,
        curves=curves,
        errors={name: _number(value) for name, value in content.get("errors", {}).items()},
        replicates=content.get("replicates", {}),
        folder=folder,
        provenance=provenance,
        warnings=tuple(map(str, content.get("warnings", ()))),
    )


def _name(path: Path, content: dict[str, Any], of: str) -> str:
    try:
        return check_part(str(content[of]), of)
    except ValueError as error:
        raise RunError(f"{path}: {error}; measure the run again under another name") from error


def warnings_of(entries: Iterable[Entry]) -> list[str]:
    """A line for each warning, with the techniques and the sequence that it is of: "tsl on road-shift: ..."."""
    told: dict[tuple[str, str], list[str]] = {}
    for entry in entries:
        for text in entry.warnings:
            told.setdefault((entry.sequence, text), []).append(entry.technique)
    return [f"{', '.join(dict.fromkeys(names))} on {sequence}: {text}" for (sequence, text), names in told.items()]


def _domain(provenance: dict[str, Any], content: dict[str, Any]) -> str:
    """The domain, as "linear", "display" or "display: gamma sqrt, bloom.strength 0.2"; the seed is in the hash."""
    domain = str(provenance.get("domain", "linear"))
    standard = dict(flat(asdict(STANDARD) | Viewing().model_dump()))
    given = dict(flat(content.get("display", {}) | content.get("viewing", {})))
    changed = [f"{key} {value}" for key, value in given.items() if key != "seed" and value != standard.get(key)]
    return f"{domain}: {', '.join(changed)}" if changed else domain


def flat(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Keys and values of nested tables, as ("bloom.strength", 0.2)."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _number(value: Any) -> float:
    """The value as a float; NaN for null, text, booleans and infinities."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if number and isfinite(value) else float("nan")


def _extent(frames: Sequence[dict[str, Any]], curves: dict[str, dict[str, list[Any]]]) -> str:
    if not frames:
        return f"{len(curves.get('scale', {}).get('scale', []))} scales"
    numbers = [int(row["frame"]) for row in frames]
    steps = {after - before for before, after in pairwise(numbers)}
    if len(steps) > 1 or len(numbers) == 1:
        return ",".join(map(str, numbers))
    step = steps.pop()
    return f"{numbers[0]}-{numbers[-1]}" + (f"x{step}" if step != 1 else "")
