"""`swimlab render`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swimlab.cli.dry_run import print_plans
from swimlab.cli.options import Rendering, run_folder, technique_names
from swimlab.cli.terminal import progress
from swimlab.render.plan import Plan
from swimlab.render.run import render_run
from swimlab.render.texture_pictures import check_targets, write_run_targets


def render_command(
    sequence: str,
    /,
    *,
    techniques: Annotated[str | None, Parameter(name=["--techniques", "-t"])] = None,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    targets: Annotated[bool, Parameter(negative="")] = False,
    rendering: Rendering | None = None,
) -> int:
    """Render a sequence under one or several techniques into a run folder.

    A folder that holds part of the same run is completed; one that holds another run is refused.

    Parameters
    ----------
    sequence:
        Name of a sequence in the library, or a .toml file.
    techniques:
        Techniques, separated by commas (default: all).
    output:
        Run folder (default: runs/SEQUENCE).
    targets:
        Write the texture-space pictures of tsl too: RUN/targets/FRAME/SEGMENT.exr (light) and .png (normals, light).
    """
    rendering = rendering or Rendering()
    plan = rendering.plan(sequence, technique_names(techniques))
    run = output or run_folder(plan.sequence.name)
    if targets:
        check_targets(plan)
    if rendering.dry_run:
        print_plans([plan], [run], force=rendering.force)
        return 0
    render_with_progress(plan, run, rendering)
    if targets:
        _targets_with_progress(plan, run, rendering)
    print(run)
    return 0


def _targets_with_progress(plan: Plan, run: Path, rendering: Rendering) -> None:
    with progress(f"targets of {plan.sequence.name}", len(plan.frames), quiet=rendering.quiet) as advance:
        write_run_targets(
            plan, run, threads=rendering.threads, device=rendering.device, advance=lambda: advance("targets")
        )


def render_with_progress(plan: Plan, run: Path, rendering: Rendering) -> None:
    """Render a plan, showing how far it is."""

    steps = len(plan.frames) * len(plan.techniques)
    quiet, verbose = rendering.quiet, rendering.verbose
    with progress(f"rendering {plan.sequence.name}", steps, quiet=quiet, verbose=verbose) as advance:
        render_run(
            plan,
            run,
            force=rendering.force,
            threads=rendering.threads,
            device=rendering.device,
            command=shlex.join(["swimlab", *sys.argv[1:]]),
            advance=advance,
        )
