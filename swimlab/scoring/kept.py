"""Scores that are kept: an entry of scores.json is taken as it is where measuring again would give the same.

Each entry carries a key, the hash of all that decides it: the bytes of its frames and of those of reference and
geometry, how they are looked at, and the code that measures.
"""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import metrics
from metrics.display import Domain
from metrics.machine import cores
from swimlab.runs.frames import frame_path
from swimlab.runs.hashes import hash_file, hash_of
from swimlab.runs.record import ERROR, GEOMETRY, REFERENCE, Record, RunError
from swimlab.runs.scores import read_scores

_ROOMS = ("footage", "runs", "scoring")
_PACKAGES = ("numpy", "scipy", "warp-lang", "opencv-contrib-python-headless", "OpenImageIO")
_LOOK = ("name", "fps", "size", "seed", "viewing", "display")


def keys_of(run: Path, record: Record, tests: Sequence[str], *, domain: Domain, device: str) -> dict[str, str]:
    """Technique -> key of its scores; none where a picture is missing, which measuring tells.

    Nor for what a view of OpenColorIO shows: its configuration may have changed in any of the files that it names.
    """
    if domain == "display" and record.sequence.get("display", {}).get("view") is not None:
        return {}
    shared = [name for name in (GEOMETRY, REFERENCE, ERROR) if (run / name).is_dir()]
    try:
        with ThreadPoolExecutor(cores()) as pool:
            names = [*tests, *shared]
            hashes = dict(zip(names, pool.map(lambda name: _pictures(run, name, record.frames), names), strict=True))
    except FileNotFoundError:
        return {}
    content = {
        "code": _code(),
        "domain": domain,
        "device": device,
        "settings": record.hash,
        "frames": record.frames,
        "sequence": {key: record.sequence.get(key) for key in _LOOK},
        "shared": [hashes[name] for name in shared],
        "techniques with it": [name for name in shared if name in record.techniques],
    }
    return {name: hash_of(content | {"test": hashes[name]}) for name in tests}


def kept_entries(run: Path, keys: Mapping[str, str]) -> dict[str, dict[str, Any]]:
    """Technique -> its entry of the run's scores.json, where that has the technique's key."""
    try:
        entries = read_scores(run)["sequences"]
        return {name: entry for entry in entries if entry.get("key") == keys.get(name := entry["technique"], "")}
    except (RunError, KeyError, TypeError, AttributeError):
        return {}


def _pictures(run: Path, name: str, frames: Iterable[int]) -> list[str]:
    return [hash_file(frame_path(run, name, frame)) for frame in frames]


@cache
def _code() -> str:
    """Hash of the files that turn pictures into scores, and of the packages that they use."""
    home = Path(__file__).parents[1]
    folders = [Path(metrics.__file__).parent, *(home / room for room in _ROOMS)]
    files = [path for folder in folders for path in sorted(folder.rglob("*.py"))]
    return hash_of([[version(package) for package in _PACKAGES], [hash_file(path) for path in files]])
