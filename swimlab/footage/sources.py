"""The files that brought frames are read from: what they were when they were measured, and whether they still are."""

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from metrics.machine import cores
from swimlab.footage.pattern import find_files
from swimlab.footage.request import ESTIMATE, Request
from swimlab.runs.frames import FrameError
from swimlab.runs.hashes import hash_file
from swimlab.runs.record import REFERENCE


def inputs_of(requests: Mapping[str, Request]) -> dict[str, dict[str, Any]]:
    """Input -> its name and its files, as run.json holds them. Builds have their own names."""
    first = next(iter(requests.values()))
    shared = {
        REFERENCE: first.reference,
        "motion": first.motion if first.motion != ESTIMATE and first.velocity is None else None,
        "motion mask": first.motion_mask,
        "motion jitter": first.motion_jitter if first.motion_jitter != ESTIMATE else None,
        "depth": first.depth,
        "mask": first.mask,
    }
    names = {name: request.test for name, request in requests.items()} | shared
    return {what: {"name": name, "files": _files(name, first.frames)} for what, name in names.items() if name}


def check_unchanged(what: str, given: Mapping[str, Any]) -> None:
    """Raise FrameError naming the first file of an input that is gone or has changed since it was measured."""
    gone, changed = [], []
    for file in given["files"]:
        path = Path(file["path"])
        try:
            stat = path.stat()
        except OSError:
            gone.append(path)
            continue
        if stat.st_size != file["bytes"] or (
            stat.st_mtime_ns != file["modified"] and hash_file(path) != file["sha256"]
        ):
            changed.append(path)
    for paths, how in ((gone, "is gone"), (changed, "has changed")):
        if paths:
            more = f" ({len(paths)} of the {len(given['files'])} files of {what})" if len(paths) > 1 else f" ({what})"
            raise FrameError(f"{paths[0]}: {how} since it was measured{more}; put it back, or measure the frames again")


def _files(name: str, frames: str | None) -> list[dict[str, Any]]:
    paths: Iterable[Path] = (path for path in find_files(name, frames=frames).paths if path.is_file())
    with ThreadPoolExecutor(cores()) as pool:
        return list(pool.map(_file, paths))


def _file(path: Path) -> dict[str, Any]:
    stat = path.stat()
    return {
        "path": str(path.absolute()),
        "bytes": stat.st_size,
        "modified": stat.st_mtime_ns,
        "sha256": hash_file(path),
    }
