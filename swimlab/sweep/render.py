"""Rendering a chunk into its folder: whole or not at all."""

import json
import os
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from threading import Lock
from typing import Any

from sequences import Sequence
from swimlab import __version__
from swimlab.catalogue import model_of
from swimlab.files import write_json
from swimlab.frames import COLOUR, frame_path, write_channels, write_frame, write_geometry
from swimlab.geometry import describe_geometry
from swimlab.launch import Launcher
from swimlab.material import load_material
from swimlab.record import RunError
from swimlab.run import ERROR, GEOMETRY, begin, check_range, rms_error
from swimlab.shot import Shot
from swimlab.sweep.chunk import Chunk

RENDERING = Lock()
"""One chunk at a time in a process: it takes all of the threads, and two at once would build the same kernels."""


def render_chunk(chunk: Chunk, out: Path, threads: int | None) -> None:
    """Render a chunk's frames into its folder beneath `out`, with chunk.json beside them; nothing where it is there.

    Safe to be called for the same chunk in several processes and machines at once. Raises RunError where this is not
    the version of swimlab that made the chunk, and whatever rendering raises.
    """
    if chunk.version != __version__:
        raise RunError(
            f"this machine has swimlab {__version__} and the sweep was made by {chunk.version}; install that"
        )
    target = chunk.path(out)
    if target.exists():
        return
    with RENDERING, _whole(target) as folder, Launcher(threads=threads) as launcher:
        frames = _Frames(chunk, folder, launcher)
        rows = [frames.write(frame) for frame in chunk.frames]
        about = {key: value for key, value in asdict(chunk).items() if key not in {"sequence", "folder"}}
        write_json(folder / "chunk.json", about | {"sequence": chunk.sequence, "rows": rows})


def read_rows(chunk: Chunk, out: Path) -> list[dict[str, Any]]:
    """Of each frame of a finished chunk its number, ms, shaded samples and rms error, as far as it has them."""
    rows: list[dict[str, Any]] = json.loads((chunk.path(out) / "chunk.json").read_text(encoding="utf-8"))["rows"]
    return rows


class _Frames:
    """Renders and writes the frames of a chunk, in turn."""

    def __init__(self, chunk: Chunk, folder: Path, launcher: Launcher) -> None:
        self._chunk, self._folder, self._launcher = chunk, folder, launcher
        self._sequence = Sequence.model_validate(chunk.sequence, context={"folder": Path(chunk.folder)})
        self._model = model_of(self._sequence)
        self._material = load_material(self._sequence, launcher, twisted=self._model.anisotropic)
        self._render = None if chunk.technique == GEOMETRY else begin(self._sequence, chunk.technique)
        self._metadata = {"swimlab:hash": chunk.digest, "swimlab:version": __version__}

    def write(self, frame: int) -> dict[str, Any]:
        """One frame's files; its row of chunk.json."""
        chunk = self._chunk
        shot = Shot(self._sequence, frame, self._material, self._model, chunk.samples, self._launcher)
        path = frame_path(self._folder, chunk.technique, frame)
        if self._render is None:
            write_geometry(path, describe_geometry(shot), metadata=self._metadata)
            return {"frame": frame}
        started = time.perf_counter()
        picture = self._render(shot)
        row = {"frame": frame, "ms": 1e3 * (time.perf_counter() - started), "shaded": picture.shaded}
        check_range(picture, chunk.technique, frame, half=chunk.half)
        write_frame(path, picture.rgba, half=chunk.half, metadata=self._metadata)
        if picture.error is not None:
            error = frame_path(self._folder, ERROR, frame)
            write_channels(error, picture.error, COLOUR, half=False, metadata=self._metadata)
            row["rms_error"] = rms_error(picture.rgba, picture.error)
        return row


def temporary_folder(target: Path) -> Path:
    """Where a chunk is written until it is whole: of its own for every process of every machine."""
    return target.with_name(f".{target.name}.{socket.gethostname()}.{os.getpid()}.tmp")


def clear_temporaries(out: Path) -> None:
    """Remove what killed processes left of chunks that are done by now."""
    for folder in (out / "chunks").glob("*/.*.tmp"):
        if (folder.parent / folder.name.split(".")[1]).exists():
            shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def _whole(target: Path) -> Iterator[Path]:
    """A temporary folder that takes the place of `target` when the block ends well and vanishes when it does not."""
    folder = temporary_folder(target)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        yield folder
        try:
            folder.rename(target)
        except OSError:
            # Another process was first; its result is the same.
            if not target.exists():
                raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)
