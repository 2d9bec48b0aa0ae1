"""What a command would render, said instead of done."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from swimlab.render.plan import Plan
from swimlab.render.run import earlier_record, lacking, outdated
from swimlab.runs.counting import counted


def print_plans(plans: Sequence[Plan], runs: Sequence[Path], *, force: bool, json_output: bool = False) -> None:
    """Print a line a run: its folder, sequence, size, frames and techniques, and how many pictures lack; or JSON.

    Raises RunError where rendering would: a folder that holds a run of other settings, unless `force`.
    """
    work: list[dict[str, Any]] = [
        {
            "run": str(run),
            "sequence": plan.sequence.name,
            "size": "{}x{}".format(*plan.sequence.size),
            "frames": len(plan.frames),
            "techniques": plan.techniques,
            "pictures": len(plan.frames) * len(plan.techniques),
            "done": pictures_there(plan, run, force=force),
        }
        for plan, run in zip(plans, runs, strict=True)
    ]
    if json_output:
        print(json.dumps(work, indent=1))
        return
    for row in work:
        what = f"{row['sequence']}, {row['size']}, {counted(row['frames'], 'frame')} of {', '.join(row['techniques'])}"
        print(f"{row['run']}: {what}: {row['pictures'] - row['done']} of {row['pictures']} pictures to render")


def pictures_there(plan: Plan, run: Path, *, force: bool) -> int:
    """How many of a plan's pictures need not be rendered. Raises RunError for a run of other settings."""

    record = None if force else earlier_record(plan, run, force=False)
    if record is None:
        return 0
    kept = set(plan.techniques) - set(outdated(plan, record))
    return len(kept) * len(plan.frames) - len(lacking(plan, run, kept, plan.frames))
