"""What to render: a sequence, techniques, frames, and the hash of everything that the pixels depend on."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from math import isqrt
from pathlib import Path
from typing import Any

from fileseq.exceptions import ParseException
from fileseq.frameset import FrameSet

from metrics.ocio import find_view
from sequences import Sequence, SequenceError, load
from swimlab.render.catalogue import brdf_settings, technique_settings, techniques
from swimlab.render.settings import Settings
from swimlab.runs.provenance import SWIMLAB
from swimlab.runs.record import RunError


@dataclass(frozen=True)
class Plan:
    """What to render.

    samples: the reference's samples a pixel, a square number from 4. half: pictures as 16-bit floats.
    """

    sequence: Sequence
    techniques: tuple[str, ...]
    frames: tuple[int, ...]
    samples: int = 64
    half: bool = True

    def sequence_in_full(self) -> dict[str, Any]:
        """The sequence with every default, and every technique's settings, filled in; plain values."""
        settings = {name: chosen.model_dump() for name, chosen in self._settings().items()}
        return self.sequence.model_dump(mode="json") | {"techniques": settings}

    def digest(self) -> str:
        """The settings hash: 16 hexadecimal digits over all that the pixels depend on, map files' bytes included.

        Values equal to their defaults are left out, so that a new technique, setting or key of the sequence file does
        not change the hash of earlier runs and baselines.
        """
        content = {
            "swimlab": SWIMLAB,
            "sequence": self.sequence.model_dump(
                mode="json", exclude_defaults=True, exclude={"techniques", "viewing", "display"}
            ),
            "techniques": {n: s for n, chosen in self._settings().items() if (s := _changed(chosen))},
            "samples": self.samples,
            "half": self.half,
        }
        digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
        material = self.sequence.scene.material
        for value in (material.albedo, material.normal, material.gloss, material.twist):
            path = self.sequence.map_path(value) if value is not None else None
            if path is not None and path.is_file():
                digest.update(path.read_bytes())
        return digest.hexdigest()[:16]

    def _settings(self) -> dict[str, Settings]:
        given = self.sequence.techniques
        return {n: known.model_validate(given.get(n, {})) for n, known in technique_settings().items()}


def _changed(settings: Settings) -> dict[str, Any]:
    defaults = type(settings)().model_dump()
    return {key: value for key, value in settings.model_dump().items() if value != defaults[key]}


def load_sequence(name: str | Path) -> Sequence:
    """A sequence by name or file, checked against the known techniques, reflectance models and display views.

    Raises SequenceError with every problem at once; a view is looked up when there is no other.
    """
    loaded = load(name, technique_settings=technique_settings(), brdfs=brdf_settings())
    if loaded.display.view is not None:
        try:
            find_view(loaded.display.view)
        except ValueError as error:
            raise SequenceError([f"{name}: display.view: {error}"]) from error
    return loaded


def make_plan(
    sequence: str | Path | Sequence,
    only: Iterable[str] | None = None,
    *,
    size: tuple[int, int] | None = None,
    frames: str | None = None,
    samples: int = 64,
    half: bool = True,
) -> Plan:
    """The plan to render techniques of a sequence.

    sequence: a name from the library, a .toml file, or a Sequence. only: techniques by name, None: all.
    size: width and height in px, None: the sequence's. frames: as "0-7", None: all.
    Raises SequenceError for a faulty sequence, RunError for a faulty argument.
    """
    known = techniques()
    names = set(known if only is None else only)
    unknown = sorted(names - set(known))
    if unknown:
        close = get_close_matches(unknown[0], known, n=1)
        guess = f"did you mean {close[0]!r}? " if close else ""
        raise RunError(f"technique {unknown[0]!r}: is not known; {guess}there are {', '.join(known)}")
    loaded = sequence if isinstance(sequence, Sequence) else load_sequence(sequence)
    if size is not None:
        loaded = loaded.with_changes(size=size)
    return Plan(
        sequence=loaded,
        techniques=tuple(name for name in known if name in names),
        frames=parse_frames(f"0-{loaded.frames - 1}" if frames is None else frames, loaded.frames),
        samples=check_samples(samples),
        half=half,
    )


def parse_frames(text: str, count: int) -> tuple[int, ...]:
    """Frames of a sequence of `count` frames, from a range such as '0-31', '0-30x2' or '3,5'. Raises RunError."""
    try:
        frames = tuple(sorted({int(str(frame)) for frame in FrameSet(text)}))
    except (ParseException, ValueError) as error:
        raise RunError(f"--frames {text}: not a range of frames; write 0-31, 0-30x2 or 3,5") from error
    outside = [frame for frame in frames if not 0 <= frame < count]
    if outside or not frames:
        raise RunError(f"--frames {text}: the sequence has frames 0-{count - 1}")
    return frames


def check_threads(threads: int | None) -> int | None:
    """Return `threads` if it is None or at least 1. Raises RunError otherwise."""
    if threads is not None and threads < 1:
        raise RunError(f"--threads {threads}: must be at least 1")
    return threads


def check_samples(samples: int) -> int:
    """Return `samples` if it is a square number from 4 to 4096. Raises RunError otherwise."""
    if not 4 <= samples <= 4096 or isqrt(samples) ** 2 != samples:
        raise RunError(f"--samples {samples}: must be a square number from 4 to 4096, as 16, 64 or 256")
    return samples
