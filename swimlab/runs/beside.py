"""The run folder that lies beside scores, and whether its pictures are still those that were measured."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from swimlab.runs.names import check_part
from swimlab.runs.record import Record, RunError
from swimlab.runs.scores import read_scores, scores_path


def read_current(run: Path) -> dict[str, Any]:
    """The content of scores.json as `read_scores` gives it.

    Raises RunError also where pictures that were measured have been rendered again since.
    """
    content, path = read_scores(run), scores_path(run)
    with reading(path):
        hashes = hashes_of(path, content)
        for entry in content["sequences"]:
            folder_of(path, entry, hashes[entry["sequence"]])
    return content


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Say of a file that it holds no scores where what is done with its content fails. Raises RunError."""
    try:
        yield
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        if isinstance(error, RunError):
            raise
        raise RunError(f"{path}: is not a file of scores ({error!r}); measure the run again") from error


def hashes_of(path: Path, content: Mapping[str, Any]) -> dict[str, str | None]:
    """The settings hash of each sequence: one for all, or joined with commas in the order of a study's runs."""
    joined = content["provenance"].get("hash")
    names = list(dict.fromkeys(entry["sequence"] for entry in content["sequences"]))
    hashes: list[str | None] = list(joined.split(", ")) if joined else [None]
    hashes = hashes * len(names) if len(hashes) == 1 else hashes
    if len(hashes) != len(names):
        raise RunError(f"{path}: has {len(hashes)} settings hashes for {len(names)} sequences; name the run folders")
    return dict(zip(names, hashes, strict=True))


def folder_of(path: Path, entry: Mapping[str, Any], digest: str | None) -> Path | None:
    """The run folder of an entry of a file of scores, beside it or one below; None where there is none.

    digest: the settings hash of its sequence. Raises RunError where the folder has been rendered again since. Not for
    code alone where the file is a copy with a name of its own, as one from before a change is: it has no folder then.
    """
    sequence, own = check_part(str(entry["sequence"]), "sequence"), path.name == "scores.json"
    held = {run: Record.read(run) for run in (path.parent, path.parent / sequence) if (run / "run.json").is_file()}
    found = {run: record for run, record in held.items() if record.sequence.get("name") == sequence}
    for run, record in found.items():
        if not _older(entry, digest, record):
            return run
    for run, record in found.items():
        if own or digest not in (None, record.hash):
            of = f" (hash {record.hash}, scores {digest})" if digest not in (None, record.hash) else ""
            named = "" if run == path.parent else f", and name it in place of {path.parent}"
            raise RunError(
                f"{run}: was rendered again since it was measured{of}; measure it: swimlab measure {run}{named}"
            )
    if own and path.parent in held and not found:
        now = held[path.parent].sequence.get("name")
        raise RunError(
            f"{path.parent}: was rendered again since it was measured ({now}, scores {sequence}); "
            f"measure it: swimlab measure {path.parent}"
        )
    return None


def _older(entry: Mapping[str, Any], digest: str | None, record: Record) -> bool:
    """Whether an entry's pictures have been rendered again, under other settings, by other code or by the same."""
    if digest is not None and record.hash != digest:
        return True
    return bool(record.rendered.get(entry["technique"]) != entry.get("rendered"))
