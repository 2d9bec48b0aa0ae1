"""`swimlab measure`."""

import json
import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from swimlab.cli.progress import progress
from swimlab.measure import Domain
from swimlab.record import Record


def measure_command(
    run: Path,
    /,
    *,
    domain: Domain = "linear",
    json_output: Annotated[bool, Parameter(name="--json", negative="")] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
) -> int:
    """Measure the techniques of a run folder against its reference; write scores.json and frames.csv into it.

    Parameters
    ----------
    run:
        Run folder.
    domain:
        Measure linear radiance, or display codes (exposure 1, clamped, sRGB).
    json_output:
        Print the scores as JSON instead of a table.
    quiet:
        Show no progress.
    """
    scores = measure_with_progress(run, domain, quiet=quiet)
    if json_output:
        print(json.dumps(scores, indent=1, allow_nan=False))
    else:
        from swimlab.cli.scores import print_scores

        print_scores([scores])
    return 0


def measure_with_progress(run: Path, domain: Domain, *, quiet: bool) -> dict[str, Any]:
    """Measure a run, showing how far it is."""
    from swimlab.measure import measure_run
    from swimlab.record import REFERENCE

    record = Record.read(run)
    tests = [name for name in record.techniques if name != REFERENCE]
    with progress(f"measuring {record.sequence['name']}", len(tests), quiet=quiet) as advance:
        return measure_run(run, domain=domain, command=shlex.join(["swimlab", *sys.argv[1:]]), advance=advance)
