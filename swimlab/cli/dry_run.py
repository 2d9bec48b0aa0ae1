"""What a command would render, said instead of done."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from swimlab.plan import Plan


def print_plans(plans: Sequence["Plan"], runs: Sequence[Path], *, force: bool) -> None:
    """Print a line a run: its folder, sequence, size, frames and techniques, and how many pictures lack.

    Raises RunError where rendering would: a folder that holds a run of other settings, unless `force`.
    """
    for plan, run in zip(plans, runs, strict=True):
        count = len(plan.frames) * len(plan.techniques)
        width, height = plan.sequence.size
        lacking = count - pictures_there(plan, run, force=force)
        what = f"{plan.sequence.name}, {width}x{height}, {len(plan.frames)} frames of {', '.join(plan.techniques)}"
        print(f"{run}: {what}: {lacking} of {count} pictures to render")


def pictures_there(plan: "Plan", run: Path, *, force: bool) -> int:
    """How many of a plan's pictures need not be rendered. Raises RunError for a run of other settings."""
    from swimlab.frames import frame_path
    from swimlab.run import open_record

    if force or not (run / "run.json").exists():
        return 0
    open_record(plan, run, force=False, command="")
    return sum(frame_path(run, name, frame).exists() for name in plan.techniques for frame in plan.frames)
