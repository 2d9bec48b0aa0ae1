"""Measuring the configurations of a sweep, equal work once."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from metrics.display import Domain
from swimlab.render.plan import Plan
from swimlab.runs.configuration import UNTOLD, configuration
from swimlab.runs.files import write_json
from swimlab.runs.frames import FrameError
from swimlab.runs.hashes import hash_of
from swimlab.runs.provenance import SWIMLAB
from swimlab.runs.record import GEOMETRY, REFERENCE, Record, RunError
from swimlab.scoring.techniques import measure_techniques
from swimlab.sweep.chunk import Chunks
from swimlab.sweep.render import remove_damaged


def score_path(plan: Plan, chunks: Chunks, technique: str, domain: Domain, out: Path) -> Path:
    """File of a technique's scores, named by a hash over all that decides them: pictures and how they are looked at.

    Raises RunError where a view is of a configuration of OpenColorIO that depends on more than its files.
    """
    sequence = plan.sequence
    viewed = domain == "display" and sequence.display.view is not None
    colour = configuration() if viewed else None
    if colour is not None and not colour.whole:
        raise RunError(UNTOLD)
    content = {
        "swimlab": SWIMLAB,
        "pictures": [chunk.digest for name in (technique, REFERENCE, GEOMETRY) for chunk in chunks[name]],
        "technique": technique,
        "domain": domain,
        "viewing": sequence.viewing.model_dump(mode="json"),
        "display": sequence.display.model_dump(mode="json"),
        "seed": sequence.seed,
    } | ({} if colour is None else {"colour": colour.digest})
    return out / "scores" / f"{hash_of(content)}.json"


def measure_missing(run: Path, files: dict[str, Path], domain: Domain, chunks: Iterable[Path]) -> None:
    """Write the missing files of a run's techniques, each with the technique's entry of scores.json.

    They are measured together, as aligning the frames costs more than any of them. chunks: folders of the chunks that
    the run is made of; damaged ones are removed, so that the same command renders them again. Raises as `measure_run`.
    """
    missing = [name for name, path in files.items() if not path.exists()]
    try:
        entries = measure_techniques(run, Record.read(run), missing, domain=domain)
    except FrameError as error:
        if not (removed := remove_damaged(chunks)):
            raise
        raise FrameError(f"{error}; of its chunks {len(removed)} were damaged and are removed already") from error
    for entry in entries:
        write_json(files[entry["technique"]], entry)


def read_entry(path: Path, sequence: str) -> dict[str, Any]:
    """The entry that was written, perhaps for a configuration of another name, as one of `sequence`.

    Raises RunError where the file is damaged.
    """
    try:
        entry: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise RunError(f"{path}: is damaged ({error}); delete it, and the same command measures it again") from error
    return entry | {"sequence": sequence}
