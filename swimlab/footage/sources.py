"""The files that brought frames are read from: what they were when they were measured, and whether they still are."""

import os
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from metrics.machine import cores
from swimlab.footage.between import find_vectors
from swimlab.footage.pattern import find_files, is_video, parse_range
from swimlab.footage.request import ESTIMATE, Request
from swimlab.runs.frames import FrameError
from swimlab.runs.hashes import hash_file
from swimlab.runs.record import REFERENCE

Inputs = Mapping[str, Mapping[str, Any]]
"""Input -> its name and its files, as run.json holds them: a build by its own name, and what builds share."""


class Given(NamedTuple):
    """An input as it is named, and the files that there are of it."""

    name: str
    paths: list[Path]


def find_inputs(requests: Mapping[str, Request]) -> dict[str, Given]:
    """The files of builds, by the builds' names, and of what builds share.

    Raises one FrameError, a line each, for all inputs that are not there.
    """
    first = next(iter(requests.values()))
    if first.frames is not None:
        parse_range(first.frames, "--frames")
    of_files = first.motion not in (None, ESTIMATE) and first.velocity is None and not is_video(str(first.motion))
    shared = {
        REFERENCE: first.reference,
        "motion": first.motion if of_files else None,
        "motion mask": first.motion_mask,
        "depth": first.depth,
        "mask": first.mask,
    }
    names = {name: request.test for name, request in requests.items()} | shared
    found: dict[str, Given] = {}
    problems: list[str] = []
    for what, name in names.items():
        try:
            if name is not None:
                find = find_vectors if what in ("motion", "motion mask") else find_files
                paths = find(name, frames=first.frames).paths
                found[what] = Given(name, [path for path in paths if path.is_file()])
        except FrameError as error:
            problems.append(f"{what}: {error}" if what in requests and len(requests) > 1 else str(error))
    if problems:
        raise FrameError("\n".join(problems))
    jitter = first.motion_jitter
    if jitter not in (None, ESTIMATE) and (path := Path(str(jitter))).is_file():
        found["motion jitter"] = Given(str(jitter), [path])
    return found


def common_folder(paths: Iterable[str]) -> str | None:
    """The folder that holds all of some files, whose names are absolute; None where they are on several drives."""
    try:
        return os.path.commonpath([str(Path(path).parent) for path in paths])
    except ValueError:
        return None


def files_of(inputs: Inputs) -> dict[str, Mapping[str, Any]]:
    """Path -> what is known of the file."""
    return {file["path"]: file for given in inputs.values() for file in given["files"]}


def hash_inputs(found: Mapping[str, Given], known: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Inputs as run.json holds them. known: as `files_of` gives; a file of the size and time there is not read."""

    def described(path: Path) -> dict[str, Any]:
        stat = path.stat()  # before it is read, so that a later change moves it
        now = {"path": str(path.absolute()), "bytes": stat.st_size, "modified": stat.st_mtime_ns}
        earlier = known.get(str(now["path"]), {})
        same = {key: earlier.get(key) for key in now} == now and "sha256" in earlier
        return now | {"sha256": earlier["sha256"] if same else hash_file(path)}

    with ThreadPoolExecutor(cores()) as pool:
        return {
            what: {"name": given.name, "files": list(pool.map(described, given.paths))} for what, given in found.items()
        }


def changes(inputs: Inputs, *, when: str = "since it was measured") -> Iterator[str]:
    """A sentence for each input of which files are gone or have changed, with the first one's name."""
    for what, given in inputs.items():
        gone, changed = [], []
        for file in given["files"]:
            path = Path(file["path"])
            try:
                stat = path.stat()
                size, time = stat.st_size == file["bytes"], stat.st_mtime_ns == file["modified"]
                if not size or (not time and hash_file(path) != file["sha256"]):
                    changed.append(path)
            except OSError:
                gone.append(path)
        for paths, how in ((gone, "is gone"), (changed, "has changed")):
            if paths:
                more = f"{len(paths)} of the {len(given['files'])} files of " if len(paths) > 1 else ""
                yield f"{paths[0]}: {how} {when} ({more}{what}); put it back, or measure the frames again"


def check_unchanged(inputs: Inputs, *, when: str = "since it was measured") -> None:
    """Raise FrameError, a line for each input of which files are gone or have changed."""
    found = list(changes(inputs, when=when))
    if found:
        raise FrameError("\n".join(found))
