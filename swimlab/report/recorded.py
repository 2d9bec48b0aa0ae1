"""What a run folder says about itself, read from its run.json."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

REFERENCE = "reference"


class ReportError(ValueError):
    """A run folder from which no report can be made; the message names the file and how to mend it."""


@dataclass(frozen=True)
class Run:
    """A run folder of one sequence. `techniques` is in display order, the reference last if there is one."""

    folder: Path
    sequence: str
    fps: float
    techniques: tuple[str, ...]
    frames: tuple[int, ...]
    milliseconds: dict[str, float]
    settings: dict[str, Any]
    provenance: dict[str, Any]

    @property
    def resizes(self) -> bool:
        """Whether every frame has its own size."""
        return bool(self.settings.get("motion", {}).get("kind") == "scale")


def open_run(folder: Path) -> Run:
    """Read RUN/run.json. Raises ReportError where it is missing or lacks a key."""
    path = folder / "run.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        settings = content["sequence"]
        techniques = [name for name in content["techniques"] if name != REFERENCE]
        if (folder / REFERENCE).is_dir():
            techniques.append(REFERENCE)
        times = content.get("times", {})
        return Run(
            folder=folder,
            sequence=settings["name"],
            fps=float(settings.get("fps", 60)),
            techniques=tuple(techniques),
            frames=tuple(content["frames"]),
            milliseconds={n: float(t["ms_per_frame"]) for n, t in times.items() if "ms_per_frame" in t},
            settings=settings,
            provenance=content.get("provenance", {}),
        )
    except FileNotFoundError:
        raise ReportError(f"{path}: is missing; name a run folder that `swimlab render` or `study` wrote") from None
    except (ValueError, KeyError, TypeError) as problem:
        raise ReportError(f"{path}: is not a run description ({problem!r}); render the run again") from problem
