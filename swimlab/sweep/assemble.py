"""Run folders from finished chunks, as `swimlab render` would have written them."""

import json
import shutil
from collections.abc import Iterable
from pathlib import Path
from statistics import median

from swimlab.render.plan import Plan
from swimlab.render.run import earlier_record, open_record, outdated
from swimlab.runs.files import replacing
from swimlab.runs.frames import frame_path
from swimlab.runs.provenance import moment
from swimlab.runs.record import ERROR, GEOMETRY, REFERENCE, Record, RunError
from swimlab.sweep.chunk import Chunk, Chunks
from swimlab.sweep.render import read_rows


def assemble(plan: Plan, chunks: Chunks, out: Path, *, command: str) -> tuple[Path, Record] | None:
    """Make OUT/runs/NAME of the techniques whose chunks are all done; None where geometry or reference are not.

    Frames are hard links to the frames of the chunks, or copies where the file system has no links. A folder that is
    whole by its run.json is left as it is. Raises RunError naming a damaged chunk.
    """
    done = {name: parts for name, parts in chunks.items() if all(part.path(out).exists() for part in parts)}
    if GEOMETRY not in done or REFERENCE not in done:
        return None
    run = out / "runs" / plan.sequence.name
    if (whole := _whole(plan, done, out, run)) is not None:
        return run, whole
    record = open_record(plan, run, force=True, command=command)
    record.techniques = [name for name in plan.techniques if name in done]
    record.frames = list(plan.frames)
    record.rendered = dict.fromkeys(record.techniques, moment())
    record.times, record.reference_rms_error = {}, {}
    for name, parts in done.items():
        rows = [row for part in parts for row in read_rows(part, out)]
        record.reference_rms_error |= {str(row["frame"]): row["rms_error"] for row in rows if name == REFERENCE}
        if name != GEOMETRY:
            record.times[name] = {
                "ms_per_frame": median(row["ms"] for row in rows),
                "shaded_per_frame": median(row["shaded"] for row in rows),
                "frames": len(rows),
            }
        _place_all(parts, [name, ERROR] if name == REFERENCE else [name], out, run)
    record.write(run)
    return run, record


def _whole(plan: Plan, done: Chunks, out: Path, run: Path) -> Record | None:
    """The record of a run folder that was made of all these chunks, as they are."""
    record = earlier_record(plan, run, force=True)
    if record is None or outdated(plan, record):
        return None
    made_of = [name for name in plan.techniques if name in done], list(plan.frames)
    if (record.techniques, record.frames) != made_of:
        return None
    if record.sequence != json.loads(json.dumps(plan.sequence_in_full())):
        return None  # how it is looked at is no part of the hash
    made = (run / "run.json").stat().st_mtime_ns
    chunks = (part.path(out) / "chunk.json" for parts in done.values() for part in parts)
    return record if all(path.is_file() and path.stat().st_mtime_ns <= made for path in chunks) else None


def _place_all(parts: Iterable[Chunk], folders: Iterable[str], out: Path, run: Path) -> None:
    for part in parts:
        for folder in folders:
            for frame in part.frames:
                source = frame_path(part.path(out), folder, frame)
                if not source.is_file():
                    raise RunError(
                        f"{source}: is missing; delete {part.path(out)}, and the same command renders it again"
                    )
                _place(source, frame_path(run, folder, frame))


def _place(source: Path, target: Path) -> None:
    if target.exists():
        there, wanted = target.stat(), source.stat()
        if (there.st_size, there.st_mtime_ns) == (wanted.st_size, wanted.st_mtime_ns):
            return
    with replacing(target) as temporary:
        try:
            temporary.hardlink_to(source)
        except (OSError, NotImplementedError):  # the file system or Python has no links
            shutil.copy2(source, temporary)
