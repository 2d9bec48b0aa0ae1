"""Scores over time: a folder of files 0001_<commit>_<time>.json, each a file of scores without its curves.

The model is pytest-benchmark's storage: https://pytest-benchmark.readthedocs.io/en/latest/comparing.html
"""

import re
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swimlab.compare.change import SIGMAS, Change, change_in_history
from swimlab.compare.pick import Pick
from swimlab.compare.runs import tally
from swimlab.runs.entries import Entry, Key, number, read_all, read_entries
from swimlab.runs.files import write_json, writing
from swimlab.runs.record import VERSION, RunError
from swimlab.runs.scores import read_scores

NAME = re.compile(r"(\d{4,})_.+\.json")
KEPT_CURVES = ("scale",)
"""Curves that tell of how many scales a score is."""


@dataclass(frozen=True)
class Commit:
    """A commit. name: of 40 digits, or "nogit" outside of a repository. dirty: tracked files differ from it."""

    name: str
    dirty: bool

    def __str__(self) -> str:
        return self.name[:DIGITS] + ("_uncommitted-changes" if self.dirty else "")


@dataclass(frozen=True)
class Snapshot:
    """The scores of one time."""

    path: Path
    entries: dict[Key, Entry]


@dataclass(frozen=True)
class Trend:
    """A score over the runs of the same settings. values: oldest first, now last; since: the file before."""

    change: Change
    values: tuple[float, ...]
    since: Path


@dataclass(frozen=True)
class Outlook:
    """A run against a history. first: what has no earlier run of the same settings, and how many it has of others."""

    trends: list[Trend]
    first: dict[Key, int]

    def as_json(self, threshold: float) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "version": VERSION,
            "threshold": threshold,
            **tally([trend.change for trend in self.trends], threshold),
            "first": [{"sequence": key[0], "technique": key[1], "of_others": n} for key, n in self.first.items()],
            "changes": [
                {**trend.change.as_json(), "values": trend.values, "since": str(trend.since)} for trend in self.trends
            ],
        }


def read_history(folder: Path) -> list[Snapshot]:
    """What a folder holds, oldest first; nothing where it is not there. Raises RunError naming a damaged file."""
    return [Snapshot(path, {entry.key: entry for entry in read_entries(path)}) for path in _files(folder)]


def look_back(
    entries: Sequence[Entry], history: Sequence[Snapshot], *, pick: Pick | None = None, threshold: float = SIGMAS
) -> Outlook:
    """Compare scores with earlier ones of the same settings hash, domain and frames in a history."""
    pick = pick or Pick()
    pick.check(entries)
    trends: list[Trend] = []
    first: dict[Key, int] = {}
    for entry in entries:
        if not pick.has(entry.technique):
            continue
        there = [snapshot for snapshot in history if entry.key in snapshot.entries]
        alike = [each for each in there if not entry.settings.difference(each.entries[entry.key].settings)]
        if not alike:
            first[entry.key] = len(there)
            continue
        earlier = [each.entries[entry.key] for each in alike]
        for metric in pick.of_entries(earlier[-1], entry):
            found = change_in_history(earlier, entry, metric, threshold=threshold)
            values = [number(each.scores, metric) for each in (*earlier, entry)]
            trends.append(Trend(found, tuple(value for value in values if value is not None), alike[-1].path))
    return Outlook(trends, first)


def save(folder: Path, runs: Sequence[Path], commit: Commit, *, provenance: dict[str, Any]) -> Path:
    """Add the scores of runs to a history and return the file's path; two at a time take two numbers.

    Raises RunError for runs of several domains or of other settings of one sequence, which do not go into one file, and
    for scores without a settings hash, which nothing could be compared with; RunError where scores cannot be read.
    """
    content = _content(runs) | {"version": VERSION}
    content["provenance"] |= {**provenance, "commit": vars(commit), "runs": [str(run) for run in runs]}
    stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())
    with _claim_number(folder) as taken:
        path = folder / f"{taken:04d}_{commit}_{stamp}.json"
        write_json(path, content)
    return path


def spark(values: Sequence[float], most: int = 16) -> str:
    """The last values as bars of eight heights, ▁ for the least and █ for the greatest; ▄ where all are equal."""
    shown = values[-most:]
    least, span = min(shown), max(shown) - min(shown)
    return "".join("▄" if span == 0 else "▁▂▃▄▅▆▇█"[min(7, int(8 * (value - least) / span))] for value in shown)


def _content(runs: Sequence[Path]) -> dict[str, Any]:
    """Scores of all runs as one content: the domain and a hash a sequence in its provenance."""
    hashes: dict[str, str] = {}
    domains = set()
    for entry in read_all(runs):
        digest = entry.settings.hash
        if digest is None:
            raise RunError(f"{entry.sequence}: the scores carry no settings hash; measure the run again")
        if hashes.setdefault(entry.sequence, digest) != digest:
            raise RunError(f"{entry.sequence}: is there under several settings; save one run of it at a time")
        domains.add(entry.provenance.get("domain", "linear"))
    if len(domains) > 1:
        raise RunError(f"the runs are of several domains ({', '.join(sorted(domains))}); save one domain at a time")
    contents = [read_scores(run) for run in runs]
    entries = [_without_curves(entry) for content in contents for entry in content["sequences"]]
    return {
        "provenance": {"domain": domains.pop(), "hash": ", ".join(hashes.values())},
        "sequences": entries,
    }


def _without_curves(entry: dict[str, Any]) -> dict[str, Any]:
    curves = {name: curve for name, curve in entry.get("curves", {}).items() if name in KEPT_CURVES}
    return {**entry, "curves": curves}


def _files(folder: Path) -> list[Path]:
    if folder.exists() and not folder.is_dir():
        raise RunError(f"--history {folder}: is a file; name a folder")
    numbered = [(int(found[1]), path) for path in folder.glob("*.json") if (found := NAME.fullmatch(path.name))]
    return [path for _, path in sorted(numbered)]


@contextmanager
def _claim_number(folder: Path) -> Iterator[int]:
    """A number that no file of the folder has, and none gets until the block ends.

    Whoever makes the claim file first has the number, unless it was used between looking and claiming.
    """
    with writing(folder, folder):
        folder.mkdir(parents=True, exist_ok=True)
        wanted, claim = _claim(folder)
    try:
        yield wanted
    finally:
        claim.unlink()


def _claim(folder: Path) -> tuple[int, Path]:
    wanted = 0
    while True:
        wanted = max(wanted, _last(folder)) + 1
        claim = folder / f".{wanted:04d}.claim"
        with suppress(FileExistsError):
            claim.touch(exist_ok=False)
            if _last(folder) < wanted:
                return wanted, claim
            claim.unlink()


def _last(folder: Path) -> int:
    files = _files(folder)
    return int(files[-1].name.partition("_")[0]) if files else 0


NONE = "nogit"
DIGITS = 12


def commit_of(folder: Path) -> Commit:
    """The commit of the repository that the folder lies in; "nogit" without git, repository or commit."""
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return Commit(NONE, dirty=False)
    return Commit(said.removesuffix("-dirty"), dirty=said.endswith("-dirty"))
