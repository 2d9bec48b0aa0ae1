"""Run folders from finished chunks, as `swimlab render` would have written them."""

import shutil
from collections.abc import Iterable
from pathlib import Path
from statistics import median

from swimlab.files import replacing
from swimlab.frames import frame_path
from swimlab.plan import Plan
from swimlab.record import REFERENCE, Record
from swimlab.run import ERROR, GEOMETRY, open_record
from swimlab.sweep.chunk import Chunk, Chunks
from swimlab.sweep.render import read_rows


def assemble(plan: Plan, chunks: Chunks, out: Path, *, command: str) -> tuple[Path, Record] | None:
    """Make OUT/runs/NAME of the techniques whose chunks are all done; None where geometry or reference are not.

    Frames are hard links to those of the chunks, or copies where the file system has no links.
    """
    done = {name: parts for name, parts in chunks.items() if all(part.path(out).exists() for part in parts)}
    if GEOMETRY not in done or REFERENCE not in done:
        return None
    run = out / "runs" / plan.sequence.name
    record = open_record(plan, run, force=True, command=command)
    record.techniques = [name for name in plan.techniques if name in done]
    record.frames = list(plan.frames)
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


def _place_all(parts: Iterable[Chunk], folders: Iterable[str], out: Path, run: Path) -> None:
    for part in parts:
        for folder in folders:
            for frame in part.frames:
                _place(frame_path(part.path(out), folder, frame), frame_path(run, folder, frame))


def _place(source: Path, target: Path) -> None:
    if target.exists():
        there, wanted = target.stat(), source.stat()
        if (there.st_size, there.st_mtime_ns) == (wanted.st_size, wanted.st_mtime_ns):
            return
    with replacing(target) as temporary:
        try:
            temporary.hardlink_to(source)
        except OSError:
            shutil.copy2(source, temporary)
