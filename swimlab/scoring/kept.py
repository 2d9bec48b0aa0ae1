"""Scores that are kept: an entry of scores.json is taken as it is where measuring again would give the same.

Each entry carries a key, the hash of all that decides it: the bytes of its frames and of what it is measured against,
how they are looked at, and the code that measures.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import asdict
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import metrics
from metrics.display import Domain
from metrics.machine import cores
from swimlab.footage.brought import from_anywhere, placed
from swimlab.footage.request import Request
from swimlab.footage.sources import Inputs, common_folder
from swimlab.runs.configuration import configuration
from swimlab.runs.files import write_json
from swimlab.runs.frames import frame_path
from swimlab.runs.hashes import hash_file, hash_of
from swimlab.runs.record import ERROR, GEOMETRY, REFERENCE, Record, RunError
from swimlab.runs.scores import read_scores

_ROOMS = ("footage", "runs", "scoring")
_PACKAGES = ("numpy", "scipy", "warp-lang", "opencv-contrib-python-headless", "OpenImageIO")
_OPTIONAL = ("av",)
_LOOK = ("name", "fps", "size", "seed", "viewing", "display")


def keys_of(run: Path, record: Record, tests: Sequence[str], *, domain: Domain, device: str) -> dict[str, str]:
    """Technique -> key of its scores; none where a picture is missing, which measuring tells.

    Nor for what a view shows of a configuration that depends on more than its files.
    """
    viewed = domain == "display" and record.sequence.get("display", {}).get("view") is not None
    colour = configuration() if viewed else None
    if colour is not None and not colour.whole:
        return {}
    shared = [name for name in (GEOMETRY, REFERENCE, ERROR) if (run / name).is_dir()]
    try:
        with ThreadPoolExecutor(cores()) as pool:
            names = [*tests, *shared]
            hashes = dict(zip(names, pool.map(lambda name: _pictures(run, name, record.frames), names), strict=True))
    except FileNotFoundError:
        return {}
    content = {
        "code": hash_of_code(),
        "domain": domain,
        "device": device,
        "settings": record.hash,
        "frames": record.frames,
        "sequence": {key: record.sequence.get(key) for key in _LOOK},
        "colour": None if colour is None else colour.digest,
        "shared": [hashes[name] for name in shared],
        "techniques with it": [name for name in shared if name in record.techniques],
    }
    return {name: hash_of(content | {"test": hashes[name]}) for name in tests}


def keys_of_builds(requests: Mapping[str, Request], inputs: Inputs, *, device: str) -> dict[str, str]:
    """Build -> key of its scores: what is asked, and the files of the build and of what builds share.

    Files count by their bytes and by where they are to each other: moved together they are the same. None where the
    configuration of OpenColorIO depends on more than its files. The sequence's name is no part of it.
    """
    colour = configuration()
    if colour is not None and not colour.whole:
        return {}
    content = {"code": hash_of_code(), "device": device, "colour": None if colour is None else colour.digest}
    shared = [what for what in inputs if what not in requests]

    def key(build: str, request: Request) -> str:
        named = [(what, file) for what in (build, *shared) for file in inputs[what]["files"]]
        home = common_folder([file["path"] for _, file in named])
        files = [(what, placed(file["path"], home), file["sha256"]) for what, file in named]
        return hash_of(content | {"request": asdict(from_anywhere(request, home=home)), "files": files})

    return {build: key(build, request) for build, request in requests.items()}


def kept_entries(run: Path, keys: Mapping[str, str], store: Path | None = None) -> dict[str, dict[str, Any]]:
    """Technique -> its entry of the run's scores.json or, as a file, of the store, where that has its key."""
    entries: list[dict[str, Any]] = []
    with suppress(RunError, KeyError, TypeError):
        entries = [entry for entry in read_scores(run)["sequences"] if isinstance(entry, dict)]
    found = {name: entry for entry in entries if entry.get("key") == keys.get(name := entry.get("technique", ""), "")}
    for name, key in keys.items():
        path = None if store is None or name in found else store / f"{key}.json"
        if path is not None and path.is_file():
            try:
                found[name] = {**json.loads(path.read_text(encoding="utf-8")), "technique": name}
            except ValueError:
                path.unlink()
    return found


def keep(store: Path, key: str, entry: Mapping[str, Any]) -> None:
    """Write an entry into the store, to be found by its key."""
    write_json(store / f"{key}.json", {**entry, "key": key})


def standing(run: Path, record: Record, entries: Sequence[Mapping[str, Any]], domain: str) -> dict[str, Any] | None:
    """The run's scores where they are these entries of this rendering already, so that nothing is to be written."""
    try:
        scores = read_scores(run)
        about = scores["provenance"]
    except (RunError, KeyError):
        return None
    same = (about.get("domain"), about.get("hash"), about.get("rendering")) == (domain, record.hash, record.provenance)
    return scores if same and scores.get("sequences") == entries and (run / "frames.csv").is_file() else None


def _pictures(run: Path, name: str, frames: Iterable[int]) -> list[str]:
    return [hash_file(frame_path(run, name, frame)) for frame in frames]


@cache
def hash_of_code(*rooms: str) -> str:
    """Hash of the files that turn pictures into scores, of those of more rooms, and of the packages that they use."""
    home = Path(__file__).parents[1]
    folders = [Path(metrics.__file__).parent, *(home / room for room in (*_ROOMS, *rooms))]
    paths = [path for folder in folders for path in sorted(folder.rglob("*"))]
    files = [path for path in paths if path.is_file() and path.suffix != ".pyc"]
    packages = [*map(version, _PACKAGES), *map(_version, _OPTIONAL)]
    return hash_of([packages, [hash_file(path) for path in files]])


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
