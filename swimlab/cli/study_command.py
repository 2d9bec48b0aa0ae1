"""`swimlab study`."""

import json
from collections import Counter
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from metrics.display import Domain
from swimlab.cli.dry_run import print_plans
from swimlab.cli.measure_command import measure_with_progress
from swimlab.cli.options import Rendering, technique_names
from swimlab.cli.render_command import render_with_progress
from swimlab.cli.score_table import print_scores
from swimlab.report.contact import write_contact_sheet
from swimlab.report.page import write_report
from swimlab.runs.files import write_json
from swimlab.runs.record import REFERENCE, RunError
from swimlab.runs.scores import merge_scores

ROAD = ("road-shift", "road-drive", "road-scale")
SHEET_FRAMES = 3


def study_command(
    *sequences: str,
    techniques: Annotated[str | None, Parameter(name=["--techniques", "-t"])] = None,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("runs/study"),
    domain: Domain = "linear",
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    rendering: Rendering | None = None,
) -> int:
    """Render the techniques and the reference, measure them and write a report.

    One sequence makes OUTPUT a run folder; several make a run folder each in it, beside scores and report of all.

    Parameters
    ----------
    sequences:
        Names of sequences in the library, or .toml files (default: the three road sequences).
    techniques:
        Techniques, separated by commas (default: all); the reference is always rendered.
    output:
        Folder to write.
    domain:
        Measure linear radiance, or display codes, as the sequence's [display] says (else exposure 1, clamped, sRGB).
    json_output:
        Print the scores as JSON instead of a table.
    """
    rendering = rendering or Rendering()
    names = technique_names(None if techniques is None else f"{techniques},{REFERENCE}")
    plans = [rendering.plan(name, names) for name in sequences or ROAD]
    for name, count in Counter(plan.sequence.name for plan in plans).items():
        if count > 1:
            raise RunError(
                f"{name}: {count} of the sequences are named so, and would write one folder; rename or drop one"
            )
    folders = [output if len(plans) == 1 else output / plan.sequence.name for plan in plans]
    if rendering.dry_run:
        print_plans(plans, folders, force=rendering.force, json_output=json_output)
        return 0
    for plan, run in zip(plans, folders, strict=True):
        render_with_progress(plan, run, rendering)
    all_scores = [measure_with_progress(run, domain, quiet=rendering.quiet) for run in folders]
    merged = merge_scores(all_scores)
    if len(folders) > 1:
        write_json(output / "scores.json", merged)
    write_report(folders, merged, output / "report.html")
    for plan, run in zip(plans, folders, strict=True):
        rows = sorted(names, key=lambda name: name == REFERENCE)
        write_contact_sheet(run, run / "contact.png", techniques=rows, frames=plan.frames[:SHEET_FRAMES])
    if json_output:
        print(json.dumps(merged, indent=1, allow_nan=False))
        return 0
    print_scores(all_scores)
    print(output / "report.html")
    return 0
