"""Options that several commands share."""

from dataclasses import dataclass, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swimlab.footage.shot import is_shot
from swimlab.render.catalogue import techniques
from swimlab.render.plan import Plan, check_threads, make_plan
from swimlab.runs.record import RunError


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Rendering:
    """How to render.

    Parameters
    ----------
    frames:
        Frames to render, as 0-31, 0-30x2 or 3,5 (default: all).
    size:
        Size of the pictures in pixels, WIDTHxHEIGHT (default: the sequence's).
    samples:
        Samples a pixel of the reference, a square number.
    threads:
        Threads to render with (default: every core).
    device:
        Device to render on.
    float32:
        Write pictures as 32-bit floats instead of 16-bit.
    force:
        Render everything again, over what the folder holds.
    quiet:
        Show no progress.
    verbose:
        Say each picture when it is done, for logs.
    dry_run:
        Say what would be rendered, and render nothing.
    """

    frames: str | None = None
    size: str | None = None
    samples: int = 64
    threads: int | None = None
    device: str = "cpu"
    float32: Annotated[bool, Parameter(name="--float", negative="")] = False
    force: Annotated[bool, Parameter(negative="")] = False
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False
    verbose: Annotated[bool, Parameter(name=["--verbose", "-v"], negative="")] = False
    dry_run: Annotated[bool, Parameter(negative="")] = False

    def refuse_for_shots(self, name: str) -> None:
        """Raise RunError where an option of rendering comes with a shot file, whose frames are there already."""
        given = [field.name for field in fields(self) if getattr(self, field.name) != field.default]
        for option in (each for each in given if each != "quiet"):
            said = option.replace("32", "").replace("_", "-")
            raise RunError(f"--{said}: is for rendering, and the frames of {name} are there already; leave it out")

    def plan(self, sequence_name: str, techniques: tuple[str, ...]) -> Plan:
        """What to render of a sequence. Raises SequenceError or RunError naming every mistake."""

        if is_shot(sequence_name):
            raise RunError(f"{sequence_name}: is a shot file, whose frames are there: swimlab study {sequence_name}")
        check_threads(self.threads)
        return make_plan(
            sequence_name,
            techniques,
            size=None if self.size is None else parse_size(self.size),
            frames=self.frames,
            samples=self.samples,
            half=not self.float32,
        )


def technique_names(text: str | None) -> tuple[str, ...]:
    """Techniques from a list with commas, every one for None. Raises RunError naming an unknown one."""

    known = tuple(techniques())
    if text is None:
        return known
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        close = get_close_matches(unknown[0], known, n=1) if unknown else []
        guess = f"did you mean {close[0]!r}? " if close else ""
        raise RunError(f"-t {text}: names no technique; {guess}there are {', '.join(known)}")
    return tuple(name for name in known if name in names)


def run_folder(name: str) -> Path:
    """Where a run of this name goes when no folder is given."""
    return Path("runs") / name


def parse_size(text: str) -> tuple[int, int]:
    """Width and height from WIDTHxHEIGHT. Raises RunError."""

    try:
        width, height = (int(side) for side in text.lower().split("x"))
    except ValueError as error:
        raise RunError(f"--size {text}: write WIDTHxHEIGHT, as 640x360") from error
    return width, height
