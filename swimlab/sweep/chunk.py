"""A chunk: some frames of one technique of one configuration, the piece of work that is done or lost as a whole."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from sequences import Sequence
from sequences.scene import Scene
from swimlab.render.catalogue import own_code, technique_settings, techniques
from swimlab.render.plan import Plan
from swimlab.runs.hashes import hash_file, hash_of
from swimlab.runs.provenance import SWIMLAB
from swimlab.runs.record import GEOMETRY, REFERENCE

NO_PIXELS = {"name", "techniques", "viewing", "display"}
"""Keys of a sequence that decide no pixel of a technique."""


@dataclass(frozen=True)
class Chunk:
    """Plain data, all that a worker needs but the map files.

    sequence: content of a sequence file; folder: where its map files are. technique: by name, or `geometry`.
    digest: 16 hexadecimal digits over all that decides the pixels; equal work has equal digits. code: hash of the
    technique's file where that is your own.
    """

    digest: str
    sequence: dict[str, Any]
    folder: str
    technique: str
    frames: tuple[int, ...]
    samples: int
    half: bool
    version: str = SWIMLAB
    code: str | None = None

    @property
    def label(self) -> str:
        """What it is, for people."""
        return f"{self.sequence['name']}, {self.technique}, frames {self.frames[0]}-{self.frames[-1]}"

    def path(self, out: Path) -> Path:
        """Folder of the result; it is there when the chunk is done."""
        return out / "chunks" / self.digest[:2] / self.digest


Chunks = dict[str, list[Chunk]]
"""The chunks of a plan by technique, the geometry among them, in the order of frames."""


def cut(plan: Plan, frames: int) -> Chunks:
    """A plan in chunks of so many frames.

    Before a chunk's first frame a recursive technique (`taa`) renders all from the clip's start on, so that the
    same bits come out however it is cut. Its chunks double in length, so that this at most doubles its work.
    """
    sequence = plan.sequence.model_dump(mode="json")
    folder = str(plan.sequence.folder.absolute())
    chunks: Chunks = {}
    for name in (GEOMETRY, *plan.techniques):
        recursive = name != GEOMETRY and techniques()[name].recursive and not plan.sequence.motion.resizes
        content, code = _content(plan, name), own_code().get(name)
        if code is not None:
            content["code"] = code
        chunks[name] = [
            Chunk(
                hash_of({**content, "frames": span}), sequence, folder, name, span, plan.samples, plan.half, code=code
            )
            for span in spans(plan.frames, frames, doubling=recursive)
        ]
    return chunks


def spans(frames: tuple[int, ...], size: int, *, doubling: bool) -> Iterator[tuple[int, ...]]:
    """Frames in runs of `size`; with `doubling` of as many as there are before the run's first, where that is more.

    A last run that would be shorter than that goes with the one before it.
    """
    while frames:
        taken = max(size, frames[0]) if doubling else size
        if doubling and len(frames) < 3 * taken:
            taken = len(frames)
        yield frames[:taken]
        frames = frames[taken:]


def _content(plan: Plan, name: str) -> dict[str, Any]:
    """All that decides a technique's pixels, less the defaults; for the geometry neither light nor maps count."""
    sequence = plan.sequence
    content: dict[str, Any] = {"swimlab": SWIMLAB, "technique": name, "seed": sequence.seed}
    if name == GEOMETRY:
        unlit = {"material": Scene().material, "sun": Scene().sun}
        sequence = sequence.model_copy(update={"scene": sequence.scene.model_copy(update=unlit)})
    else:
        settings = technique_settings()[name].model_validate(sequence.techniques.get(name, {}))
        content |= {"settings": settings.model_dump(mode="json"), "half": plan.half, "maps": _maps(sequence)}
    if name == REFERENCE:
        content["samples"] = plan.samples
    content["sequence"] = sequence.model_dump(mode="json", exclude_defaults=True, exclude=NO_PIXELS)
    return content


def _maps(sequence: Sequence) -> list[str]:
    material = sequence.scene.material
    named = [value for value in (material.albedo, material.normal, material.gloss, material.twist) if value]
    paths = [path for value in named if (path := sequence.map_path(value)) is not None and path.is_file()]
    return [_digest_of_file(path, path.stat().st_mtime_ns) for path in paths]


@lru_cache
def _digest_of_file(path: Path, changed: int) -> str:
    return hash_file(path)
