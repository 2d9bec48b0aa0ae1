"""Rendering a chunk into its folder: whole or not at all."""

import json
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from threading import Lock
from typing import Any

from metrics.kernels.launch import Launcher
from sequences import Sequence
from swimlab.render.catalogue import own_code
from swimlab.render.plan import Plan
from swimlab.render.renderer import Renderer
from swimlab.runs.files import temporary_path, write_json
from swimlab.runs.frames import COLOUR, FrameError, read_channels
from swimlab.runs.frames import GEOMETRY as GEOMETRY_CHANNELS
from swimlab.runs.provenance import SWIMLAB
from swimlab.runs.record import GEOMETRY, RunError
from swimlab.sweep.chunk import Chunk

RENDERING = Lock()
"""One chunk at a time in a process: it takes all of the threads, and two at once would build the same kernels."""


def render_chunk(chunk: Chunk, out: Path, threads: int | None) -> None:
    """Render a chunk's frames into its folder beneath `out`, with chunk.json beside them; nothing where it is there.

    Safe to be called for the same chunk in several processes and machines at once. Raises RunError where this is not
    the version of swimlab, or the code of a technique of your own, that made the chunk, and all that rendering raises.
    """
    if chunk.version != SWIMLAB:
        raise RunError(f"this machine has swimlab {SWIMLAB} and the sweep was made by {chunk.version}; install that")
    if chunk.code != own_code().get(chunk.technique):
        raise RunError(
            f"this machine lacks the sweep's {chunk.technique!r}, or has another; "
            "let SWIMLAB_TECHNIQUES name the same files here"
        )
    target = chunk.path(out)
    if target.exists():
        return
    with RENDERING, _whole(target) as folder, Launcher(threads=threads) as launcher:
        renderer = Renderer(_plan(chunk), launcher, digest=chunk.digest)
        rows = [_write(renderer, chunk, frame, folder) for frame in chunk.frames]
        about = {key: value for key, value in asdict(chunk).items() if key not in {"sequence", "folder"}}
        write_json(folder / "chunk.json", about | {"sequence": chunk.sequence, "rows": rows})


def read_rows(chunk: Chunk, out: Path) -> list[dict[str, Any]]:
    """Of each frame of a finished chunk its number, ms, shaded samples and rms error, as far as it has them.

    Raises RunError where the chunk is damaged.
    """
    path = chunk.path(out) / "chunk.json"
    try:
        rows: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["rows"]
    except (OSError, ValueError, KeyError) as error:
        raise RunError(
            f"{path}: is missing or damaged ({error}); delete {path.parent}, and the same command renders it again"
        ) from error
    return rows


def remove_damaged(chunks: Iterable[Path]) -> list[Path]:
    """Remove the folders of chunks of which a frame cannot be read; return them."""
    removed = [folder for folder in chunks if not all(map(_is_sound, folder.glob("*/*.exr")))]
    for folder in removed:
        shutil.rmtree(folder, ignore_errors=True)
    return removed


def _is_sound(frame: Path) -> bool:
    try:
        read_channels(frame, GEOMETRY_CHANNELS if frame.parent.name == GEOMETRY else COLOUR)
    except FrameError:
        return False
    return True


def _plan(chunk: Chunk) -> Plan:
    sequence = Sequence.model_validate(chunk.sequence, context={"folder": Path(chunk.folder)})
    techniques = () if chunk.technique == GEOMETRY else (chunk.technique,)
    return Plan(sequence, techniques, chunk.frames, chunk.samples, chunk.half)


def _write(renderer: Renderer, chunk: Chunk, frame: int, folder: Path) -> dict[str, Any]:
    """One frame's files; its row of chunk.json."""
    shot = renderer.shot(frame)
    if chunk.technique == GEOMETRY:
        renderer.write_geometry(shot, folder)
        return {"frame": frame}
    picture = renderer.write_picture(shot, chunk.technique, folder)._asdict()
    return {"frame": frame, **{key: value for key, value in picture.items() if value is not None}}


def clear_temporaries(out: Path) -> None:
    """Remove what killed processes left of chunks that are done by now."""
    for folder in (out / "chunks").glob("*/.*.tmp"):
        if (folder.parent / folder.name.split(".")[1]).exists():
            shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def _whole(target: Path) -> Iterator[Path]:
    """A temporary folder that takes the place of `target` when the block ends well and vanishes when it does not."""
    folder = temporary_path(target)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        yield folder
        folder.rename(target)
    except Exception:
        # Where another process was first, its result is the same, and it may have cleared this one away.
        if not target.exists():
            raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)
