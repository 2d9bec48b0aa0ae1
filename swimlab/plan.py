"""What to render: a sequence, techniques, frames, and the hash of all that decides the pixels."""

import hashlib
import json
from dataclasses import dataclass
from math import isqrt
from typing import Any

from sequences import Sequence
from swimlab import __version__
from swimlab.catalogue import technique_settings
from swimlab.record import RunError
from swimlab.settings import Settings


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
        """The settings hash: 16 hexadecimal digits over all that decides the pixels, the map files' bytes included.

        Only what is not the default counts, so that one more technique, setting or key of the sequence file does not
        make earlier runs and baselines strangers.
        """
        content = {
            "swimlab": __version__,
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


def parse_frames(text: str, count: int) -> tuple[int, ...]:
    """Frames of a sequence of `count` from a range as '0-31', '0-30x2' or '3,5'. Raises RunError."""
    from fileseq.exceptions import ParseException
    from fileseq.frameset import FrameSet

    try:
        frames = tuple(sorted({int(str(frame)) for frame in FrameSet(text)}))
    except (ParseException, ValueError) as error:
        raise RunError(f"--frames {text}: not a range of frames; write 0-31, 0-30x2 or 3,5") from error
    outside = [frame for frame in frames if not 0 <= frame < count]
    if outside or not frames:
        raise RunError(f"--frames {text}: the sequence has frames 0-{count - 1}")
    return frames


def check_samples(samples: int) -> int:
    """The number itself where it is a square from 4 to 4096. Raises RunError otherwise."""
    if not 4 <= samples <= 4096 or isqrt(samples) ** 2 != samples:
        raise RunError(f"--samples {samples}: must be a square number from 4 to 4096, as 16, 64 or 256")
    return samples
